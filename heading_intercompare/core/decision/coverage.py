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

"""What a verdict covers: slow and fast errors, headings, latitude; and the length needed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Mapping, Sequence

import numpy as np

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.required_tests import SYSTEMATIC
from heading_intercompare.core.settings import Risk, Settings
from heading_intercompare.core.statistics.variance_uncertainty import LEAST_TIMES

from .norm_presets import list_required

_SECTOR_DEG = 10
_ARCS = 3
_USUAL_RISK = 0.05
#: Headings looked at at once.
_PIECE = 1 << 15


def _list_sectors(heading_deg: Reals) -> list[int]:
    """Return the numbers of the sectors of ten degrees with headings, in rising order."""
    seen = np.zeros(361 // _SECTOR_DEG + 1, bool)
    for lo in range(0, len(heading_deg), _PIECE):
        seen[np.mod(heading_deg[lo:lo + _PIECE], 360.0).astype(np.int64) // _SECTOR_DEG] = True
    return np.flatnonzero(seen).tolist()


@dataclass(frozen=True, slots=True)
class Scope:
    """The scope of a certificate; keys of the JSON."""

    shortest_s: float | None = figure('errors that change faster fall between the pairs',
                                      'two usual steps', default=None)
    headings_deg: tuple[int, ...] = figure(
        'starts of the sectors of ten degrees in which the ship headed, by the RS', default=())
    latitude_deg: tuple[float, float] | None = figure('latitudes of the trial as stated',
                                                      'null if not stated', default=None)
    mean_is_judged: bool = figure('the mean difference has a norm', default=False)
    alpha_consumer: float = figure('risk of certifying a TS at its norm', default=_USUAL_RISK)

    @classmethod
    def of(cls, stamp_ns: Integers, heading_deg: Reals, settings: Settings) -> 'Scope':
        """Return the scope of a run with these pairs and headings of the RS."""
        step_s = None if len(stamp_ns) < 2 else float(
            np.median(np.diff(stamp_ns), overwrite_input=True)) / 1e9
        sectors = _list_sectors(heading_deg)
        return replace(cls.state(settings), shortest_s=None if step_s is None else 2.0 * step_s,
                       headings_deg=tuple(sector % 36 * _SECTOR_DEG for sector in sectors))

    @classmethod
    def state(cls, settings: Settings) -> 'Scope':
        """Return the scope as far as the settings state it."""
        trial, stated = settings.trial, settings.norms.latitude_deg
        low = trial.latitude_min_deg if trial.latitude_min_deg is not None else stated
        high = trial.latitude_max_deg if trial.latitude_max_deg is not None else stated
        ends = [end for end in (low, high) if end is not None]
        return cls(latitude_deg=(ends[0], ends[-1]) if ends else None,
                   mean_is_judged=settings.norms.total_error_max_deg is not None or any(
                       test.kind in SYSTEMATIC for test in list_required(settings.norms)),
                   alpha_consumer=settings.risk.alpha_consumer)

    @classmethod
    def join(cls, scopes: Sequence['Scope']) -> 'Scope | None':
        """Return the scope of several runs together; None for none."""
        if not scopes:
            return None
        steps = [scope.shortest_s for scope in scopes if scope.shortest_s is not None]
        first = scopes[0]
        return cls(max(steps, default=None),
                   tuple(sorted({at for scope in scopes for at in scope.headings_deg})),
                   first.latitude_deg, first.mean_is_judged, first.alpha_consumer)

    @property
    def words(self) -> str:
        """Return headings, latitude, mean and risk in words."""
        parts = [_headings_words(self.headings_deg)] if self.headings_deg else []
        if self.latitude_deg is None:
            parts.append('latitude not stated')
        else:
            low, high = self.latitude_deg
            parts.append(f'latitude {low:g}' + (f' to {high:g}' if high != low else '') + ' deg')
        if not self.mean_is_judged:
            parts.append('the mean is not judged, for no norm is set for it')
        if self.alpha_consumer != _USUAL_RISK:
            parts.append(f"consumer's risk {self.alpha_consumer:g}")
        return '; '.join(parts)


def _headings_words(starts: Sequence[int]) -> str:
    """Return the sectors as arcs."""
    if len(starts) == 360 // _SECTOR_DEG:
        return 'all headings'
    held = set(starts)
    begins = [at for at in starts if (at - _SECTOR_DEG) % 360 not in held]
    if len(begins) > _ARCS:
        return f'headings in {_SECTOR_DEG * len(starts)} deg of 360'
    arcs = []
    for begin in begins:
        end = begin + _SECTOR_DEG
        while end % 360 in held:
            end += _SECTOR_DEG
        arcs.append(f'{begin:03d}-{(end - 1) % 360 + 1:03d}')
    return f'headings {", ".join(arcs)} deg'


SEA_STATE_S = 1800.0
"""
Time in which the sea state changes, and the size of the errors with it, seconds.

