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
The arrays that flow through the package: headings, losses, quality, motion, pairs, differences.

Each is a chunk: n >= 0 samples in columns of equal length. No sample travels alone.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass
from typing import Any, Iterable, Sequence, TYPE_CHECKING, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .units.angle_units import fold_angles
from .units.given_stamps import integer_stamps, utc_stamps
from .utc_text import utc

KNOT_M_S = 1852.0 / 3600.0
"""One knot, m/s."""
FASTEST_M_S, FASTEST_TURN_DEG_S = 80.0, 60.0
"""No ship moves or turns faster, m/s and degrees per second: such a reading is a mistake."""

MOTION_COLUMNS = {'fix': ('latitude_deg', 'longitude_deg'), 'velocity': ('east_m_s', 'north_m_s'),
                  'rate': ('rate_deg_s',)}
"""The columns of `Motion` that a row fills, by what it tells."""

QUALITY_FLAGS = ('unknown', 'normal', 'reduced performance', 'float solution', 'code solution',
                 'no GNSS aiding', 'inertial only', 'rough attitude', 'invalid by PSXN,20',
                 'no position', 'estimated position', 'position set by hand', 'simulated position')
"""What a sensor says of a reading, in words; the readings from the third word on are poor."""
UNKNOWN_QUALITY, NORMAL_QUALITY = 0, 1

Reals = NDArray[np.float64]
Integers = NDArray[np.int64]

_Chunk = TypeVar('_Chunk', bound='_Columns')


class _Columns:
    """Length, slicing and joining of a frozen dataclass of equally long columns."""

    # In a dataclass of columns, these are the names of the columns.
    __slots__: tuple[str, ...] = ()

    if TYPE_CHECKING:
        # What every dataclass of columns has.
        stamp_ns: Integers

        def __init__(self, *columns: np.ndarray) -> None: ...

        @classmethod
        def empty(cls: type[_Chunk]) -> _Chunk: ...

    def __post_init__(self) -> None:
        """Raise ValueError if the columns differ in length: they cannot belong together."""
        shape = self.stamp_ns.shape
        if len(shape) != 1 or any(getattr(self, name).shape != shape for name in self.__slots__):
            lengths = {name: getattr(self, name).shape for name in self.__slots__}
            raise ValueError(f'{type(self).__name__}: columns differ in shape: {lengths}')

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def __repr__(self) -> str:
        """
        Return the number of samples and their span, not the samples.

        Examples
        --------
        >>> Headings.of([1_400_000_000_000_000_000, 1_400_000_001_500_000_000], [359.9, 0.1])
        Headings(n=2, 2014-05-13 16:53:20.000 to 2014-05-13 16:53:21.500 UTC)

        """
        span = (f', {utc(int(self.stamp_ns.min()))} to {utc(int(self.stamp_ns.max()))} UTC'
                if len(self) else '')
        return f'{type(self).__name__}(n={len(self)}{span})'

    def __getitem__(self: _Chunk, which: Any) -> _Chunk:
        """Return the samples of a slice, mask or index array, as a chunk."""
        if isinstance(which, (int, np.integer)):
            which = slice(which, which + 1 or None)
        return type(self)(*[getattr(self, name)[which] for name in self.__slots__])

    def __add__(self: _Chunk, other: _Chunk) -> _Chunk:
        """Return this chunk followed by the other one."""
        return type(self).concatenate((self, other))

    def __eq__(self, other: object) -> bool:
        """Tell whether both hold the same samples to the bit (nan equals nan)."""
        if type(self) is not type(other):
            return NotImplemented
        return all(np.array_equal(getattr(self, name), getattr(other, name), equal_nan=True)
                   for name in self.__slots__)

    @classmethod
    def concatenate(cls: type[_Chunk], chunks: Iterable[_Chunk]) -> _Chunk:
        """Return the chunks joined in the order given."""
        chunks = [c for c in chunks if len(c)]
        if len(chunks) == 1:
            return chunks[0]
        if not chunks:
            return cls.empty()
        return cls(*[np.concatenate([getattr(c, name) for c in chunks])
                     for name in cls.__slots__])


