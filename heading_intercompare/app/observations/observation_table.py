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

"""The table that an observer writes at the quay or on the bridge wing, as observations."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Mapping, NamedTuple

import numpy as np

from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.observations.corrections import Observations
from heading_intercompare.core.observations.sight_lines import quay_angle
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.readers.stamp_columns import find_time_columns, StampColumns, TIMES
from heading_intercompare.readers.stream_recording import ReaderError

from .targets import OWN_BEARINGS, Target


class _Range(NamedTuple):
    low: float
    high: float


_ANGLE, _SIZE = _Range(-360.0, 360.0), _Range(0.0, 180.0)

COLUMNS: Mapping[str, _Range] = {
    'true_heading_deg': _ANGLE, 'true_bearing_deg': _ANGLE, 'reciprocal_bearing_deg': _ANGLE,
    'relative_bearing_deg': _ANGLE, 'ts_heading_deg': _ANGLE, 'ts_bearing_deg': _ANGLE,
    'fore_m': _Range(-1000.0, 1000.0), 'aft_m': _Range(-1000.0, 1000.0),
    'base_m': _Range(0.1, 1000.0), 'latitude_deg': _Range(-90.0, 90.0),
    'longitude_deg': _Range(-180.0, 360.0), 'u_deg': _SIZE, 'common_u_deg': _SIZE,
    'time_u_s': _Range(0.0, 3600.0)}
"""The columns of numbers, with the values allowed; beside them stand a time, `side`, `note`."""

_WANTED = f'of times ({", ".join(TIMES)}) and of observations, such as true_heading_deg'
_OBSERVED = ('true_heading_deg, relative_bearing_deg, ts_bearing_deg, or fore_m, aft_m, base_m '
             'and side')
_QUAY = ('fore_m', 'aft_m', 'base_m')


@dataclass(frozen=True, slots=True)
class ObservationTable:
    """
    The observations of a table, in its order.

    Attributes
    ----------
    notes : tuple of str
        What the observer wrote, one per row; may be empty.
    common_u_deg
        Largest entry of the column of that name; None without one.
    target_u_deg
        Standard uncertainty that all rows share through the points of the target, degrees.
    target
        What bearings were taken of, in words.
    ts_step_deg
        Step of the readings of the TS as they are written; None without such readings.
    ignored
        Columns that are not read.

    """

    observations: Observations
    notes: tuple[str, ...]
    common_u_deg: float | None
    target_u_deg: float
    target: str
    ts_step_deg: float | None
    ignored: tuple[str, ...]


class _Row(NamedTuple):
    line: int
    stamp_ns: int
    numbers: Mapping[str, float]
    side: str
    note: str


def read_observation_table(path: str, target: Target | None = None, *, u_deg: float = 0.0,
                           time_u_s: float = 0.0,
                           position: tuple[float, ...] | None = None) -> ObservationTable:
    """
    Read a table of observations.

    Parameters
    ----------
    path
        A csv with a header; see `CsvRows` for its form and `COLUMNS` for its columns. A cell may
        be empty.
    target
        Gives the true bearing of rows without one.
    u_deg, time_u_s
        Standard uncertainties of rows without their own.
    position
        Latitude and longitude of rows without their own, degrees.

    Returns
    -------
    ObservationTable

    Raises
    ------
    OSError
        If the file cannot be read.
    ReaderError
        If the form is wrong, or a row has no observation or two; names the line.
    ModuleNotFoundError
        If the azimuth of the sun is wanted and `ephem` is not installed.

    """
    target = Target() if target is None else target
    rows, names, step = _read_rows(path)
    if not rows:
        raise ReaderError(path, 'has a header and no observation')
    latitude, longitude = position or (math.nan, math.nan)
    columns = {name: np.array([row.numbers.get(name, math.nan) for row in rows])
               for name in COLUMNS}
    places = [np.where(np.isfinite(columns[name]), columns[name], default) for name, default in (
        ('latitude_deg', latitude), ('longitude_deg', longitude))]
    stamps = np.array([row.stamp_ns for row in rows], np.int64)
    seen = target.find_bearings(stamps, *places)
    stated_bearing = np.where(
        np.isfinite(columns['true_bearing_deg']), columns['true_bearing_deg'],
        columns['reciprocal_bearing_deg'] + 180.0)
    bearing = np.where(np.isfinite(stated_bearing), stated_bearing, seen.bearing_deg)
    true, ts = np.empty((2, len(rows)))
    by_target = ~np.isfinite(columns['true_heading_deg']) & ~np.isfinite(stated_bearing)
    for i, row in enumerate(rows):
        try:
            true[i], ts[i] = _combine(row, float(bearing[i]))
            if seen.below_horizon[i] and by_target[i]:
                raise ValueError('the sun is below the horizon: check the time, which is UTC, '
                                 'and the position')
            if math.isnan(true[i]):
                raise ValueError(_lacking_bearing(target))
        except ValueError as error:
            raise ReaderError(path, f'line {row.line}: {error}') from None
    common = columns['common_u_deg'][np.isfinite(columns['common_u_deg'])]
    observations = Observations(
        stamp_ns=stamps, true_deg=wrap360(true), ts_deg=ts,
        turn_deg_s=np.where(by_target, seen.turn_deg_s, 0.0),
        u_deg=np.where(np.isfinite(columns['u_deg']), columns['u_deg'], u_deg),
        time_u_s=np.where(np.isfinite(columns['time_u_s']), columns['time_u_s'], time_u_s))
    return ObservationTable(
        observations=observations, notes=tuple(row.note for row in rows),
        common_u_deg=float(common.max()) if common.size else None,
        target_u_deg=seen.common_u_deg if by_target.any() else 0.0,
        target=seen.words if by_target.any() else OWN_BEARINGS, ts_step_deg=step,
        ignored=tuple(name for name in names if name and name not in (
            *COLUMNS, 'side', 'note', *find_time_columns(names))))


def _read_rows(path: str) -> tuple[list[_Row], list[str], float | None]:
    """Return the rows, the names of the header, and the step of the TS as written."""
    observed_rows, decimals = [], []
    try:
        with CsvRows(path, _WANTED) as rows:
            times = find_time_columns(rows.names)
            if not times or times[-1].lower().endswith('dday'):
                raise ReaderError(path, f'has no column of times ({", ".join(TIMES[:10])})')
            stamps = StampColumns(path, rows.names)
            for cells in rows:
                named = dict(zip(rows.names, map(str.strip, cells)))
                try:
                    stamp_ns = stamps.read(rows, cells)
                except Rejected:
                    time = ' and '.join(stamps.names)
                    cell = ' '.join(named[name] for name in stamps.names)
                    raise ReaderError(
                        path, f'line {rows.line}: {time} = {cell!r} must be a time such as '
                        '2026-03-10 10:05:30, UTC, with date and seconds') from None
                numbers = {name: _number(rows, path, name, named[name])
                           for name in COLUMNS if named.get(name)}
                decimals += [len(rows.plain(named[name]).partition('.')[2])
                             for name in ('ts_heading_deg', 'ts_bearing_deg') if named.get(name)]
                observed_rows.append(_Row(rows.line, stamp_ns, numbers,
                                          named.get('side', '').lower(), named.get('note', '')))
            names = rows.names
    except BagError as error:
        raise ReaderError(path, error.problem) from None
    return observed_rows, names, 10.0 ** -max(decimals) if decimals else None


def _number(rows: CsvRows, path: str, name: str, cell: str) -> float:
    allowed = COLUMNS[name]
    try:
        value = float(rows.plain(cell))
    except ValueError:
        value = math.nan
    if not allowed.low <= value <= allowed.high:
        raise ReaderError(
            path, f'line {rows.line}: {name} = {cell[:40]!r} must be a number from '
            f'{allowed.low:g} to {allowed.high:g}{rows.why_no_number(cell)}')
    return value


def _combine(row: _Row, bearing_deg: float) -> tuple[float, float]:
    """Return what the TS should show, and what it was read to show (nan: not read)."""
    numbers = row.numbers
    if {'true_bearing_deg', 'reciprocal_bearing_deg'} <= {*numbers}:
        raise ValueError('has true_bearing_deg and reciprocal_bearing_deg: give one of them')
    quay = [name for name in _QUAY if name in numbers]
    forms = [name for name in ('true_heading_deg', 'relative_bearing_deg', 'ts_bearing_deg')
             if name in numbers] + quay[:1]
    if len(forms) != 1:
        raise ValueError(f'has {" and ".join(forms) or "no observation"}: give one of '
                         f'{_OBSERVED}')
    ts_deg = numbers.get('ts_heading_deg', math.nan)
    if forms == ['true_heading_deg']:
        return numbers['true_heading_deg'], ts_deg
    if forms == ['relative_bearing_deg']:
        return bearing_deg - numbers['relative_bearing_deg'], ts_deg
    if forms == ['ts_bearing_deg']:
        if not math.isnan(ts_deg):
            raise ValueError('has ts_heading_deg and ts_bearing_deg: give one of them')
        return bearing_deg, numbers['ts_bearing_deg']
    if len(quay) < len(_QUAY):
        raise ValueError(f'has {" and ".join(quay)}: give {", ".join(_QUAY)} and side')
    return bearing_deg + quay_angle(numbers['fore_m'], numbers['aft_m'], numbers['base_m'],
                                    row.side), ts_deg


def _lacking_bearing(target: Target) -> str:
    """Return what a row without a true bearing needs."""
    if target.kind in ('sun', 'mark'):
        return ('has no position: give the columns latitude_deg and longitude_deg, or --position')
    return ('has no true bearing: give the column true_bearing_deg or reciprocal_bearing_deg, or '
            '--bearing, --line, --mark or --sun')
