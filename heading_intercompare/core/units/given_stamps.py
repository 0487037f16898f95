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

"""Stamps as a caller has them, from numpy or pandas, as integer nanoseconds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: 1990-01-01 00:00 UTC. Satellite time, and with it a UTC stamp on a heading, came later.
EARLIEST_NS = 631_152_000 * 10 ** 9
#: 2100-01-01 00:00 UTC, the end of the guess at the unit of small numbers.
_LATEST_NS = 4_102_444_800 * 10 ** 9
#: The last whole second that int64 nanoseconds can hold.
_LAST_S = 9_223_372_036

_UNITS = (('nanoseconds', 1), ('microseconds', 10 ** 3), ('milliseconds', 10 ** 6),
          ('seconds', 10 ** 9))


def find_unit(low: float, high: float) -> tuple[str, int] | None:
    """
    Return the unit in which two numbers are UTC from 1990 to 2100: its name and its nanoseconds.

    Parameters
    ----------
    low, high
        The least and the largest of some times without a unit.

    Returns
    -------
    (str, int) or None
        None if there is none. No number fits two units.

    Examples
    --------
    >>> find_unit(1406851200, 1406937600)
    ('seconds', 1000000000)
    >>> find_unit(0, 1406937600) is None
    True

    """
    return next((unit for unit in _UNITS
                 if EARLIEST_NS <= low * unit[1] and high * unit[1] < _LATEST_NS), None)


def is_of_satellite_time(stamp_ns: Any) -> Any:
    """Tell of a stamp, or of many, whether it lies in 1990 to 2099, the years of `find_unit`."""
    return (EARLIEST_NS <= stamp_ns) & (stamp_ns < _LATEST_NS)


def integer_stamps(stamp_ns: ArrayLike) -> NDArray[np.int64]:
    """
    Return integer nanoseconds of any clock as a column.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Nanoseconds.

    Returns
    -------
    ndarray of int64, shape (n,)

    Raises
    ------
    ValueError
        If they are not integers.

    """
    stamps = np.asarray(stamp_ns)
    if stamps.size and stamps.dtype.kind not in 'iu':
        raise ValueError(f'stamp_ns has dtype {stamps.dtype}: stamps are integer nanoseconds, '
                         'or in Headings.of datetime64')
    integers: NDArray[np.int64] = stamps.astype(np.int64, copy=False)
    return integers if integers.ndim == 1 else integers.reshape(-1)


def utc_stamps(stamps: ArrayLike) -> NDArray[np.int64]:
    """
    Return UTC stamps as integer nanoseconds.

    Parameters
    ----------
    stamps : array_like, shape (n,)
        Integer nanoseconds since 1970-01-01 00:00 UTC; or datetime64 of any unit, from numpy or
        pandas; or datetime objects, also those of pandas. Times with a zone are converted to UTC,
        times without one are UTC.

    Returns
    -------
    ndarray of int64, shape (n,)
        0 for NaT: the reading has no stamp.

    Raises
    ------
    ValueError
        If stamps are neither integers nor datetime64; if one above 0 is before 1990, as numbers
        of another unit are; or if one is after 2262, which nanoseconds cannot hold.

    Examples
    --------
    >>> utc_stamps(np.array(['2014-08-01T00:00:00.25', 'NaT'], 'datetime64[us]')).tolist()
    [1406851200250000000, 0]

    """
    times: Any = stamps
    if getattr(getattr(times, 'dtype', None), 'tz', None) is not None:
        # A column of pandas with a time zone: only its own conversion knows the zone.
        times = np.asarray(times, dtype='datetime64[ns]')
    column = np.asarray(times)
    if column.dtype.kind == 'O':
        column = _from_objects(column.reshape(-1))
    stamp_ns = (_from_datetime64(column.reshape(-1)) if column.dtype.kind == 'M'
                else integer_stamps(column))
    early = (stamp_ns > 0) & (stamp_ns < EARLIEST_NS)
    if early.any():
        raise ValueError(_explain_early(stamp_ns[early], stamp_ns.size, column.dtype.kind == 'M'))
    return stamp_ns


def _from_objects(column: np.ndarray) -> np.ndarray:
    """Return objects as datetime64[ns] if all are times; other ones as they are."""
    if not all(hasattr(moment, 'utcoffset') and hasattr(moment, 'date') for moment in column):
        return column
    return np.array([_to_datetime64(moment) for moment in column], 'datetime64[ns]')


def _to_datetime64(moment: Any) -> np.datetime64:
    if moment.tzinfo is not None:
        moment = moment.replace(tzinfo=None) - moment.utcoffset()
    # That of pandas may be NaT, and counts nanoseconds.
    exact = getattr(moment, 'to_datetime64', None)
    return np.datetime64(moment, 'us') if exact is None else exact()


def _from_datetime64(column: np.ndarray) -> NDArray[np.int64]:
    missing = np.isnat(column)
    seconds = np.where(missing, 0, column.astype('datetime64[s]').astype(np.int64))
    if (seconds >= _LAST_S).any():
        last = column[~missing].max()
        raise ValueError(f'stamp_ns: the stamp {last} is after 2262, which nanoseconds cannot '
                         'hold; check how these times were made')
    # A time before 1970 must not pass for a reading without a stamp.
    stamp_ns = column.astype('datetime64[ns]').astype(np.int64)
    return np.where(missing, 0, np.where(seconds < 0, 1, np.maximum(stamp_ns, 1)))


def _explain_early(early: NDArray[np.int64], n: int, dated: bool) -> str:
    """Return the error for stamps before 1990, with the unit that their numbers look like."""
    typical = int(np.median(early))
    what = f'stamp_ns: {early.size} of {n} stamps are before 1990-01-01'
    if dated:
        return (f'{what}: check how these times were made; a sensor without UTC gives no stamp '
                '(NaT)')
    if scale := find_unit(typical, typical):
        unit, factor = scale
        return (f'{what}: numbers such as {typical} look like {unit}, and stamps are integer '
                f'nanoseconds; multiply by {factor}, or give the times as datetime64')
    return (f'{what}: numbers such as {typical} are no UTC nanoseconds; give nanoseconds since '
            '1970, datetime64, or the stamps of another clock to Headings.as_sent')
