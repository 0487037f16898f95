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

"""The steps of stamps: the usual step, silences, and the share of lost readings."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Iterable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.pairing.direction import typical_step_ns
from heading_intercompare.core.settings import SILENCE_STEPS
from heading_intercompare.core.statistics.blocking import pick_stretches

_LOOKED_AT = 40_000
_QUANTILES = (0.1, 0.25, 0.5)
_ROUNDS, _NEAR = 3, 3
_FEW = 6
_TOGETHER = 0.4
#: Below half as much again, a step is one step.
_ALL_ONE = 1.49
_ASTRAY = 1.5
_PHASES, _COHERENT = 8, 0.45
_FINER, _AS_GOOD = (-0.03, -0.02, -0.01, -0.005, 0.005, 0.01, 0.02, 0.03), 0.02
_LONGEST_NS = 5e9
_PAUSE = 10.0


@dataclass(frozen=True, slots=True)
class StampSteps:
    """The steps between the stamps of one stream."""

    n: int = figure('stamps')
    typical_s: float | None = figure('median step of the stamps', default=None)
    nominal_s: float | None = figure('step of the sensor', 'its stamps are multiples of it, even '
                                     'if readings are missing', default=None)
    lost_share: float | None = figure('share of readings that the stamps show as missing',
                                      'between the first and the last', default=None)
    backward: int = figure('steps back', default=0)
    equal: int = figure('equal stamps', default=0)
    silences: int = figure('silences', 'steps of more than ten typical ones', default=0)
    longest_back_s: float | None = figure('longest step back', 'null without any', default=None)
    longest_s: float | None = figure('longest step', default=None)


def _cut_steps(stamps: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the steps piece by piece."""
    for lo in range(0, stamps.size - 1, _LOOKED_AT):
        yield np.diff(stamps[lo:lo + _LOOKED_AT + 1])


def _nominal_ns(steps: np.ndarray) -> float | None:
    """Return the step whose multiples the stamps follow, nanoseconds; None if there is none."""
    pauses = np.sort(steps)
    bridged = np.cumsum(pauses)
    by_time = pauses[np.searchsorted(bridged, np.array(_QUANTILES) * bridged[-1])]
    tried = {*np.quantile(steps, _QUANTILES).tolist(), *by_time.tolist()}
    if steps.size > 1:
        tried.add(float(np.median(steps[1:] + steps[:-1])))
    # The longest first: a step that another one holds twice is not the step of the sensor.
    for first in sorted(tried, reverse=True):
        step = first
        for _ in range(_ROUNDS):
            near = steps[steps <= (_NEAR + 0.5) * step]
            count = float(_multiples(near, step).sum())
            step = float(near.sum()) / count if count else math.inf
        sent = steps[steps <= max(_LONGEST_NS, _FEW * step)]
        few = float(sent[sent <= (_FEW + 0.5) * step].sum())
        if not first / _ASTRAY < step < first * _ASTRAY or 3.0 * few <= float(sent.sum()):
            continue
        begins = _multiples(steps, step) > 0.0
        if step > _LONGEST_NS and 2 * np.count_nonzero(begins) < begins.size:
            continue
        stamps = np.append(0, np.cumsum(steps))[np.append(True, begins)]
        finer = [step * (1.0 + off) for off in (0.0, *_FINER)]
        coherences = [_coherence(stamps, c) for c in finer]
        if max(coherences) >= _COHERENT:
            best: float = finer[int(np.argmax(coherences))]
            return step if coherences[0] > max(coherences) - _AS_GOOD else best
    return None


def _multiples(steps: np.ndarray, step: float) -> np.ndarray:
    """Return how often a step fits into each of `steps`; 0 for readings that belong together."""
    times = steps / step
    return np.where(times > _TOGETHER, np.maximum(1.0, np.rint(times)), 0.0)


def _coherence(stamps: np.ndarray, step: float) -> float:
    """Return the mean length of the phase vector of a few stamps: 1 for exact multiples."""
    wide = min(_PHASES, stamps.size)
    rows = stamps.size // wide
    phase = stamps[:rows * wide].reshape(rows, wide) / step
    phase -= np.floor(phase[:, :1])
    return float(np.abs(np.exp(2j * np.pi * phase).mean(axis=1)).mean())