class ColumnBuffer:
    """
    Columns that grow row by row, until a chunk takes them.

    Parameters
    ----------
    width
        Number of columns of reals beside the stamps.

    Attributes
    ----------
    stamp_ns : array of int64
        Stamps, nanoseconds.
    values : list of array of float64
        The other columns.

    Examples
    --------
    >>> buffer = ColumnBuffer()
    >>> buffer.add(10 ** 18, 218.5)
    >>> Headings(*buffer.drain()), len(buffer)
    (Headings(n=1, 2001-09-09 01:46:40.000 to 2001-09-09 01:46:40.000 UTC), 0)

    """

    __slots__ = ('stamp_ns', 'values')

    def __init__(self, width: int = 1) -> None:
        self.stamp_ns, self.values = array('q'), [array('d') for _ in range(width)]

    def __len__(self) -> int:
        return len(self.stamp_ns)

    def add(self, stamp_ns: int, *values: float) -> None:
        """Add a row."""
        self.stamp_ns.append(stamp_ns)
        for column, value in zip(self.values, values):
            column.append(value)

    def columns(self) -> list[np.ndarray]:
        """Return the columns, the stamps first."""
        return [np.array(self.stamp_ns), *map(np.array, self.values)]

    def drain(self) -> list[np.ndarray]:
        """Return the columns, and begin again without rows."""
        # A driver drains once per message, and clearing costs less than new arrays.
        columns = [np.array(self.stamp_ns)]
        del self.stamp_ns[:]
        for column in self.values:
            columns.append(np.array(column))
            del column[:]
        return columns


