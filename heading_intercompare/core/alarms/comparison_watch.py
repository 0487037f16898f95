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

"""The detectors of the verdict on the newest pairs, while the run is in progress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Mapping

import numpy as np

from heading_intercompare.core.angles import unwrap_deg, wrap360
from heading_intercompare.core.conditions.conventions import Convention, find_convention
from heading_intercompare.core.conditions.one_source import find_one_source, find_same_source
from heading_intercompare.core.conditions.standstill import (
    find_coarse_resolution,
    find_frozen,
    FROZEN_S,
)
from heading_intercompare.core.decision.criteria import require_norms
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Pairs, Reals
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.resolution import find_resolution
from heading_intercompare.core.timing.clock_drift import estimate_clock_drift
from heading_intercompare.core.validity.condition import NOT_TESTABLE, VOID
from heading_intercompare.core.verdict.judge import judge_run
from heading_intercompare.core.verdict.validity import CONDITIONS

from .alarm import Priority, Rule, Sign
from .jump_watch import JumpWatch
from .pair_window import PairWindow

COMPARISON_RULES = (
    Rule('ts_frozen'), Rule('rs_frozen'), Rule('rotated'), Rule('mirrored'), Rule('jump'),
    Rule('outliers', Priority.CAUTION, 10.0), Rule('same_source', clear_s=5.0),
    Rule('clock_step', clear_s=0.0),
    *(Rule(condition.name, clear_s=0.0) for condition in CONDITIONS if condition.is_alarm))
"""The alarms of a comparison; where one alarm explains another, the graver alarm comes first."""

# The newest readings, which show a rotation at once.
_RECENT_S, _FEWEST = 1.5, 3
_EQUAL_DEG = 1e-7
# A sensor that repeats its value less often than this may be frozen if it does so for long.
_OFTEN = 0.5
# A turn shows a mirrored axis in the first of these spans that holds enough of it.
_TURN_SPANS_S = 15.0, 60.0
_LEAST_OF_TURN, _GRAINS = 8, 5.0
_TURNING_DEG, _ALONG = 2.0, 0.5
# A copy repeats 300 readings or more; a late or filtered one shows in some minutes of noise.
_COPIED, _NOISE_S = (320, 1280), 180.0
# Smaller steps of the skew decide few outcomes, and in a short window some are chance.
_LEAST_STEP_S = 0.3
# A repetition is examined again when the other sensor has moved this much further, or later.
_FURTHER, _AGAIN_NS = 1.05, 10 * 10 ** 9
# The slow detectors run this seldom, seconds of stamp time.
_NOISE_EVERY_S, _CLOCK_EVERY_S, _STEP_EVERY_S, _RUN_EVERY_S = 20.0, 30.0, 10.0, 300.0


@dataclass(slots=True)
class _Repeated:
    """The repetition of one sensor that was last examined; to examine each one seldom."""

    name: str
    looked_ns: int = -1
    moved_deg: float = 0.0
    found_deg: float | None = None

    def needs_look(self, first_ns: int, now_ns: int, moved_deg: float) -> bool:
        """Tell whether this repetition is new, or the other sensor has moved on since."""
        if first_ns > self.looked_ns:
            self.found_deg = None
        elif self.found_deg is not None or (moved_deg <= _FURTHER * self.moved_deg
                                            and now_ns < self.looked_ns + _AGAIN_NS):
            return False
        self.looked_ns, self.moved_deg = now_ns, moved_deg
        return True

    def sign(self, lasted_s: float) -> Sign:
        """Return the sign of a repetition that goes on."""
        if self.found_deg is None:
            return Sign(None)
        return Sign(True, f'the {self.name} has repeated its value for {lasted_s:.0f} s, while '
                    f'the other sensor moved by {self.found_deg:.2f} deg',
                    {'lasted_s': lasted_s, 'other_moved_deg': self.found_deg})


class ComparisonWatch:
    """
    Looks for the conditions of a verdict in the newest pairs.

    Parameters
    ----------
    settings
        Must hold the norms.

    Notes
    -----
    The detectors and their thresholds are those of the verdict. They see the newest part of the
    rolling window, at most 65536 pairs. One situation has one alarm: a frozen sensor explains what
    looks rotated, mirrored or like a jump; a rotated or mirrored one explains a jump; and a jump
    explains outliers. A condition without a detector of its own here is judged every five minutes,
    on the window as if it were a run.

    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._ts_norm_deg, self._rs_norm_deg = require_norms(settings.norms, settings.model)
        # The window as a run: all of it, with no looks and nothing left out.
        self._as_run = replace(
            settings, exclusions=None, runs=replace(settings.runs, stabilization_s=0.0),
            sequential=replace(settings.sequential, plan_s=None))
        self._window = PairWindow(settings.window_s)
        # What the signs last said for sure.
        self._raised: dict[str, bool] = {}
        self._begin_segment(0)

    def _begin_segment(self, number: int) -> None:
        """Begin again, where stamps are repeated after a clock was set back."""
        self._segment = number
        self._window.clear()
        self._jumps = JumpWatch(self._settings.alignment.skew_range_s)
        self._looked_ns: int | None = None
        self._due_ns: dict[str, int] = {}
        self._step_deg, self._repeats = 0.0, False
        self._repeated = {name: _Repeated(name) for name in ('TS', 'RS')}
        self._turned_with_ns = self._explained_ns = 0
        self._steps = find_resolution([]), find_resolution([])
        self.newest_ns: int | None = None

    def update(self, pairs: Pairs) -> None:
        """Take pairs in the order of their segments and stamps."""
        for part in pairs.in_segments():
            if int(part.segment[0]) != self._segment:
                self._begin_segment(int(part.segment[0]))
            self._update(part)

    def _update(self, pairs: Pairs) -> None:
        if self.newest_ns is not None and (int(pairs.stamp_ns[0]) - self.newest_ns
                                           > self._settings.runs.gap_s * 1e9):
            self._window.clear()
            self.accept_level()
        self._window.update(pairs, subtract(pairs, self._settings.installation_offset_deg,
                                            self._settings.wrap_center_deg))
        self.newest_ns = int(pairs.stamp_ns[-1])

    def resize(self, window_s: float) -> None:
        """Change the length of the window, seconds."""
        self._window.resize(window_s)

    def accept_level(self) -> None:
        """Take the present level of the differences as the usual one, as at the start of a run."""
        self._jumps.reset()

    def look(self) -> dict[str, Sign]:
        """Return the signs at the newest pair; none if no pair has come since the last look."""
        window = self._window
        if not len(window) or self.newest_ns == self._looked_ns:
            return {}
        since_ns, self._looked_ns = self._looked_ns, self.newest_ns
        ts = wrap360(window.x_deg + window.rs_deg + self._settings.installation_offset_deg)
        if self._is_due('step', _STEP_EVERY_S):
            self._steps = find_resolution(ts), find_resolution(window.rs_deg)
            # In a short window a coarse sensor has changed too seldom to show its step.
            self._step_deg = max(find_coarse_resolution(h) or 0.0 for h in (ts, window.rs_deg))
        self._repeats = False
        signs = {'ts_frozen': self._look_frozen('TS', ts, window.rs_deg, self._rs_norm_deg),
                 'rs_frozen': self._look_frozen('RS', window.rs_deg, ts, self._ts_norm_deg)}
        if self._remember(signs):
            signs |= {'rotated': Sign(False), 'mirrored': Sign(None)}
        else:
            signs['mirrored'] = self._look_mirrored()
            mirrored = self._remember({'mirrored': signs['mirrored']})
            signs['rotated'] = Sign(False) if mirrored else self._look_rotated()
        explained = self._remember(signs)
        signs |= self._jumps.look(window, self._step_deg, since_ns, explained, self._repeats)
        signs['same_source'] = self._look_same_source(ts)
        if self._is_due('clock', _CLOCK_EVERY_S):
            signs['clock_step'] = self._look_clock()
        self._remember(signs)
        if any(self._raised.values()):
            # What a detector of its own explains is no news of another condition, then and later.
            self._explained_ns = self.newest_ns or 0
        elif self._is_due('run', _RUN_EVERY_S):
            signs |= self._look_at_conditions()
        return signs

    def _remember(self, signs: Mapping[str, Sign]) -> bool:
        """Keep what these signs last said for sure; tell whether one of their conditions holds."""
        self._raised |= {name: sign.active for name, sign in signs.items()
                         if sign.active is not None}
        return any(self._raised.get(name, False) for name in signs)

    def _is_due(self, name: str, every_s: float) -> bool:
        newest_ns = self.newest_ns or 0
        if newest_ns < self._due_ns.get(name, newest_ns):
            return False
        self._due_ns[name] = newest_ns + round(every_s * 1e9)
        return True

    def _look_frozen(self, name: str, heading: Reals, other_deg: Reals, sigma_deg: float) -> Sign:
        """
        Judge the repetition that goes on now.

        `find_frozen` judges it. Only the search for its beginning is here, because that must be
        as fast as a message.
        """
        window = self._window
        changes = np.flatnonzero(np.abs(heading - heading[-1]) > _EQUAL_DEG)
        first = int(changes[-1]) + 1 if changes.size else 0
        lasted_s = (int(window.stamp_ns[-1]) - int(window.stamp_ns[first])) / 1e9
        step = self._steps[name == 'RS']
        if lasted_s >= _RECENT_S and heading.size - first >= _FEWEST \
                and (step.repeated_share or 0.0) < _OFTEN:
            self._repeats = True
        if lasted_s < FROZEN_S:
            return Sign(False)
        repetition = self._repeated[name]
        moved_deg = float(np.ptp(unwrap_deg(other_deg[first:])))
        if not repetition.needs_look(int(window.stamp_ns[first]), self.newest_ns or 0, moved_deg):
            return repetition.sign(lasted_s)
        frozen = find_frozen(window.stamp_ns, heading, other_deg, moved_deg=0.0,
                             sigma_deg=sigma_deg, still_frozen=True)
        norms = self._settings.norms
        sigma_deg = max(norms.sigma_max_deg or 0.0, norms.sigma_ref_max_deg or 0.0)
        if frozen.kind != 'frozen' or not frozen.is_plain(sigma_deg):
            # The sensor may be frozen on a steady course, or at rest alongside.
            repetition.found_deg = None
        else:
            repetition.found_deg = frozen.other_moved_deg
        return repetition.sign(lasted_s)

    def _look_rotated(self) -> Sign:
        window = self._window
        at = min(window.find(_RECENT_S), len(window) - _FEWEST)
        if at < 0:
            return Sign(None)
        x, rs = window.x_deg[at:], window.rs_deg[at:]
        convention = self._find_convention(at)
        turned = float(np.ptp(unwrap_deg(rs)))
        if turned > _TURNING_DEG and float(np.ptp(unwrap_deg(x))) > _ALONG * turned:
            # What turns along is no rotation: a mirrored or frozen sensor passes by 90 degrees.
            return Sign(None)
        if convention.kind == 'mirrored' or convention.angle_deg is None:
            return Sign(None)
        angle_deg = convention.angle_deg
        return Sign(convention.kind == 'offset', f'TS - RS is near {angle_deg:.0f} deg: does one '
                    'of them report yaw (ENU) as heading, or is one mounted backwards?',
                    {'angle_deg': angle_deg})

    def _look_mirrored(self) -> Sign:
        for span_s in _TURN_SPANS_S:
            at = max(self._window.find(span_s), int(np.searchsorted(
                self._window.stamp_ns, self._turned_with_ns)))
            if len(self._window) - at < _LEAST_OF_TURN:
                continue
            convention = self._find_convention(at)
            if convention.turned_deg < _GRAINS * self._step_deg:
                continue
            if convention.kind == 'mirrored' and convention.angle_deg is not None:
                return Sign(True, 'TS turns against RS, and their sum stays at '
                            f'{convention.angle_deg:.1f} deg: '
                            'one of them counts counter-clockwise',
                            {'angle_deg': convention.angle_deg,
                             'turned_deg': convention.turned_deg})
            if convention.direction == 'with':
                # What was before that says nothing of a mirrored axis now.
                self._turned_with_ns = int(self._window.stamp_ns[at])
                return Sign(False)
        return Sign(None)

    def _find_convention(self, at: int) -> Convention:
        window = self._window
        return find_convention(
            window.x_deg[at:], window.rs_deg[at:],
            self._settings.detectors.convention_tolerance_deg, stamp_ns=window.stamp_ns[at:],
            range_s=self._settings.alignment.skew_range_s)

    def _look_same_source(self, ts: Reals) -> Sign:
        window = self._window
        for n in _COPIED:
            x, rs = window.x_deg[-n:], window.rs_deg[-n:]
            readings = find_same_source(x, rs, *self._steps)
            if readings.suspected:
                return Sign(True, f'the TS repeats the last {len(x)} readings of the RS: both may '
                            'be one sensor')
            if readings.suspected is not None:
                break
        if not self._is_due('noise', _NOISE_EVERY_S):
            return Sign(None)
        at = window.find(_NOISE_S)
        source = find_one_source(
            window.stamp_ns[at:], window.x_deg[at:], window.rs_deg[at:],
            factor=window.factor[at:], interpolates_ts=window.interpolates_ts)
        if source.kind in ('common', 'suspected'):
            return Sign(True, 'the TS follows the noise or the glitches of the RS: both look like '
                        'one sensor', {'coherence': source.noise.strongest.coherence})
        if source.kind == 'independent' or readings.suspected is False:
            return Sign(False)
        return Sign(None)

    def _look_clock(self) -> Sign:
        window, alignment = self._window, self._settings.alignment
        if alignment.skew == 'off':
            return Sign(None)
        drift = estimate_clock_drift(window.stamp_ns, window.x_deg, window.rs_deg,
                                     range_s=alignment.skew_range_s,
                                     max_gap_s=self._settings.pairing.longest_gap_s)
        if drift.kind != 'stepped':
            return Sign(None if drift.kind == 'not_testable' else False)
        step = max(drift.steps, key=lambda step: abs(step.after_s - step.before_s))
        size_s = step.after_s - step.before_s
        if abs(size_s) < _LEAST_STEP_S:
            return Sign(None)
        return Sign(True, f'the clock offset between TS and RS stepped by {size_s:+.2f} s',
                    {'step_s': size_s, 'step_ns': int(window.stamp_ns[0])
                     + round(step.time_s * 1e9)})

    def _look_at_conditions(self) -> dict[str, Sign]:
        """Judge as a run what no alarm explains; the first condition to void it is the cause."""
        pairs, differences = self._window.to_pairs(self._as_run.installation_offset_deg)
        at = int(np.searchsorted(pairs.stamp_ns, self._explained_ns, 'right'))
        if at == len(pairs):
            return {}
        run = RunSeries(int(pairs.stamp_ns[at]), self._as_run)
        run.update(pairs[at:], differences[at:])
        findings = {f.condition: f for f in judge_run(run, self._as_run, 1, '').verdict.validity}
        cause = next((name for name, finding in findings.items() if finding.effect == VOID), None)
        signs = {}
        for name in (condition.name for condition in CONDITIONS if condition.is_alarm):
            finding = findings.get(name)
            if finding is None or finding.effect == NOT_TESTABLE or cause not in (None, name):
                signs[name] = Sign(None)
            else:
                signs[name] = Sign(name == cause, finding.words)
        return signs
