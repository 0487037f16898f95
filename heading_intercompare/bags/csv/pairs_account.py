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
The account beside a csv of pairs: what the pairs alone cannot say.

It has the ledger of the readings that made the pairs, the marks or the table of the runs, the
settings, and where the readings come from. So a csv is judged as the recording that it came from.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
import binascii
from dataclasses import dataclass, fields
import hashlib
import json
import os
from pathlib import Path
from typing import Any, Mapping, NamedTuple

import numpy as np

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment
from heading_intercompare.core.raw_streams.stamp_jumps import SetBack
from heading_intercompare.core.records import (
    Integers,
    Motion,
    MOTION_COLUMNS,
    Pairs,
    Quality,
    QUALITY_FLAGS,
    Reals,
)
from heading_intercompare.core.typed_reader import make_plain, read_plain, VerdictError
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.core.version import VERSION
from heading_intercompare.replaced_file import replace_file

#: The word of the account for what rows tell.
_WORDS = {'fix': 'position', 'velocity': 'velocity', 'rate': 'rate'}


def text_of_motion(motion: Motion) -> dict[str, str] | None:
    """
    Return the motion as text; None if there is none.

    Parameters
    ----------
    motion
        In any order.

    Returns
    -------
    dict of str to str, or None
        Base64 of the columns, each little-endian and whole: the stamps as int64, then the reals
        as float64; by what the rows tell: 'position', 'velocity', 'rate'.

    """
    texts = {}
    for what, rows in motion.split().items():
        if len(rows):
            texts[_WORDS[what]] = _join_columns(
                rows.stamp_ns, *(getattr(rows, name) for name in MOTION_COLUMNS[what]))
    return texts or None


def _join_columns(*columns: Integers | Reals) -> str:
    """Return the bytes of whole columns, little-endian, as text."""
    return b64encode(b''.join(column.astype(column.dtype.newbyteorder('<')).tobytes()
                              for column in columns)).decode('ascii')


def _cut_columns(place: str, text: str, width: int) -> list[bytes]:
    """Return the bytes of each column of a text; ValueError unless it has whole rows."""
    try:
        data = b64decode(text, validate=True)
    except binascii.Error as error:
        raise ValueError(f'{place} is no base64: {error}') from None
    if not width or len(data) % (8 * width):
        raise ValueError(f'{place} has {len(data)} bytes: must be whole rows')
    size = len(data) // width
    return [data[size * at:size * (at + 1)] for at in range(width)]


def text_of_quality(quality: Mapping[str, Quality]) -> dict[str, str] | None:
    """Return what ``'ts'`` and ``'rs'`` say of their readings as text; None if nothing."""
    return {stream: _join_columns(rows.stamp_ns, rows.stated_deg, rows.flag)
            for stream, rows in quality.items() if len(rows)} or None


def quality_of_text(text: Mapping[str, str] | None) -> dict[str, Quality]:
    """
    Return the quality in a text of `text_of_quality`.

    Raises
    ------
    ValueError
        If the text is not one.

    """
    quality = {}
    for stream, columns in (text or {}).items():
        stamps, stated_deg, flags = _cut_columns(f'quality.{stream}', columns, 3)
        rows = Quality.of(np.frombuffer(stamps, '<i8').astype(np.int64),
                          np.frombuffer(stated_deg, '<f8').astype(np.float64),
                          np.frombuffer(flags, '<i8').astype(np.int64))
        if stream not in ('ts', 'rs') or ((rows.flag < 0) | (
                rows.flag >= len(QUALITY_FLAGS)) | (rows.stated_deg <= 0.0)).any():
            raise ValueError(f'quality.{stream} has a sensor, a flag or a claim that is none')
        quality[stream] = rows
    return quality


def motion_of_text(text: Mapping[str, str] | None) -> Motion:
    """
    Return the motion in a text of `text_of_motion`.

    Raises
    ------
    ValueError
        If the text is not one.

    """
    chunks = []
    things = {word: what for what, word in _WORDS.items()}
    for word, columns in (text or {}).items():
        what = things.get(word, '')
        names = MOTION_COLUMNS.get(what)
        stamps, *reals = _cut_columns(f'motion.{word}', columns,
                                      0 if names is None else 1 + len(names))
        chunks.append(Motion.of(what, np.frombuffer(stamps, '<i8').astype(np.int64), *(
            np.frombuffer(column, '<f8').astype(np.float64) for column in reals)))
    return Motion.concatenate(chunks)


_SCHEMA = 'heading_intercompare/pairs_account/1'
#: An account of a year of hourly runs has some megabytes.
_MOST_BYTES = 1 << 28
_MARKS = ('start', 'stop')
_REMOVE = 'remove it to judge the pairs alone'


