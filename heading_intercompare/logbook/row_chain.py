# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""
The chain of a logbook: a hash for each row that was written, each over the one before.

The chain is a table that only grows. A row that SQLite itself changed, took out or put in does not
fit it. A reader who noted the newest hash can tell later that no row up to it was changed, even by
a forger who made the whole chain new.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
from typing import Any, Iterable, Iterator, Mapping, NamedTuple, Sequence

_CREATE = ('CREATE TABLE chain (entry INTEGER PRIMARY KEY, run_id INTEGER NOT NULL, '
           'row_sha256 TEXT NOT NULL, sha256 TEXT NOT NULL)',
           'CREATE INDEX chain_of_run ON chain (run_id)')

_START = '0' * 64
#: Rows that are hashed together, few enough for the cache of a processor.
_ROWS_TOGETHER = 1000


class ChainHead(NamedTuple):
    """The newest entry of a chain: its number, and its hash, which covers all before it."""

    entry: int
    sha256: str


def create_chain(connection: sqlite3.Connection) -> None:
    """Create the table of an empty chain."""
    for command in _CREATE:
        connection.execute(command)


def hash_row(cells: Mapping[str, Any]) -> str:
    """Return the hash of a row; a cell without a value, also of a later version, adds nothing."""
    text = json.dumps({name: cell for name, cell in cells.items()
                       if name != 'id' and cell is not None}, sort_keys=True)
    return hashlib.sha256(text.encode('ascii')).hexdigest()


def _link(before: str, run_id: int, row_sha256: str) -> str:
    return hashlib.sha256(f'{before} {run_id} {row_sha256}'.encode('ascii')).hexdigest()


def read_head(connection: sqlite3.Connection) -> ChainHead:
    """Return the newest entry; number 0 if there is none."""
    newest = connection.execute(
        'SELECT entry, sha256 FROM chain ORDER BY entry DESC LIMIT 1').fetchone()
    return ChainHead(*newest) if newest else ChainHead(0, _START)


def append_rows(connection: sqlite3.Connection, rows: Iterable[Mapping[str, Any]]) -> None:
    """Append an entry for each row that was written, unless it is the same as before."""
    entry, sha256 = read_head(connection)
    for cells in rows:
        run_id, row_sha256 = cells['id'], hash_row(cells)
        newest = connection.execute('SELECT row_sha256 FROM chain WHERE run_id = ? '
                                    'ORDER BY entry DESC LIMIT 1', (run_id,)).fetchone()
        if newest == (row_sha256,):
            continue
        entry, sha256 = entry + 1, _link(sha256, run_id, row_sha256)
        connection.execute('INSERT INTO chain VALUES (?, ?, ?, ?)',
                           (entry, run_id, row_sha256, sha256))


def find_break(connection: sqlite3.Connection, names: Sequence[str],
               rows: Sequence[tuple[Any, ...]]) -> str | None:
    """
    Return what does not fit the chain, in words; None if all does.

    Parameters
    ----------
    connection
        The logbook.
    names
        The columns of its rows.
    rows
        The cells of all its rows.

    """
    newest: dict[int, str] = {}
    sha256 = _START
    for number, (entry, run_id, row_sha256, linked) in enumerate(connection.execute(
            'SELECT entry, run_id, row_sha256, sha256 FROM chain ORDER BY entry'), 1):
        sha256 = _link(sha256, run_id, row_sha256)
        if entry != number or linked != sha256:
            return f'entry {entry} of its chain does not follow from the one before'
        newest[run_id] = row_sha256
    at_id = names.index('id')
    for row, row_sha256 in zip(rows, _hash_rows(names, rows)):
        expected = newest.pop(row[at_id], None)
        if expected is None:
            return f'row {row[at_id]} was put in by another program'
        if expected != row_sha256 and expected != _hash_any(dict(zip(names, row))):
            return f'row {row[at_id]} was changed after it was written'
    return f'row {min(newest)} was taken out' if newest else None


def _hash_any(cells: Mapping[str, Any]) -> str | None:
    """Return the hash of a row; None if a cell holds bytes, which no row has."""
    try:
        return hash_row(cells)
    except TypeError:
        return None


def _hash_rows(names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> Iterator[str]:
    """
    Yield the hash of each row as `hash_row` does, but in a third of its time.

    The text is made a column at a time. Where JSON writes a cell in another way, such as an
    infinite figure, the hash is one that no row has.
    """
    for start in range(0, len(rows), _ROWS_TOGETHER):
        template = ''
        columns: list[Iterable[Any]] = []
        for name, column in sorted(zip(names, zip(*rows[start:start + _ROWS_TOGETHER]))):
            if name != 'id' and column.count(None) < len(column):
                form, cells = _write_column(name, column)
                template += form
                columns.append(cells)
        for row in zip(*columns):
            text = (template % row).removeprefix(', ')
            yield hashlib.sha256(f'{{{text}}}'.encode('utf-8', 'replace')).hexdigest()


def _write_column(name: str, column: Sequence[Any]) -> tuple[str, Iterable[Any]]:
    """Return how a column stands in the text of its rows: a form of `%`, and its cells for it."""
    key, kinds = f', {json.dumps(name)}: ', {*map(type, column)}
    form = key.replace('%', '%%')
    if kinds == {str}:
        text_of = {cell: json.dumps(cell) for cell in {*column}}
        return f'{form}%s', map(text_of.__getitem__, column)
    if kinds <= {str, int, float, type(None)} and not kinds <= {int, float}:
        return '%s', ('' if cell is None else key + json.dumps(cell) for cell in column)
    return f'{form}%r', column