def _reals(values: ArrayLike) -> Reals:
    reals: Reals = np.asarray(values, dtype=np.float64)
    return reals if reals.ndim == 1 else reals.reshape(-1)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Headings(_Columns):
    """
    Readings of one heading sensor, in order of arrival.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        UTC stamps, nanoseconds.
    heading_deg : ndarray of float64, shape (n,)
        Degrees clockwise from true north; nan where the sensor flags its reading as invalid.

    """

    stamp_ns: Integers
    heading_deg: Reals

    @classmethod
    def empty(cls) -> 'Headings':
        """Return the empty chunk."""
        return cls.as_sent([], [])

    @classmethod
    def of(cls, stamp_ns: ArrayLike, heading_deg: ArrayLike, unit: str = 'deg') -> 'Headings':
        """
        Build a chunk from arrays or from columns of a table.

        Parameters
        ----------
        stamp_ns : array_like, shape (n,)
            UTC: integer nanoseconds since 1970, or datetime64 of any unit. A Series or
            DatetimeIndex of pandas is taken as it is, with or without a time zone; without one it
            is UTC. A stamp of 0 or NaT is a reading without a stamp, which the ledger counts.
        heading_deg : array_like, shape (n,)
            Clockwise from true north, also from minus a half turn to a half; nan where the
            reading is invalid.
        unit : {'deg', 'rad', 'rev'}
            Unit of the headings.

        Returns
        -------
        Headings
            Degrees from 0; a number out of range stays as it is, and the ledger counts it.

        Raises
        ------
        ValueError
            If the unit is unknown. If a stamp above 0 is before 1990: the numbers are of another
            unit, which the message names, or of another clock (see `as_sent`). If stamps are
            neither integers nor datetime64, or the columns differ in length.

        Examples
        --------
        >>> Headings.of(np.array(['2014-08-01T00:00:00', '2014-08-01T00:00:01'], 'M8[us]'), [1, 2])
        Headings(n=2, 2014-08-01 00:00:00.000 to 2014-08-01 00:00:01.000 UTC)

        """
        return cls(utc_stamps(stamp_ns), fold_angles(_reals(heading_deg), unit))

    @classmethod
    def as_sent(cls, stamp_ns: ArrayLike, heading_deg: ArrayLike) -> 'Headings':
        """
        Build a chunk with the stamps of any clock, as messages and bags give them.

        Nothing is checked: a stamp of 0 or below counts as none, and the pairing finds jumps.

        Parameters
        ----------
        stamp_ns : array_like of int, shape (n,)
            Nanoseconds; those of both sensors must be of one clock.
        heading_deg : array_like, shape (n,)
            Degrees clockwise from true north; nan where the reading is invalid.

        Returns
        -------
        Headings

        Raises
        ------
        ValueError
            If stamps are not integers, or the columns differ in length.

        """
        return cls(integer_stamps(stamp_ns), _reals(heading_deg))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Losses(_Columns):
    """
    Readings that were sent but did not come as readings, gap by gap.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamp of the first reading after the gap, nanoseconds: a lost reading has none.
    since_ns : ndarray of int64, shape (n,)
        Stamp of the last reading before the gap, nanoseconds; 0 if unknown.
    count : ndarray of int64, shape (n,)
        Readings lost in the gap. A negative count takes back an earlier one: later readings
        showed that nothing was missing there.

    """

    stamp_ns: Integers
    since_ns: Integers
    count: Integers

    @classmethod
    def empty(cls) -> 'Losses':
        """Return the empty chunk."""
        return cls.of([], [], [])

    @classmethod
    def of(cls, stamp_ns: ArrayLike, since_ns: ArrayLike, count: ArrayLike) -> 'Losses':
        """Build a chunk from these columns, all of integers."""
        return cls(integer_stamps(stamp_ns), integer_stamps(since_ns), integer_stamps(count))


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Quality(_Columns):
    """
    What a heading sensor says of its own readings.

    Of readings in a row of which it says the same, the first and the last suffice.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the readings, nanoseconds.
    stated_deg : ndarray of float64, shape (n,)
        Standard deviation of the heading as the sensor claims it, degrees; nan without a claim.
    flag : ndarray of int64, shape (n,)
        Index of `QUALITY_FLAGS`.

    """

    stamp_ns: Integers
    stated_deg: Reals
    flag: Integers

    @classmethod
    def empty(cls) -> 'Quality':
        """Return the empty chunk."""
        return cls.of([], [], [])

    @classmethod
    def of(cls, stamp_ns: ArrayLike, stated_deg: ArrayLike, flag: ArrayLike) -> 'Quality':
        """Build a chunk from these columns; stamps and flags must be integers."""
        return cls(integer_stamps(stamp_ns), _reals(stated_deg), integer_stamps(flag))

    @classmethod
    def join(cls, chunks: Sequence['Quality']) -> 'Quality':
        """Return chunks joined; of what several say, only the rows that `match` needs."""
        rows = cls.concatenate(chunks)
        return rows if len(chunks) == 1 else rows.without_repeats()

    def without_repeats(self) -> 'Quality':
        """
        Return the rows without those between two that say the same.

        Examples
        --------
        >>> rows = Quality.of([1, 2, 3, 4], [0.1, 0.1, 0.1, np.nan], [0, 0, 0, 0])
        >>> rows.without_repeats().stamp_ns.tolist()
        [1, 3, 4]

        """
        stated_deg = np.nan_to_num(self.stated_deg, nan=-1.0)
        is_same = (stated_deg[1:] == stated_deg[:-1]) & (self.flag[1:] == self.flag[:-1])
        is_needed = np.ones(len(self), bool)
        is_needed[1:-1] = ~(is_same[:-1] & is_same[1:])
        return self[np.flatnonzero(is_needed)]

    def match(self, stamp_ns: Integers) -> tuple[Integers, Reals]:
        """
        Return flag and claim at other stamps: the worse of the rows before and after.

        Parameters
        ----------
        stamp_ns : ndarray of int64, shape (n,)
            Nanoseconds, in any order, as the rows are.

        Returns
        -------
        flag, stated_deg : ndarray, shape (n,)
            Unknown, and nan, before the first row and after the last one.

        Examples
        --------
        >>> flag, stated_deg = Quality.of([10, 20], [0.1, 0.5], [1, 3]).match(np.arange(5, 30, 5))
        >>> flag.tolist(), stated_deg.tolist()
        ([0, 1, 3, 3, 0], [nan, 0.1, 0.5, 0.5, nan])

        """
        if not len(self):
            return np.full(stamp_ns.shape, UNKNOWN_QUALITY), np.full(stamp_ns.shape, np.nan)
        rows = self[np.argsort(self.stamp_ns, kind='stable')]
        before = np.searchsorted(rows.stamp_ns, stamp_ns, 'right') - 1
        after = np.searchsorted(rows.stamp_ns, stamp_ns, 'left')
        is_within = (before >= 0) & (after < len(rows))
        before, after = np.maximum(before, 0), np.minimum(after, len(rows) - 1)
        flag = np.maximum(rows.flag[before], rows.flag[after])
        stated_deg = np.fmax(rows.stated_deg[before], rows.stated_deg[after])
        return np.where(is_within, flag, UNKNOWN_QUALITY), np.where(is_within, stated_deg, np.nan)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Motion(_Columns):
    """
    What a ship tells of its motion: positions, velocities over ground, rates of turn.

    A row has what one sentence or message tells; the other columns are nan there.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        UTC stamps, nanoseconds.
    latitude_deg, longitude_deg : ndarray of float64, shape (n,)
        Position, degrees, north and east positive.
    east_m_s, north_m_s : ndarray of float64, shape (n,)
        Velocity over ground, m/s.
    rate_deg_s : ndarray of float64, shape (n,)
        Rate of turn, degrees per second, positive to starboard.

    """

    stamp_ns: Integers
    latitude_deg: Reals
    longitude_deg: Reals
    east_m_s: Reals
    north_m_s: Reals
    rate_deg_s: Reals

    @classmethod
    def empty(cls) -> 'Motion':
        """Return the empty chunk."""
        return cls.of('rate', [], [])

    @classmethod
    def of(cls, what: str, stamp_ns: ArrayLike, *columns: ArrayLike) -> 'Motion':
        """Build a chunk of rows that tell one thing; stamps must be integers."""
        stamps, names = integer_stamps(stamp_ns), MOTION_COLUMNS[what]
        if len(columns) != len(names):
            raise ValueError(f'{what}: {len(columns)} columns, must be {", ".join(names)}')
        values = dict(zip(names, map(_reals, columns)))
        # A view of one number, so that a row takes no memory for what it does not tell.
        none = np.broadcast_to(np.nan, stamps.shape)
        return cls(stamps, *(values.get(name, none) for name in cls.__slots__[1:]))

    @classmethod
    def of_positions(cls, stamp_ns: ArrayLike, latitude_deg: ArrayLike,
                     longitude_deg: ArrayLike) -> 'Motion':
        """Build a chunk from positions; stamps must be integers."""
        return cls.of('fix', stamp_ns, latitude_deg, longitude_deg)

    @classmethod
    def of_velocities(cls, stamp_ns: ArrayLike, east_m_s: ArrayLike,
                      north_m_s: ArrayLike) -> 'Motion':
        """Build a chunk from velocities over ground; stamps must be integers."""
        return cls.of('velocity', stamp_ns, east_m_s, north_m_s)

    @classmethod
    def of_courses(cls, stamp_ns: ArrayLike, course_deg: ArrayLike,
                   speed_kn: ArrayLike) -> 'Motion':
        """
        Build a chunk from courses and speeds over ground; stamps must be integers.

        Examples
        --------
        >>> Motion.of_courses([10 ** 18], [90.0], [10.0]).speed_kn.round(6).tolist()
        [10.0]

        """
        course, speed = np.radians(_reals(course_deg)), _reals(speed_kn) * KNOT_M_S
        return cls.of_velocities(stamp_ns, speed * np.sin(course), speed * np.cos(course))

    @classmethod
    def of_rates(cls, stamp_ns: ArrayLike, rate_deg_s: ArrayLike) -> 'Motion':
        """Build a chunk from rates of turn; stamps must be integers."""
        return cls.of('rate', stamp_ns, rate_deg_s)

    @property
    def course_deg(self) -> Reals:
        """Course over ground, degrees clockwise from true north, -180 to 180."""
        return np.degrees(np.arctan2(self.east_m_s, self.north_m_s))

    @property
    def speed_kn(self) -> Reals:
        """Speed over ground, knots."""
        return np.hypot(self.east_m_s, self.north_m_s) / KNOT_M_S

    def in_order(self) -> 'Motion':
        """Return the rows with a stamp, in stamp order."""
        if len(self) and self.stamp_ns[0] > 0 and (self.stamp_ns[1:] >= self.stamp_ns[:-1]).all():
            return self
        rows = self[np.argsort(self.stamp_ns, kind='stable')]
        return rows[rows.stamp_ns > 0]

    def select(self, what: str) -> 'Motion':
        """Return the rows that tell one thing: 'fix', 'velocity' or 'rate'."""
        tells = np.logical_and.reduce([np.isfinite(getattr(self, name))
                                       for name in MOTION_COLUMNS[what]])
        return self if tells.all() else self[tells]

    def positions(self) -> 'Motion':
        """Return the rows with a position."""
        return self.select('fix')

    def velocities(self) -> 'Motion':
        """Return the rows with a velocity."""
        return self.select('velocity')

    def rates(self) -> 'Motion':
        """Return the rows with a rate of turn."""
        return self.select('rate')

    def split(self) -> dict[str, 'Motion']:
        """Return the rows by what they tell: 'fix', 'velocity', 'rate'."""
        return {what: self.select(what) for what in MOTION_COLUMNS}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Attitude(_Columns):
    """
    How a ship lies in the water.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        UTC stamps, nanoseconds.
    roll_deg, pitch_deg : ndarray of float64, shape (n,)
        Starboard down, and bow up, degrees; nan if unknown.

    """

    stamp_ns: Integers
    roll_deg: Reals
    pitch_deg: Reals

    @classmethod
    def of(cls, stamp_ns: ArrayLike, roll_deg: ArrayLike, pitch_deg: ArrayLike) -> 'Attitude':
        """Build a chunk; stamps must be integers."""
        return cls(integer_stamps(stamp_ns), _reals(roll_deg), _reals(pitch_deg))

    @classmethod
    def empty(cls) -> 'Attitude':
        """Return the empty chunk."""
        return cls.of([], [], [])


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Pairs(_Columns):
    """
    TS and RS readings of one instant each, in stamp order within a segment.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the TS readings, nanoseconds; of the RS readings if the TS is interpolated.
    ts_deg, rs_deg : ndarray of float64, shape (n,)
        Headings, degrees.
    lag_ns : ndarray of int64, shape (n,)
        RS stamp - TS stamp, nanoseconds; 0 where one of them is interpolated.
    rs_variance_factor, ts_variance_factor : ndarray of float64, shape (n,)
        Factor by which interpolation changes the white-noise variance of the RS, and of the TS:
        the sum of the squared weights of the readings, or 1 without interpolation.
    segment : ndarray of int64, shape (n,)
        How often a clock was set back before the pair, so that stamps were repeated.

    """

    stamp_ns: Integers
    ts_deg: Reals
    rs_deg: Reals
    lag_ns: Integers
    rs_variance_factor: Reals
    ts_variance_factor: Reals
    segment: Integers

    @classmethod
    def empty(cls) -> 'Pairs':
        """Return the empty chunk."""
        return cls.of([], [], [])

    @classmethod
    def of(cls, stamp_ns: ArrayLike, ts_deg: ArrayLike, rs_deg: ArrayLike,
           lag_ns: ArrayLike | None = None, rs_variance_factor: ArrayLike | None = None,
           ts_variance_factor: ArrayLike | None = None, *, segment: int = 0) -> 'Pairs':
        """Build a chunk of one segment from columns; lags default to 0 and factors to 1."""
        stamps = integer_stamps(stamp_ns)
        lag = np.zeros(stamps.shape, np.int64) if lag_ns is None else integer_stamps(lag_ns)
        rs_factor, ts_factor = (
            np.ones(stamps.shape) if factor is None else _reals(factor)
            for factor in (rs_variance_factor, ts_variance_factor))
        return cls(stamps, _reals(ts_deg), _reals(rs_deg), lag, rs_factor, ts_factor,
                   np.full(stamps.shape, segment))

    def in_segments(self) -> list['Pairs']:
        """Return the pairs of each segment in turn, each n >= 1."""
        if not len(self) or self.segment[0] == self.segment[-1]:
            return [self] if len(self) else []
        bounds = [0, *(np.flatnonzero(np.diff(self.segment)) + 1).tolist(), len(self)]
        return [self[lo:hi] for lo, hi in zip(bounds, bounds[1:])]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Differences(_Columns):
    """
    Differences TS - RS, in stamp order.

    Attributes
    ----------
    stamp_ns : ndarray of int64, shape (n,)
        Stamps of the pairs, nanoseconds.
    x_deg : ndarray of float64, shape (n,)
        Wrapped differences with the installation offset removed, degrees. GK (1).

    """

    stamp_ns: Integers
    x_deg: Reals

    @classmethod
    def empty(cls) -> 'Differences':
        """Return the empty chunk."""
        return cls.of([], [])

    @classmethod
    def of(cls, stamp_ns: ArrayLike, x_deg: ArrayLike) -> 'Differences':
        """Build a chunk from these columns; stamps must be integers."""
        return cls(integer_stamps(stamp_ns), _reals(x_deg))