@dataclass(frozen=True, slots=True)
class PairsAccount:
    """
    What belongs to a csv of pairs.

    Attributes
    ----------
    inputs
        The recordings whose readings were paired, with hashes, topics, notes and problems.
    settings
        Settings of the analysis that made the pairs, by dotted name.
    marks
        Marks of runs: 'start' or 'stop' and the stamp, nanoseconds.
    table
        Start and stop of the runs, nanoseconds, if a table gave them.
    newest_ns
        Newest stamp received.
    segments
        The ledger; see `ledger`.
    set_backs
        The times at which a clock was set back.

    """

    inputs: tuple[Input, ...]
    settings: Mapping[str, Any]
    marks: tuple[tuple[str, int], ...]
    table: tuple[tuple[int, int], ...] | None
    newest_ns: int | None
    segments: tuple[LedgerSegment, ...]
    set_backs: tuple[SetBack, ...]
    software_version: str = VERSION
    motion: Mapping[str, str] | None = figure('motion of the ship', absent='if unknown')
    quality: Mapping[str, str] | None = figure('what the sensors say of their readings',
                                               absent='if they say nothing')

    @property
    def ledger(self) -> Ledger:
        """Return the account of every reading."""
        return Ledger.from_segments(self.segments, self.newest_ns, self.set_backs)


def account_path(csv: str | os.PathLike[str]) -> Path:
    """
    Return the path of the account beside a csv of pairs.

    Examples
    --------
    >>> account_path('trial/pairs.csv').name
    'pairs.csv.account.json'

    """
    return Path(f'{os.fspath(csv)}.account.json')


class PairsDigest:
    """
    The hash of pairs, however they are cut into chunks and written as text.

    A heading that is not finite counts as nan, as in a csv.

    Examples
    --------
    >>> one, two, pairs = PairsDigest(), PairsDigest(), Pairs.of([5, 6], [1.0, 2.0], [3.0, 4.0])
    >>> one.update(pairs)
    >>> for part in (pairs[:1], pairs[1:]):
    ...     two.update(part)
    >>> one.hexdigest() == two.hexdigest()
    True

    """

    def __init__(self) -> None:
        self._names = [f.name for f in fields(Pairs) if f.name != 'segment']
        self._columns = [hashlib.sha256() for _ in self._names]

    def update(self, pairs: Pairs) -> None:
        """Take pairs."""
        for name, digest in zip(self._names, self._columns):
            column = getattr(pairs, name)
            if column.dtype.kind == 'f':
                # There are many nan, and two zeros.
                column = np.where(np.isfinite(column), column, np.nan) + 0.0
            digest.update(np.ascontiguousarray(column, column.dtype.newbyteorder('<')).data)

    def hexdigest(self) -> str:
        """Return the hash of the pairs so far."""
        return hashlib.sha256(b''.join(column.digest() for column in self._columns)).hexdigest()


class Fingerprint(NamedTuple):
    """
    The hashes of a csv of pairs.

    Attributes
    ----------
    csv_sha256
        Of the bytes of the file.
    pairs_sha256
        Of the pairs in it, from `PairsDigest`: the same after a spreadsheet has saved it, unless
        that rounded its numbers.

    """

    csv_sha256: str
    pairs_sha256: str


def write_account(csv: str | os.PathLike[str], account: PairsAccount, of: Fingerprint) -> None:
    """
    Write the account beside a csv of pairs; an existing one is replaced.

    Parameters
    ----------
    csv
        The csv file.
    account
        Ledger and provenance of these pairs.
    of
        Of the csv file.

    Raises
    ------
    OSError
        If it cannot be written.

    """
    plain = {'schema': _SCHEMA, **of._asdict(), **make_plain(account)}
    text = json.dumps(plain, indent=1, ensure_ascii=False, allow_nan=False)
    replace_file(account_path(csv), f'{text}\n')


def read_account(csv: str | os.PathLike[str]) -> tuple[PairsAccount, Fingerprint] | None:
    """
    Return the account beside a csv of pairs, and of which csv it is; None if there is none.

    Parameters
    ----------
    csv
        The csv file.

    Raises
    ------
    OSError
        If the account cannot be read.
    BagError
        If it is no account.

    """
    path = account_path(csv)
    try:
        with path.open('rb') as file:
            data = file.read(_MOST_BYTES + 1)
    except FileNotFoundError:
        return None
    try:
        if len(data) > _MOST_BYTES:
            raise VerdictError('is too large')
        plain = json.loads(data)
        if not isinstance(plain, dict) or plain.get('schema') != _SCHEMA:
            raise VerdictError(f'is no account of pairs: its schema must be {_SCHEMA!r}')
        account: PairsAccount = read_plain(PairsAccount, plain)
        motion_of_text(account.motion)
        quality_of_text(account.quality)
        for at, segment in enumerate(account.segments):
            if at and segment.start_ns is None and (
                    segment.clock_segment == account.segments[at - 1].clock_segment):
                raise VerdictError(f'segments[{at}].start_ns = None: must be an integer')
        for at, (kind, _) in enumerate(account.marks):
            if kind not in _MARKS:
                raise VerdictError(f"marks[{at}][0] = {kind!r}: must be 'start' or 'stop'")
        return account, Fingerprint(*(str(plain.get(name)) for name in Fingerprint._fields))
    except RecursionError:
        raise BagError(f'is no account of pairs; {_REMOVE}', path) from None
    except ValueError as error:
        raise BagError(f'{error}; {_REMOVE}', path) from None
