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

"""The dynamic error: the amplitude of the differences that the sea makes, by period."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterator

import numpy as np

from heading_intercompare.core import lazy_scipy as scipy
from heading_intercompare.core.records import Reals
from heading_intercompare.core.timing.heading_track import Track

from .judged_test import Measurement
from .tested_run import exceeding, NORMAL_QUANTILE, reach, TestedRun

FAST_PERIOD_S = 30.0
"""Errors of shorter periods have a limit of their own, MSC.116(73) 4.3.2.3."""

LEAST_YAW_DEG = 1.0
"""Amplitude of the yaw that the sea must give the ship for a sensor to meet the test, degrees."""

SHARE = 0.95
"""Share of the readings that the amplitude bounds: it is that of a sine to 0.3 %."""

SLOWEST_STEP_S = 5.0
"""Slower readings do not show a period of 30 s, seconds."""

#: Variance of the fourth differences of white noise: 1 + 16 + 36 + 16 + 1. A swell has little.
_WHITE_BENDS = 70.0
#: Order of the filter, which runs forwards and backwards.
_ORDER = 8
#: Length of the means in seconds; no error by the motion of a ship is faster than twice that.
_STEP_S = 0.5
#: The ship turns if she turns so fast over half a minute, degrees per second.
_TURNING_DEG_S = 0.2
_LEAST_LEG_S = 300.0
_LEAST_S = 1800.0
_BLOCKS = 16


@dataclass(frozen=True, slots=True)
class _Motion:
    """Differences and headings of the RS of all straight legs, by period, degrees."""

    whole: Reals
    fast: Reals
    yaw: Reals
    span_s: float
    noise_deg2: float


def measure_dynamic_error(tested: TestedRun, limit: float) -> Measurement:
    """
    Return the amplitude of the differences on straight legs.

    Notes
    -----
    The amplitude is the distance from the mean of a leg that 95 % of the differences keep, means
    of half a second. Blocks of the legs say how well it is known. The least part of the RS is
    taken out of the upper bound as in GK: in squares. Before the test is not met, the most of
    the RS, of white noise and of rounding is taken out as it is: at the peaks of a swing they
    add, and no motion of the ship makes them.

    References
    ----------
    MSC.116(73) 3.7 and 4.3.2.3.

    """
    return _measure(tested, limit, is_fast=False)


def measure_fast_dynamic_error(tested: TestedRun, limit: float) -> Measurement:
    """Return the amplitude of the differences with periods below 30 s; see above."""
    return _measure(tested, limit, is_fast=True)


def _measure(tested: TestedRun, limit: float, *, is_fast: bool) -> Measurement:
    motion = find_motion(tested)
    if motion is None:
        return Measurement(record='no straight leg of 5 min, read every 5 s or more often')
    series = motion.fast if is_fast else motion.whole
    yaw = _amplitude(motion.yaw)
    record = (f'{motion.span_s / 60.0:.0f} min of straight legs, on which the ship yaws by '
              f'{yaw:.2g} deg')
    blocks = np.array_split(np.abs(series), _BLOCKS)
    if motion.span_s < _LEAST_S:
        return Measurement(record=record)
    of_blocks = np.array([np.quantile(block, SHARE) for block in blocks])
    amplitude, nu = _amplitude(series), len(blocks) - 1.0
    u = float(np.std(of_blocks, ddof=1)) / math.sqrt(len(blocks))
    rounding_deg2 = sum(step.variance_deg2 for step in tested.columns.steps)
    most = NORMAL_QUANTILE * math.sqrt(
        tested.reference_deg(True) ** 2 + max(motion.noise_deg2, rounding_deg2))
    least = NORMAL_QUANTILE * tested.reference_deg(False)
    low = amplitude - reach(tested.risks.not_met, nu) * u
    high = amplitude + reach(tested.risks.met, nu) * u
    beyond = amplitude - limit - most
    return Measurement(
        amplitude, max(0.0, low - most), _without(high, least),
        exceeding(beyond / u, nu) if u > 0.0 else float(beyond <= 0.0),
        yaw >= LEAST_YAW_DEG, record)


def _amplitude(series: Reals) -> float:
    return float(np.quantile(np.abs(series), SHARE)) if series.size else 0.0


def _without(amplitude_deg: float, reference_deg: float) -> float:
    """Return an amplitude without the part of the RS."""
    return math.sqrt(max(0.0, amplitude_deg) ** 2 - min(max(0.0, amplitude_deg),
                                                        reference_deg) ** 2)


def find_motion(tested: TestedRun) -> _Motion | None:
    """Return the straight legs of a run, split by period; None if there is none."""
    tracks = tested.columns.tracks
    if tracks is None or tracks.rs.step_s > SLOWEST_STEP_S:
        return None
    parts = [_split_leg(x, rs, step_s) for x, rs, step_s in _list_legs(tracks.ts, tracks.rs)]
    if not parts:
        return None
    whole, fast, yaw = (np.concatenate([part[at] for part in parts]) for at in range(3))
    bends = np.concatenate([np.diff(part[0], 4) for part in parts])
    return _Motion(whole, fast, yaw, sum(part[3] for part in parts),
                   float(np.mean(bends ** 2)) / _WHITE_BENDS)


def _list_legs(ts: Track, rs: Track) -> Iterator[tuple[Reals, Reals, float]]:
    """Yield differences and RS headings of each straight leg at equal steps, and the step."""
    step_s = max(_STEP_S, rs.step_s)
    size = max(1, round(step_s / rs.step_s))
    step_s = size * rs.step_s
    whole = rs.t_s.size // size * size
    t_s, x, heading = (values[:whole].reshape(-1, size).mean(axis=1) for values in (
        rs.t_s, ts.heading_deg - rs.heading_deg, rs.heading_deg))
    straight = _find_straight(t_s, heading)
    breaks = np.flatnonzero(np.diff(t_s) > 2.5 * step_s) + 1
    for part in np.split(np.arange(t_s.size), breaks):
        for leg in np.split(part, np.flatnonzero(np.diff(straight[part].astype(int))) + 1):
            if leg.size and straight[leg[0]] and t_s[leg[-1]] - t_s[leg[0]] >= _LEAST_LEG_S:
                even = np.arange(t_s[leg[0]], t_s[leg[-1]], step_s)
                yield (np.interp(even, t_s[leg], x[leg]),
                       np.interp(even, t_s[leg], heading[leg]), step_s)


def _find_straight(t_s: Reals, heading_deg: Reals) -> np.ndarray:
    """Tell at which times the ship does not turn: over half a minute, and half a minute on."""
    half_s = 0.5 * FAST_PERIOD_S
    before = np.maximum(0, np.searchsorted(t_s, t_s - half_s))
    after = np.minimum(t_s.size - 1, np.searchsorted(t_s, t_s + half_s))
    # The mean of a period hides the yaw.
    total = np.concatenate([[0.0], np.cumsum(heading_deg)])
    mean = (total[after + 1] - total[before]) / (after + 1 - before)
    span_s = np.maximum(t_s[after] - t_s[before], 1e-9)
    turning = np.abs(mean[after] - mean[before]) / span_s > _TURNING_DEG_S
    wide = np.concatenate([[0], np.cumsum(turning)])
    straight: np.ndarray = wide[after + 1] == wide[before]
    return straight


def _split_leg(x_deg: Reals, rs_deg: Reals, step_s: float) -> tuple[Reals, Reals, Reals, float]:
    """Return the differences about their mean, their fast part, the yaw, and the time in it."""
    edge = max(1, round(FAST_PERIOD_S / step_s))
    sections = scipy.signal.butter(_ORDER, 2.0 * step_s / FAST_PERIOD_S, 'highpass', output='sos')
    fast, yaw = (scipy.signal.sosfiltfilt(sections, values)[edge:-edge]
                 for values in (x_deg - x_deg.mean(), rs_deg - rs_deg.mean()))
    inner = x_deg[edge:-edge]
    return inner - inner.mean(), fast, yaw, inner.size * step_s