Wave buoys take the sea as steady over records of half an hour.
"""

UNSTATED_LEAST_S = 600.0
"""Least duration of a run if the slowest error is not stated, seconds."""


@dataclass(frozen=True, slots=True)
class SensorClass:
    """
    The slowest error of a class of heading sensors.

    Attributes
    ----------
    title
        The instruments.
    error_s
        Time in which the correlation of the slowest error falls to 1/e, seconds. For an
        oscillation this is its coherence time, never its period.
    source
        Source of the figure.
    trial
        The trial that is long enough, in words.
    settles_s
        Time from power-on within which it must have settled, seconds; 0 if no norm grants any.

    """

    title: str
    error_s: float
    source: str
    trial: str
    settles_s: float = 0.0

    @property
    def slowest_s(self) -> float:
        """Return the slowest time of everything: the errors, and how their size changes."""
        return max(self.error_s, SEA_STATE_S)

    @property
    def least_s(self) -> float:
        """Least length of a run, seconds."""
        return LEAST_TIMES * self.slowest_s


SENSOR_CLASSES: Mapping[str, SensorClass] = {
    'gyrocompass': SensorClass(
        'gyrocompass, Schuler-tuned and damped', 2300.0,
        'a swing of 84.4 min, damped to a third at each half swing, falls to 1/e in '
        '42.2 min / ln 3 = 38.4 min',
        'ten runs of 6.4 h with campaign.rule sensor, or one of at least 12.8 h', 6.0 * 3600.0),
    'ins': SensorClass(
        'inertial navigation system, unaided', 86164.0,
        'Schuler, Foucault and Earth-rate oscillations are undamped: they stay coherent for at '
        'least a sidereal day',
        'no single run can certify it (20 days); at least ten runs, with a new alignment before '
        'each, with campaign.rule sensor'),
    'ins_aided': SensorClass(
        'inertial navigation system, aided by GNSS', 1800.0,
        'only manoeuvres make the heading observable; 30 min is a typical time constant of that '
        "filter state, to be replaced by the manufacturer's figure",
        'ten runs of 5 h with campaign.rule sensor, or one of at least 10 h'),
    'gnss_compass': SensorClass(
        'GNSS compass', 300.0,
        'multipath from a reflector at 2 m changes by one wavelength of 0.19 m in 340 s, because '
        'a satellite moves by 0.14 mrad/s; nearer reflectors are slower and weaker',
        'ten runs of 5 h with campaign.rule sensor, or one of at least 10 h'),
}
"""The classes by their names in `risk.sensor_class`."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """The errors that a record covers; keys of the JSON."""

    span_s: float = figure('length analysed')
    longest_s: float = figure('slowest errors covered, if the run decides', 'a twentieth of the '
                              'length, or the shortest time between runs whose means count')
    stated_s: float | None = figure('slowest error stated', 'null if none is')
    least_duration_s: float = figure('least length of a run that may comply')
    by_run_means: bool = figure('the means of several runs cover slower errors', default=False)
    scope: Scope | None = figure('what else a certificate covers', absent='without a run')

    @property
    def words(self) -> str:
        """Return the line of a certificate that states its coverage."""
        covered = f'for errors that change within {span_words(self.longest_s)}'
        if self.scope is not None and self.scope.shortest_s is not None:
            covered += f' and not faster than {span_words(self.scope.shortest_s)}'
        covered += ', and that come at least three times in the run'
        if self.by_run_means:
            covered += ', or from run to run'
        covered += ('; slower errors are not covered' if self.stated_s is None
                    else f'; the slowest stated is {span_words(self.stated_s)}')
        return f'{covered}; {self.scope.words}' if self.scope is not None else covered


def span_words(span_s: float) -> str:
    """
    Return a span of time in words.

    Examples
    --------
    >>> span_words(31.2), span_words(600.0), span_words(46000.0)
    ('31 s', '10 min', '12.8 h')

    """
    if span_s < 120.0:
        return f'{span_s:.3g} s' if span_s < 10.0 else f'{span_s:.0f} s'
    if span_s < 7200.0:
        return f'{span_s / 60.0:.0f} min'
    return f'{span_s / 3600.0:.1f} h'


def slowest_error_s(risk: Risk) -> float | None:
    """Return the slowest error stated in the settings, seconds; None if not stated."""
    if risk.slowest_error_s is not None:
        return risk.slowest_error_s
    if risk.sensor_class is None:
        return None
    return SENSOR_CLASSES[risk.sensor_class].slowest_s


def settling_time_s(risk: Risk) -> float:
    """
    Return the time that the class of the sensor has to settle after power-on, seconds.

    Examples
    --------
    >>> from heading_intercompare.core.settings import Risk
    >>> settling_time_s(Risk(sensor_class='gyrocompass')) / 3600.0, settling_time_s(Risk())
    (6.0, 0.0)

    References
    ----------
    IMO A.424(XI) and A.821(19): a gyro-compass settles within 6 h.

    """
    return 0.0 if risk.sensor_class is None else SENSOR_CLASSES[risk.sensor_class].settles_s


def least_duration_s(risk: Risk) -> float:
    """
    Return the least length of a run that may comply, seconds.

    It is the longer of twenty times the slowest error and `risk.min_duration_s`, as far as these
    are stated, and 600 s if neither is.

    Examples
    --------
    >>> least_duration_s(Risk()), least_duration_s(Risk(min_duration_s=60.0))
    (600.0, 60.0)
    >>> least_duration_s(Risk(slowest_error_s=100.0, min_duration_s=60.0))
    2000.0

    """
    slowest = slowest_error_s(risk)
    stated = [s for s in (None if slowest is None else LEAST_TIMES * slowest,
                          risk.min_duration_s) if s is not None]
    return max(stated, default=UNSTATED_LEAST_S)


def least_apart_s(risk: Risk) -> float:
    """Return the least time between runs whose means count as independent, seconds."""
    slowest = slowest_error_s(risk)
    return UNSTATED_LEAST_S if slowest is None else slowest


def least_together_s(risk: Risk) -> float:
    """Return the least total length of runs that may comply by their means, seconds."""
    return UNSTATED_LEAST_S if risk.min_duration_s is None else risk.min_duration_s


def least_duration_words(risk: Risk) -> str:
    """
    Return in words how long a run must be to comply and why, to be shown before the trial.

    Examples
    --------
    >>> least_duration_words(Risk(slowest_error_s=300.0))
    'a run must last 100 min to comply: 20 times its slowest error, 5 min'

    """
    text = f'a run must last {span_words(least_duration_s(risk))} to comply'
    slowest = slowest_error_s(risk)
    if slowest is None:
        return f'{text}; its slowest error is not stated (risk.slowest_error_s)'
    if risk.min_duration_s is not None and risk.min_duration_s > LEAST_TIMES * slowest:
        return f'{text} (risk.min_duration_s)'
    return f'{text}: {LEAST_TIMES:g} times its slowest error, {span_words(slowest)}'


def coverage_of(span_s: float, risk: Risk, *, apart_s: float | None = None,
                scopes: Sequence[Scope] = ()) -> Coverage:
    """
    Return the errors that a record of this length covers.

    Parameters
    ----------
    span_s
        Length of the record, or of all runs together, seconds.
    risk
        Its slowest errors stated, and the risks.
    apart_s
        Shortest time between runs, seconds, if their means cover slower errors.
    scopes
        Those of the runs.

    """
    longest, scope = span_s / LEAST_TIMES, Scope.join(scopes)
    if apart_s is None:
        return Coverage(span_s, longest, slowest_error_s(risk), least_duration_s(risk),
                        scope=scope)
    return Coverage(span_s, max(longest, apart_s), slowest_error_s(risk), least_together_s(risk),
                    True, scope)
