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
The file of a logbook: SQLite, a row per run, and the chain of their hashes.

Every operation opens the file and closes it again. A transaction is on the disk when `write`
returns, and a process that is killed leaves either all of it or nothing. The journal is the
rollback journal of SQLite, not its write-ahead log: a logbook stays one file, which can be copied
and read from a disk without write access.
"""

from __future__ import annotations

from contextlib import closing, contextmanager
from dataclasses import replace
import json
from operator import itemgetter
import os
from pathlib import Path
import sqlite3
from typing import Any, get_args, get_origin, get_type_hints, Iterator, Sequence

from heading_intercompare.core.typed_reader import read_plain, VerdictError
from heading_intercompare.core.utc_text import utc

from .row_chain import append_rows, ChainHead, create_chain, find_break, read_head
from .row_consistency import find_contradiction
from .run_record import hash_record
from .run_row import RunRow

VERSION = 4
"""
Version of the tables (PRAGMA user_version).

1 lacks the columns of installation offset and deviation, 2 the chain, 3 the records of the runs.
"""
_WITH_CHAIN = 3
#: 'HILB', which `file` and SQLite show (PRAGMA application_id).
_APPLICATION = 0x48494C42

_KEY = ('ship', 'start_ns', 'end_ns', 'settings_sha256')
#: Rows that become objects together.
_ROWS_TOGETHER = 1000
_TYPES = {str: 'TEXT', int: 'INTEGER', float: 'REAL'}


class LogbookError(ValueError):
    """A logbook cannot be read or written; one line with its path and the reason."""


class LogbookBusy(LogbookError):
    """Another process is writing; try again later."""


_COLUMNS = RunRow.columns()
_HINTS = get_type_hints(RunRow)
#: Columns of several figures, which hold JSON.
_LISTS = {name: hint for name, hint in _HINTS.items()
          if any(get_origin(kind) is tuple for kind in get_args(hint))}
_MATRICES = {name for name, hint in _LISTS.items() if 'tuple[tuple' in str(hint)}


def _declare_column(name: str) -> str:
    """Return a column of the table with its type."""
    kinds = get_args(_HINTS[name]) or (_HINTS[name],)
    kind = 'TEXT' if name in _LISTS else _TYPES[kinds[0]]
    return f'{name} {kind}{"" if type(None) in kinds else " NOT NULL"}'


#: Columns of version 2, with which the table of version 1 is extended.
_OF_DEVIATION = ('installation_offset_deg', 'deviation_coefficients_deg',
                 'deviation_covariance_deg2', 'empty_arc_deg')
_ADDED = (*_OF_DEVIATION, 'record_sha256')
_CREATE = (f'CREATE TABLE runs (id INTEGER PRIMARY KEY, '
           f'{", ".join(map(_declare_column, _COLUMNS))}, UNIQUE ({", ".join(_KEY)}))')
# A row that knows its recording, or the columns of version 2, does not lose them to one that
# does not.
_CREATE_RECORDS = ('CREATE TABLE IF NOT EXISTS records (run_id INTEGER PRIMARY KEY, '
                   'record BLOB NOT NULL)')
_KEEP = {**{name: f'coalesce(excluded.{name}, runs.{name})' for name in ('bag', 'record_sha256')},
         **{name: f'iif(excluded.installation_offset_deg IS NULL, runs.{name}, excluded.{name})'
            for name in _OF_DEVIATION}}
# The id of a row that was taken out stays its own, so that the chain misses it.
_NEXT_ID = ('SELECT 1 + max((SELECT coalesce(max(id), 0) FROM runs), '
            '(SELECT coalesce(max(run_id), 0) FROM chain))')
_WRITE = (f'INSERT INTO runs (id, {", ".join(_COLUMNS)}) '
          f'VALUES (({_NEXT_ID}), {", ".join("?" * len(_COLUMNS))}) '
          f'ON CONFLICT ({", ".join(_KEY)}) DO UPDATE SET '
          + ', '.join(f'{name} = {_KEEP.get(name, f"excluded.{name}")}'
                      for name in _COLUMNS if name not in _KEY)
          + ' RETURNING id')
_SELECT = 'SELECT * FROM runs'
_SELECT_RECORD = ('SELECT record FROM records WHERE run_id = (SELECT id FROM runs WHERE '
                  f'{" AND ".join(f"{name} = ?" for name in _KEY)})')


def is_of_ship(name: str, ship: str | None) -> bool:
    """Tell whether a run of this name is of a ship, or of SHIP/SENSOR; None is any."""
    return ship is None or f'{name}/'.startswith(f'{ship}/')


def to_cells(row: RunRow) -> list[Any]:
    """Return the cells of a row in the order of its columns; several figures are JSON."""
    return [json.dumps(value, allow_nan=False) if isinstance(value, tuple) else value
            for value in (getattr(row, name) for name in _COLUMNS)]


def _choose(names: Sequence[str], rows: Sequence[tuple[Any, ...]], since_ns: int | None,
            ship: str | None) -> list[tuple[Any, ...]]:
    """Return the cells of the rows of a ship since a stamp, in the order of time."""
    at_start, at_end, at_ship = map(names.index, ('start_ns', 'end_ns', 'ship'))
    return sorted((row for row in rows if (since_ns is None or row[at_end] >= since_ns)
                   and is_of_ship(row[at_ship], ship)), key=itemgetter(at_start, at_end, at_ship))


def _to_rows(names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> list[RunRow]:
    """Return the rows of cells; a column that is missing is unknown."""
    run_rows = []
    for start in range(0, len(rows), _ROWS_TOGETHER):
        cells_of = dict(zip(names, zip(*rows[start:start + _ROWS_TOGETHER])))
        for name in _LISTS.keys() & cells_of.keys():
            cells_of[name] = tuple(_read_lists(name, cells_of['id'], cells_of[name]))
        unknown = (None,) * len(cells_of['id'])
        for row_id, *cells in zip(*(cells_of.get(name, unknown) for name in ('id', *_COLUMNS))):
            row = RunRow(*cells)
            if contradiction := find_contradiction(row):
                raise LogbookError(f'row {row_id}, {contradiction}: the row was changed')
            run_rows.append(row)
    return run_rows


def _read_lists(name: str, ids: Sequence[int], cells: Sequence[Any]) -> Iterator[Any]:
    """Yield the figures in the cells of a column of lists."""
    for row_id, cell in zip(ids, cells):
        try:
            figures = json.loads(cell or 'null')
            yield (_to_floats(figures, name in _MATRICES)
                   or read_plain(_LISTS[name], figures, name))
        except (json.JSONDecodeError, TypeError, VerdictError):
            raise LogbookError(f'row {row_id}, column {name} ({cell!r:.40}): must be '
                               'a JSON list of numbers') from None


def _to_floats(figures: Any, of_matrix: bool) -> tuple[Any, ...] | None:
    """Return a list of floats, or of rows of floats, as tuples; None for all else."""
    if type(figures) is not list:
        return None
    if of_matrix:
        rows = [_to_floats(row, False) for row in figures]
        return None if None in rows else tuple(rows)
    return tuple(figures) if {*map(type, figures)} == {float} else None


def _read_cells(connection: sqlite3.Connection, question: str,
                values: Sequence[Any] = ()) -> list[dict[str, Any]]:
    """Return rows as their cells by column."""
    rows = connection.execute(question, values)
    names = [column[0] for column in rows.description]
    return [dict(zip(names, row)) for row in rows]


def _has_table(connection: sqlite3.Connection, name: str) -> bool:
    return bool(connection.execute(
        'SELECT count(*) FROM sqlite_master WHERE name = ?', (name,)).fetchone()[0])


def _has_chain(connection: sqlite3.Connection) -> bool:
    return _has_table(connection, 'chain')


def _renew(connection: sqlite3.Connection) -> None:
    """Make the tables those of this version; a new chain begins with the rows that are there."""
    there = {row[1] for row in connection.execute('PRAGMA table_info(runs)')}
    for name in _ADDED:
        if name not in there:
            connection.execute(f'ALTER TABLE runs ADD COLUMN {_declare_column(name)}')
    if not _has_chain(connection):
        create_chain(connection)
        append_rows(connection, _read_cells(connection, f'{_SELECT} ORDER BY id'))
    connection.execute(_CREATE_RECORDS)
    connection.execute(f'PRAGMA user_version = {VERSION}')


class Logbook:
    """
    A logbook in a file.

    Parameters
    ----------
    path
        The file; `write` creates it, in a folder that exists.
    timeout_s
        How long to wait while another process writes, seconds.

    """

    def __init__(self, path: str | os.PathLike[str], timeout_s: float = 10.0) -> None:
        self.path = os.fspath(path)
        self._timeout_s = timeout_s

    def write(self, rows: Sequence[RunRow]) -> None:
        """
        Write rows in one transaction; a row about a run that is there replaces it.

        Raises
        ------
        LogbookBusy
            If another process is writing all the time.
        LogbookError
            If the file is no logbook, is of a newer version, or cannot be written.

        """
        with self._open(write=True) as connection:
            # A row names only the record that comes with it.
            written = [connection.execute(_WRITE, to_cells(
                row if row.record is not None else replace(row, record_sha256=None))).fetchone()
                for row in rows]
            connection.executemany(
                'INSERT OR REPLACE INTO records VALUES (?, ?)',
                [(*run_id, row.record) for run_id, row in zip(written, rows)
                 if row.record is not None])
            append_rows(connection, (
                cells for run_id in written
                for cells in _read_cells(connection, f'{_SELECT} WHERE id = ?', run_id)))

    def check(self) -> None:
        """Raise LogbookError unless rows can be written; create the logbook if it is not there."""
        self.write([])

    def read(self, *, since_ns: int | None = None, ship: str | None = None) -> list[RunRow]:
        """
        Return the rows in the order of time.

        Parameters
        ----------
        since_ns
            Only runs that end at or after this stamp.
        ship
            Only runs of this ship, with all its sensors, or of SHIP/SENSOR.

        Raises
        ------
        LogbookBusy
            If another process is writing all the time.
        LogbookError
            If there is no such file, the file is no logbook, or a logbook of a newer version, or
            a row was changed, put in or taken out by another program.

        """
        return self._read(since_ns, ship)[0]

    def read_with_head(self, ship: str | None = None) -> tuple[list[RunRow], ChainHead | None]:
        """
        Return the rows of a ship, as `read` does, and the newest entry of the chain of all rows.

        Both are of one transaction. A logbook of before version 3 has no chain, so no entry.
        """
        return self._read(None, ship)

    def _read(self, since_ns: int | None,
              ship: str | None) -> tuple[list[RunRow], ChainHead | None]:
        with self._open(write=False) as connection:
            answer = connection.execute(f'{_SELECT} ORDER BY id')
            names = [column[0] for column in answer.description]
            rows = answer.fetchall()
            chained = _has_chain(connection)
            changed = find_break(connection, names, rows) if chained else None
            head = read_head(connection) if chained else None
        try:
            if changed:
                raise LogbookError(f'{changed}; what the program wrote is no longer known')
            return _to_rows(names, _choose(names, rows, since_ns, ship)), head
        except LogbookError as error:
            raise LogbookError(f'{self.path}: {error}') from None

    def read_records(self, rows: Sequence[RunRow]) -> list[RunRow]:
        """
        Return rows of this logbook with the records of their runs; one without stays as it is.

        Raises
        ------
        LogbookError
            As `read`, or if a record is missing or was changed.

        """
        with self._open(write=False) as connection:
            records = [None if row.record_sha256 is None else connection.execute(
                _SELECT_RECORD, row.key).fetchone() for row in rows]
        for row, cells in zip(rows, records):
            if row.record_sha256 is not None and (
                    cells is None or not isinstance(cells[0], bytes)
                    or hash_record(cells[0]) != row.record_sha256):
                raise LogbookError(f'{self.path}: the record of the run of {utc(row.start_ns)} '
                                   f'UTC was {"taken out" if cells is None else "changed"}')
        return [row if cells is None else replace(row, record=cells[0])
                for row, cells in zip(rows, records)]

    def read_head(self) -> ChainHead | None:
        """Return the newest entry of the chain; None for a logbook of before version 3."""
        with self._open(write=False) as connection:
            return read_head(connection) if _has_chain(connection) else None

    @contextmanager
    def _open(self, *, write: bool) -> Iterator[sqlite3.Connection]:
        """Open the file for one transaction; errors name the file."""
        try:
            # Inside `with connection` the transaction is committed, or taken back on an error.
            with closing(self._connect(write)) as connection, connection:
                connection.execute('BEGIN IMMEDIATE' if write else 'BEGIN')
                self._check_version(connection, write)
                yield connection
        except sqlite3.Error as error:
            raise self._explain(error, write) from error

    def _connect(self, write: bool) -> sqlite3.Connection:
        if not write and not os.path.isfile(self.path):
            raise LogbookError(f'{self.path}: there is no such logbook')
        # A reader, too, may have to clear up after a writer that was killed.
        mode = 'rwc' if write else 'rw'
        uri = f'{Path(self.path).absolute().as_uri()}?mode={mode}'
        connection = sqlite3.connect(uri, uri=True, timeout=self._timeout_s, isolation_level=None)
        connection.execute('PRAGMA synchronous = FULL')
        return connection

    def _check_version(self, connection: sqlite3.Connection, write: bool) -> None:
        def ask(question: str) -> Any:
            return connection.execute(question).fetchone()[0]

        application, version = ask('PRAGMA application_id'), ask('PRAGMA user_version')
        tables = ask('SELECT count(*) FROM sqlite_master')
        if write and not (application or version or tables):
            connection.execute(f'PRAGMA application_id = {_APPLICATION}')
            connection.execute(f'PRAGMA user_version = {VERSION}')
            connection.execute(_CREATE)
            connection.execute(_CREATE_RECORDS)
            create_chain(connection)
        elif application != _APPLICATION:
            raise LogbookError(f'{self.path}: is not a logbook of heading_intercompare')
        elif version > VERSION:
            raise LogbookError(f'{self.path}: is a logbook of version {version}, this program '
                               f'knows version {VERSION}: a newer heading_intercompare wrote it; '
                               'install that')
        elif version >= _WITH_CHAIN and not _has_chain(connection):
            raise LogbookError(f'{self.path}: the chain of its rows was taken out; what the '
                               'program wrote is no longer known')
        elif trigger := connection.execute(
                "SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchone():
            raise LogbookError(f'{self.path}: has the trigger {trigger[0]!r:.40}, which changes '
                               'rows as they are written; what the program wrote is no longer '
                               'known')
        elif write and version < VERSION:
            _renew(connection)

    def _explain(self, error: sqlite3.Error, write: bool) -> LogbookError:
        words = ' '.join(str(error).split())
        code = getattr(error, 'sqlite_errorcode', None)
        busy = code is not None and code & 0xFF in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED)
        if busy or 'locked' in words:
            return LogbookBusy(f'{self.path}: another process is writing to it; try again')
        if 'not a database' in words:
            words = 'is not a logbook of heading_intercompare'
        elif 'unable to open' in words:
            words = 'cannot be opened' + ('; is there a folder for it, with leave to write?'
                                          if write else '')
        return LogbookError(f'{self.path}: {words}')


def merge_logbooks(into: Logbook, sources: Sequence[Logbook]) -> int:
    """
    Write the rows of logbooks into another, for a fleet; return the number of rows read.

    Merging the same logbooks again changes nothing. A source that cannot be read raises
    `LogbookError` before anything is written.
    """
    rows = [row for source in sources for row in source.read_records(source.read())]
    into.write(rows)
    return len(rows)
