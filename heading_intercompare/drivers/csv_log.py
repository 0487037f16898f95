# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Csv of headings, as decoders of NMEA 2000 (PGN 127250) write them.

A header, then one row per reading. Columns `t_ns` (integer nanoseconds UTC) and `heading_deg` are
required. `deviation_deg`, `variation_deg` (east positive), `reference_0true_1mag` and `src` are
used if present. Reference 0 is a true heading; 1 is a magnetic one, to which deviation (0 if
empty) and variation are added. The setting `talker` selects one of several sources; without it,
the first one in the log is used.
"""

from __future__ import annotations

from array import array
from collections import Counter

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Headings

from .sentences import Rejected
from .settings import DriverError, DriverSettings

__all__ = ['CsvDecoder', 'is_csv']

_NEEDED = ('t_ns', 'heading_deg')


def _cells(line: bytes) -> list[str]:
    return [cell.strip() for cell in line.decode('utf-8', 'replace').lstrip('\ufeff').split(',')]


def is_csv(first_line: bytes) -> bool:
    """Tell whether this line is the header of a csv of headings."""
    return b'heading_deg' in first_line and 'heading_deg' in _cells(first_line)


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        raise Rejected('bad_field') from None


class CsvDecoder:
    """
    Turns the bytes of a csv log into headings; used like `NmeaDecoder`.

    Parameters
    ----------
    path : str
        Path of the log, for errors.
    header : bytes
        Its first line.
    settings : DriverSettings
        Only `talker` is used.

    Raises
    ------
    DriverError
        If a required column is missing.

    """

    def __init__(self, path: str, header: bytes, settings: DriverSettings) -> None:
        self._columns = {name: i for i, name in enumerate(_cells(header))}
        missing = [name for name in _NEEDED if name not in self._columns]
        if missing:
            raise DriverError(f'{path}: column {missing[0]} is missing; a csv of headings must '
                              f'have the columns {" and ".join(_NEEDED)}')
        self._src = settings.talker
        self._counts: Counter[str] = Counter()
        self._in_header = True
        self._open = b''

    @property
    def counts(self) -> dict[str, int]:
        """Rows so far that gave no heading, by reason."""
        return dict(sorted(self._counts.items()))

    def feed(self, data: bytes, received_ns: int | None = None) -> Headings:
        """Take bytes and return the headings of the rows that they complete."""
        lines = (self._open + data).split(b'\n')
        self._open = lines.pop()
        if self._in_header and lines:
            self._in_header = False
            del lines[0]
        stamps, headings = array('q'), array('d')
        for line in lines:
            if not line.strip():
                continue
            try:
                stamp_ns, heading_deg = self._read(_cells(line))
            except Rejected as rejected:
                self._counts[rejected.reason] += 1
                continue
            stamps.append(stamp_ns)
            headings.append(heading_deg)
        return Headings(np.array(stamps, np.int64), wrap360(np.array(headings)))

    def flush(self) -> Headings:
        """Return the last headings at the end of the log."""
        return self.feed(b'\n')

    def _read(self, row: list[str]) -> tuple[int, float]:
        columns = self._columns
        if len(row) != len(columns):
            raise Rejected('too_few_fields' if len(row) < len(columns) else 'bad_field')

        def cell(name: str) -> str:
            return row[columns[name]] if name in columns else ''

        src = cell('src')
        if self._src is None and src:
            self._src = src
        if src and src != self._src:
            raise Rejected(f'other_talker.{src}')
        if not cell('heading_deg'):
            raise Rejected('empty_heading')
        heading_deg = _number(cell('heading_deg'))
        if not 0.0 <= heading_deg <= 360.0:
            raise Rejected('out_of_range')
        if cell('reference_0true_1mag') not in ('', '0'):
            if cell('reference_0true_1mag') != '1':
                raise Rejected('bad_field')
            if not cell('variation_deg'):
                raise Rejected('no_variation')
            turn_deg = _number(cell('deviation_deg') or '0') + _number(cell('variation_deg'))
            if not -360.0 <= turn_deg <= 360.0:
                raise Rejected('bad_field')
            heading_deg += turn_deg
        stamp = cell('t_ns')
        if not stamp:
            raise Rejected('no_stamp')
        if not (stamp.isascii() and stamp.isdigit() and int(stamp) < 2 ** 63):
            raise Rejected('bad_stamp')
        return int(stamp), heading_deg
