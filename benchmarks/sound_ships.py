#!/usr/bin/env python3
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
Pairs of two sound sensors on ten kinds of ships, for the benchmark `sound_pairs`.

A pair is decided by its number and a seed alone. Its number chooses the motion, and what the
sensors or the trial have to bear (`BURDENS`); rates, errors and sizes are drawn.

Both sensors measure the ship at the stamps that they send. A pair is left out of the drawing if
nobody could judge it: stamps that never meet, of two sensors both slower than a fifth of the
period of the motion.
"""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Callable, Mapping

from error_processes import ar1, blue, Errors, mixed, polynomial, sea_state, white
from interpolation import headings, T0_NS
import numpy as np
from same_source import Motion as Course, rounded, seaway, turn

from heading_intercompare import Headings, Motion, Settings


@dataclass(frozen=True, slots=True)
class Ship:
    """
    A kind of motion.

    Attributes
    ----------
    period_s
        Shortest period of the motion that matters, seconds.
    steer
        Called with a generator and the length of the record, seconds; returns the heading as a
        function of the time.
    speed_kn
        Speed over ground.

    """

    period_s: float
    steer: Callable[[np.random.Generator, float], Course]
    speed_kn: float = 10.0


def swing(rng: np.random.Generator, rms_deg: float, period_s: float) -> Course:
    """Return 40 sines whose periods scatter by 15 %, as in a swell."""
    period = period_s * np.clip(1.0 + 0.15 * rng.standard_normal(40), 0.6, 1.6)
    phase = rng.uniform(0.0, 2.0 * np.pi, 40)

    def heading(t: np.ndarray) -> np.ndarray:
        total = np.zeros(t.shape)
        for one, at in zip(2.0 * np.pi / period, phase):
            total += np.sin(one * t + at)
        return total * (rms_deg / math.sqrt(20.0))
    return heading


def stick(heading_deg: np.ndarray, most_deg: float) -> np.ndarray:
    """Return what a card shows that follows only once it is off by `most_deg`."""
    if not most_deg:
        return heading_deg
    shown = heading_deg[0]
    values = []
    for value in heading_deg.tolist():
        if abs(value - shown) >= most_deg:
            shown = value
        values.append(shown)
    return np.array(values)


def _add(*courses: Course) -> Course:
    return lambda t: np.sum([course(t) for course in courses], axis=0)


def _turn_all(turns: list[tuple[float, float, float]]) -> Course:
    """Return the heading through turns (begin s, angle deg, rate deg/s)."""
    def heading(t: np.ndarray) -> np.ndarray:
        total = np.zeros(t.shape)
        for each in turns:
            total += turn(t, *each)
        return total
    return heading


def _wander(rng: np.random.Generator) -> Course:
    """Return the yaw of a ship that an autopilot or a mooring holds."""
    return swing(rng, rng.uniform(0.1, 0.4), rng.uniform(40.0, 300.0))


def _steady(rng: np.random.Generator, span_s: float) -> Course:
    return _add(swing(rng, 0.2, 10.0), _wander(rng))


def _turns(rng: np.random.Generator, span_s: float) -> Course:
    turns = [(at, rng.choice([-1.0, 1.0]) * rng.uniform(20.0, 150.0), rng.choice([0.3, 1.0, 2.0]))
             for at in rng.uniform(60.0, span_s - 120.0, rng.integers(3, 9))]
    return _add(swing(rng, 0.3, 10.0), _wander(rng), _turn_all(turns))


def _legs(rng: np.random.Generator, span_s: float) -> Course:
    """Return legs that take a third of the record each."""
    turns = [(k * span_s / 3.0 - 90.0, rng.choice([90.0, 180.0, -90.0]), 1.0) for k in (1, 2)]
    return _add(swing(rng, 0.4, 9.0), _wander(rng), _turn_all(turns))


def _merchant(rng: np.random.Generator, span_s: float) -> Course:
    rms_deg, period_s = (1.0, 8.0) if rng.random() < 0.5 else (0.7, 10.0)
    return _add(swing(rng, rms_deg, period_s), _wander(rng))


def _craft(rng: np.random.Generator, span_s: float) -> Course:
    return _add(swing(rng, 2.0, rng.choice([5.5, 6.0])), _wander(rng),
                _turn_all([(span_s / 2.0, 70.0, 2.0)]))


def _yacht(rng: np.random.Generator, span_s: float) -> Course:
    return _add(swing(rng, 3.0, 4.2), _wander(rng), _turn_all([(span_s / 3.0, -100.0, 3.0)]))


def _seaway(rng: np.random.Generator, span_s: float) -> Course:
    return _add(seaway(rng, span_s), _wander(rng))


def _moored(rng: np.random.Generator, span_s: float) -> Course:
    return _add(swing(rng, 0.1, 20.0), swing(rng, rng.uniform(0.2, 1.0), rng.uniform(200., 600.)))


def _zigzag(rng: np.random.Generator, span_s: float) -> Course:
    """Return zigzags of 10 or 20 deg to either side, for a third of the record."""
    side = rng.choice([10.0, 20.0])
    ways = [side] + [2.0 * side * (-1.0) ** k for k in range(1, round(span_s / 180.0))]
    return _add(swing(rng, 0.3, 9.0), _turn_all([(120.0 + 60.0 * k, way, 1.0)
                                                 for k, way in enumerate(ways)]))


def _manoeuvres(rng: np.random.Generator, span_s: float) -> Course:
    """Return a Williamson turn, full circles to both sides and a crash stop."""
    at_s = rng.uniform(0.1, 0.2) * span_s
    return _add(swing(rng, 0.3, 9.0), _wander(rng), _turn_all([
        (at_s, 60.0, 2.0), (at_s + 30.0, -240.0, 2.0), (0.4 * span_s, 720.0, 1.5),
        (0.7 * span_s, -360.0, 2.5), (0.9 * span_s, 40.0, 0.5)]))


#: Kinds of motion; those of swells are those of the tables of the interpolation.
SHIPS: Mapping[str, Ship] = {
    'steady': Ship(10.0, _steady), 'turns': Ship(10.0, _turns), 'legs': Ship(9.0, _legs),
    'merchant': Ship(8.0, _merchant), 'craft': Ship(5.5, _craft, 20.0),
    'yacht': Ship(4.2, _yacht, 7.0), 'seaway': Ship(6.0, _seaway),
    'moored': Ship(20.0, _moored, 0.1), 'zigzag': Ship(9.0, _zigzag),
    'manoeuvres': Ship(9.0, _manoeuvres)}

#: What a pair has to bear, besides its rates and errors.
BURDENS = ('nothing', 'missing', 'gaps', 'jitter', 'coarse', 'quiet', 'marks', 'motion')

#: Rates of TS and RS, Hz; whether both have the same stamps.
_RATES = [(0.2, 0.2, True), (0.2, 0.2, False), (5.0, 0.2, False), (0.5, 0.5, True),
          (0.5, 0.5, False), (1.0, 1.0, True), (1.0, 1.0, False), (1.25, 1.0, False),
          (1.0, 2.0, False), (1.0, 5.0, False), (5.0, 1.0, False), (10.0, 1.0, False),
          (1.0, 10.0, False), (2.0, 2.0, False), (5.0, 5.0, False), (10.0, 10.0, True),
          (10.0, 10.0, False), (20.0, 10.0, False), (50.0, 10.0, False), (100.0, 1.0, False),
          (10.0, 100.0, False)]


def _drifting(rng: np.random.Generator, runs: int, n: int) -> np.ndarray:
    """Return errors of which a slope makes up a twentieth of the variance."""
    return mixed(0.95, white, lambda rng, runs, n: np.tile(
        rng.choice([-1.0, 1.0]) * polynomial(n, 1), (runs, 1)))(rng, runs, n)


#: Errors of variance 1 at a rate in Hz, by name; those of the second row may last.
_BRIEF: Mapping[str, Callable[[float], Errors]] = {
    'white': lambda hz: white, 'blue': lambda hz: blue, 'AR(1) 2 s': lambda hz: ar1(2.0 * hz),
    'AR(1) 20 s': lambda hz: ar1(20.0 * hz)}
_ALL = _BRIEF | {
    'AR(1) 2 min': lambda hz: ar1(120.0 * hz), 'drift': lambda hz: _drifting,
    'gusty': lambda hz: sea_state(0.5, 300.0 * hz, ar1(2.0 * hz))}


@dataclass(frozen=True, slots=True)
class SoundPair:
    """
    Two sound sensors, and how the trial is judged.

    Attributes
    ----------
    words
        Ship, burden, rates, errors and sizes in words.
    ts, rs
        Readings.
    settings
        Norms and lower bound of the RS.
    motion
        The motion of the ship, if the pair has any.
    legs : tuple of (start_ns, stop_ns)
        Legs that are marked.
    table
        Whether the legs are those of a table of runs instead of marks.

    """

    words: str
    ts: Headings
    rs: Headings
    settings: Settings
    motion: Motion
    legs: tuple[tuple[int, int], ...]
    table: bool


@dataclass(frozen=True, slots=True)
class _Sensor:
    """
    How a sensor reports: rate, errors as in `_ALL`, their size, and its steps.

    A card that sticks reports a new value only once it is off by `stick_deg`.
    """

    hz: float
    errors: str
    sigma_deg: float
    step_deg: float
    stick_deg: float

    def report(self, rng: np.random.Generator, t_s: np.ndarray, course: Course) -> Headings:
        """Return the readings at some times."""
        error = _ALL[self.errors](self.hz)(rng, 1, t_s.size)[0]
        own_deg = math.sqrt(max(self.sigma_deg ** 2 - self.step_deg ** 2 / 12.0, 1e-4))
        return headings(t_s, rounded(stick(course(t_s) + own_deg * error, self.stick_deg),
                                     self.step_deg))

    def __str__(self) -> str:
        step = f' in steps of {self.step_deg:g}' if self.step_deg else ''
        stuck = f' that sticks for {self.stick_deg:.2g}' if self.stick_deg else ''
        return f'{self.hz:g} Hz {self.errors} {self.sigma_deg:.3g} deg{step}{stuck}'


def draw_pair(number: int, seed: int, *, share: float | None = None) -> SoundPair:
    """
    Return a pair of sensors.

    Parameters
    ----------
    number
        Its number, from 0.
    seed
        With the number it decides everything.
    share
        Standard deviation of the TS in units of its norm; with it the errors last for 20 s at
        most, and the RS is at the lower bound of its norm. Drawn from 0.3 to 0.8 by default.

    """
    rng = np.random.default_rng([seed, number])
    names = [*SHIPS]
    name = names[number % len(names)]
    ship = SHIPS[name]
    burden = BURDENS[number // len(names) % len(BURDENS)]
    plain = share is not None
    if plain and burden in ('coarse', 'quiet'):
        burden = 'nothing'
    able = list_rates(ship, burden)
    ts_hz, rs_hz, same = able[(number // len(names) + seed) % len(able)]
    span_s = (7200.0 if min(ts_hz, rs_hz) < 1.0 else 1500.0 if max(ts_hz, rs_hz) > 20.0
              else rng.uniform(1500.0, 2400.0))
    if burden == 'marks' or name == 'legs':
        span_s = max(span_s, 2250.0)
    begin_deg = rng.uniform(0.0, 360.0)
    course = _add(ship.steer(rng, span_s), lambda t: np.full(t.shape, begin_deg))
    slow = max(ts_hz, rs_hz) < 0.5 and not same
    sigma_max, sigma_ref_max = (0.1, 0.05) if burden == 'quiet' else (0.2, 0.1)
    ts_share = rng.uniform(0.3, 0.5 if slow else 0.8) if share is None else share
    rs_share = rng.uniform(0.5, 0.8)
    colours = [*(_BRIEF if plain else _ALL)]
    ts_step, rs_step = _draw_steps(rng, burden)
    ts_colour, rs_colour = str(rng.choice(colours)), str(rng.choice([*_BRIEF]))
    ts_stick = rs_stick = 0.0
    if name == 'moored' and burden in ('nothing', 'quiet') and not plain:
        # Two gyros whose cards stick: a value stands for many seconds.
        ts_colour = rs_colour = 'AR(1) 2 min'
        ts_step = rs_step = 0.01
        ts_stick, rs_stick = rng.uniform(0.01, 0.05, 2)
    ts_sensor = _Sensor(ts_hz, ts_colour, ts_share * sigma_max, ts_step, float(ts_stick))
    rs_sensor = _Sensor(rs_hz, rs_colour, rs_share * sigma_ref_max, rs_step, float(rs_stick))
    ts_s, rs_s = _draw_times(rng, span_s, ts_hz, rs_hz, same, burden)
    m_low = rs_share if plain else 0.0 if burden in ('coarse', 'quiet') else rng.choice([0.0, 0.5])
    settings = Settings.from_mapping({'norms': {
        'sigma_max_deg': sigma_max, 'sigma_ref_max_deg': sigma_ref_max, 'm_low': float(m_low)}})
    words = (f'{name}, {burden}, TS {ts_sensor}, RS {rs_sensor}, '
             f'{"equal stamps" if same else "own stamps"}, {span_s / 60.0:.0f} min')
    legs = ()
    if burden == 'marks' or name == 'legs':
        legs = tuple((T0_NS + round((at + 10.0) * 1e9), T0_NS + round((at + span_s / 3.0 - 100.0)
                                                                      * 1e9))
                     for at in (0.0, span_s / 3.0, 2.0 * span_s / 3.0))
    motion = _tell(rng, ship, course, span_s) if burden == 'motion' else Motion.empty()
    return SoundPair(words, ts_sensor.report(rng, ts_s, course),
                     rs_sensor.report(rng, rs_s, course), settings, motion, legs,
                     bool(rng.random() < 0.5))


def list_rates(ship: Ship, burden: str) -> list[tuple[float, float, bool]]:
    """Return the rates, and whether the stamps are equal, of pairs that can be judged."""
    # Jitter of nearly a step leaves silences that only a fast stream can bridge.
    fewest = 8.0 if burden == 'jitter' else 5.0
    return [(ts_hz, rs_hz, same) for ts_hz, rs_hz, same in _RATES
            if same and burden != 'jitter'
            or not same and max(ts_hz, rs_hz) * ship.period_s >= fewest
            or max(ts_hz, rs_hz) < 0.5 and ship.period_s >= 20.0]


def _draw_steps(rng: np.random.Generator, burden: str) -> tuple[float, float]:
    """Return the steps of TS and RS, degrees."""
    if burden == 'coarse':
        return float(rng.choice([0.1, 0.2])), float(rng.choice([0.01, 0.1]))
    if burden == 'quiet':
        return float(rng.choice([0.01, 0.1])), float(rng.choice([0.01, 0.1]))
    return float(rng.choice([0.0, 0.01])), float(rng.choice([0.0, 0.01]))


def _draw_times(rng: np.random.Generator, span_s: float, ts_hz: float, rs_hz: float, same: bool,
                burden: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the times of both sensors; of independent clocks unless the stamps are equal."""
    times = []
    for hz in (ts_hz, rs_hz):
        off = 1.0 if same else 1.0 + rng.uniform(-1e-4, 1e-4)
        t = np.arange(0.0 if same else rng.uniform(0.0, 1.0 / hz), span_s, off / hz)
        if burden == 'jitter':
            size = 0.45 if hz >= 5.0 else 0.2
            t = np.sort(np.abs(t + rng.uniform(-size, size, t.size) / hz))
        if burden == 'missing':
            t = t[rng.random(t.size) >= rng.uniform(0.01, 0.06)]
        times.append(t)
    if burden == 'gaps':
        silent = times[rng.integers(2)]
        keep = np.ones(silent.size, bool)
        for at in rng.uniform(100.0, span_s - 100.0, 3):
            keep &= np.abs(silent - at) > rng.uniform(3.0, 15.0)
        times = [t[keep] if t is silent else t for t in times]
    return times[0], times[1]


def _tell(rng: np.random.Generator, ship: Ship, course: Course, span_s: float) -> Motion:
    """Return what the ship tells once a second: course and speed, rate of turn or positions."""
    t = np.arange(0.0, span_s)
    stamps = T0_NS + np.rint(t * 1e9).astype(np.int64)
    kind = rng.integers(3)
    if kind == 0:
        rate = (course(t + 0.05) - course(t - 0.05)) / 0.1
        return Motion.of_rates(stamps, rate + 0.02 * rng.standard_normal(t.size))
    over_ground = np.radians(course(t) + 2.0)
    east, north = (ship.speed_kn * 1852.0 / 3600.0 * way(over_ground) + 0.05
                   * rng.standard_normal(t.size) for way in (np.sin, np.cos))
    east += 0.3
    if kind == 1:
        return Motion.of_velocities(stamps, east, north)
    latitude = 54.0 + np.cumsum(north) / 1852.0 / 60.0
    longitude = 8.0 + np.cumsum(east) / 1852.0 / 60.0 / np.cos(np.radians(54.0))
    return Motion.of_positions(stamps, latitude, longitude)