def _lost_share(pieces: Iterable[np.ndarray], nominal: float | None) -> float:
    """Return the share of the readings that the steps skip."""
    if nominal is None:
        steps = np.concatenate(list(pieces))
        usual = _usual_ns(steps)
        silent = steps[steps > SILENCE_STEPS * usual]
        return float((silent - usual).sum()) / float(steps.sum())
    missing = places = 0.0
    for part in pieces:
        if _TOGETHER * nominal < part.min() and part.max() < _ALL_ONE * nominal:
            # Each reading came, and no two readings together.
            places += part.size
            continue
        times = _multiples(part, nominal)
        ends = np.flatnonzero(times)
        if ends.size:
            # After an early reading the next step is long, but no reading is missing.
            together = np.diff(ends, prepend=-1)
            left = times[ends] - np.maximum(1.0, together / np.median(together))
            missing += float(np.maximum(0.0, left).sum())
            places += float(times.sum())
    return missing / places if places else 0.0


def _usual_ns(steps: np.ndarray) -> float:
    """Return the typical step; without the pauses, if it is itself a pause."""
    usual = typical_step_ns(np.append(0, np.cumsum(steps))) or 0
    longest = max(_LONGEST_NS, _PAUSE * float(np.median(steps)))
    if usual > longest:
        usual = typical_step_ns(np.append(0, np.cumsum(steps[steps <= longest]))) or 0
    return float(usual)


def measure_stamp_steps(stamp_ns: ArrayLike) -> StampSteps:
    """
    Measure the steps from stamp to stamp.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps in order of arrival, nanoseconds.

    Returns
    -------
    StampSteps

    Notes
    -----
    The stamps follow the multiples of a step c, wherever these start, on two conditions:

    * the mean of exp(2 pi i t / c) over eight stamps in a row has a mean length of at least 0.45
      (jitter with a standard deviation of a fifth of the step gives 0.55, random stamps 0.31);
    * at least a third of the time passes in steps of up to six c, pauses of more than five
      seconds not counted. Without this, events and bursts would pass too: their stamps also lie
      on a grid.

    Readings less than 0.4 c apart belong together, and the longest such c counts. The lost
    readings are then those that the steps skip. Without such a c, the lost readings are those
    that would fill the silences, steps of more than ten times the usual one. The
    usual step is `typical_step_ns`, taken without the pauses if it is itself a pause.

    Examples
    --------
    >>> steps = measure_stamp_steps([0, 1_000_000_000, 2_000_000_000, 500_000_000, 30_000_000_000])
    >>> steps.backward, steps.longest_back_s, steps.silences
    (1, 1.5, 1)

    """
    stamps = np.asarray(stamp_ns, dtype=np.int64)
    if stamps.size < 2:
        return StampSteps(n=stamps.size)
    typical = float(np.median(np.concatenate([np.diff(stamps[part])
                                              for part in pick_stretches(stamps.size)])))
    backward = equal = silences = 0
    least, most = math.inf, -math.inf
    for steps in _cut_steps(stamps):
        low, high = int(steps.min()), int(steps.max())
        least, most = min(least, low), max(most, high)
        if low <= 0:
            backward += int(np.count_nonzero(steps < 0))
            equal += int(np.count_nonzero(steps == 0))
        if high > SILENCE_STEPS * typical > 0.0:
            silences += int(np.count_nonzero(steps > SILENCE_STEPS * typical))
    onward = stamps
    if least <= 0:
        steps = np.diff(stamps)
        onward = np.append(0, np.cumsum(steps[steps > 0]))
    nominal = _nominal_ns(np.diff(onward[:_LOOKED_AT + 1])) if onward.size > 1 else None
    return StampSteps(
        n=stamps.size, typical_s=typical / 1e9,
        nominal_s=None if nominal is None else nominal / 1e9,
        lost_share=(_lost_share(_cut_steps(onward), nominal)
                    if onward.size > 1 else 0.0),
        backward=backward, equal=equal, silences=silences,
        longest_back_s=-least / 1e9 if least < 0 else None, longest_s=most / 1e9)
