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
Pairs of made-up ships with two sound sensors, and the alarms that a watch raises on them.

The tests of the alarms and the benchmark `alarms` use them.
"""

from __future__ import annotations

from typing import Any

from error_processes import ar1
import numpy as np

from heading_intercompare.core.alarms.alarm import AlarmTable
from heading_intercompare.core.alarms.comparison_watch import COMPARISON_RULES, ComparisonWatch
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

NORMS = {'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}}
#: Norms that sensors keep which report whole degrees.
WHOLE_DEGREES = {'norms': {'sigma_max_deg': 0.6, 'sigma_ref_max_deg': 0.4}}
T0_NS = 1_700_000_000_000_000_000

_TURNING, _ALONGSIDE = {'motion': 'turning'}, {'motion': 'alongside'}
#: Kinds of ships, as arguments of `voyage`; in a swell, at 10 Hz, unless they say otherwise.
KINDS: dict[str, dict[str, Any]] = {
    'swell': {},
    'alongside': _ALONGSIDE,
    'turning': _TURNING,
    'turning, 1.2 s late': {**_TURNING, 'late_s': 1.2},
    'turning, 0.5 s early': {**_TURNING, 'late_s': -0.5},
    '1 Hz': {'rate_hz': 1.0},
    '1 Hz, turning, 1 s late': {'rate_hz': 1.0, **_TURNING, 'late_s': 1.0},
    '1 Hz, alongside': {'rate_hz': 1.0, **_ALONGSIDE},
    '100 Hz': {'rate_hz': 100.0},
    '100 Hz, turning': {'rate_hz': 100.0, **_TURNING},
    'tenths': {'step_deg': 0.1},
    'tenths, turning': {'step_deg': 0.1, **_TURNING},
    'tenths, alongside': {'step_deg': 0.1, **_ALONGSIDE},
    'whole degrees': {'step_deg': 1.0},
    'whole degrees, turning': {'step_deg': 1.0, **_TURNING},
    'whole degrees, alongside': {'step_deg': 1.0, **_ALONGSIDE},
    'whole degrees, 1 Hz, turning': {'step_deg': 1.0, 'rate_hz': 1.0, **_TURNING},
    'AR(1) of 60 s': {'tau_s': 60.0, 'ts_deg': 0.2},
    'AR(1) of 10 s, turning, 0.4 s late': {'tau_s': 10.0, 'ts_deg': 0.2, **_TURNING,
                                           'late_s': 0.4},
    'AR(1) of 300 s, alongside': {'tau_s': 300.0, 'ts_deg': 0.2, **_ALONGSIDE},
    'AR(1) of 60 s, 1 Hz': {'tau_s': 60.0, 'ts_deg': 0.2, 'rate_hz': 1.0},
    'Laplace': {'laplace': True, 'ts_deg': 0.2},
    'Laplace, 1 Hz, turning': {'laplace': True, 'rate_hz': 1.0, **_TURNING},
}


def course(rng, t_s, motion):
    """Return the heading of a ship alongside, in a swell, or with many turns."""
    if motion == 'alongside':
        return np.full(t_s.size, 77.3)
    period, phase = rng.uniform(5.0, 12.0, 12), rng.uniform(0.0, 2.0 * np.pi, 12)
    swell = 0.4 * np.sin(2.0 * np.pi * t_s[:, None] / period + phase).sum(axis=1)
    if motion == 'swell':
        return 310.0 + swell
    # Legs of two minutes, with turns of 90 deg at 1 to 3 deg/s between them.
    rate = np.zeros(t_s.size)
    for leg in range(int(t_s[-1] // 120.0) + 1):
        speed = rng.uniform(1.0, 3.0) * rng.choice((-1.0, 1.0))
        at_s = 120.0 * leg + 60.0
        rate[(t_s >= at_s) & (t_s < at_s + 90.0 / abs(speed))] = speed
    step = np.diff(t_s, prepend=t_s[0])
    return 20.0 + 0.5 * swell + np.cumsum(rate * step)


def voyage(rng, *, motion='swell', rate_hz=10.0, span_s=300.0, ts_deg=0.1, rs_deg=0.03, tau_s=0.0,
           step_deg=0.0, late_s=0.0, laplace=False):
    """Return time, TS and RS of a voyage, TS late, both rounded."""
    n = round(rate_hz * span_s)
    t = np.arange(n) / rate_hz
    both = course(rng, np.concatenate((t - late_s, t)), motion) if motion == 'alongside' else None
    if both is None:
        fine = np.arange(-round((late_s + 1.0) * rate_hz), n + 1) / rate_hz
        path = course(rng, fine - fine[0], motion)
        both = np.concatenate((np.interp(t - late_s, fine, path), np.interp(t, fine, path)))
    noise = rng.laplace(0.0, np.sqrt(0.5), n) if laplace else rng.standard_normal(n)
    ts = both[:n] + ts_deg * (ar1(tau_s * rate_hz)(rng, 1, n)[0] if tau_s else noise)
    rs = both[n:] + rs_deg * rng.standard_normal(n)
    if tau_s:
        ts = ts + 0.2 * ts_deg * rng.standard_normal(n)
    if step_deg:
        ts, rs = (step_deg * np.rint(h / step_deg) for h in (ts, rs))
    return t, ts % 360.0, rs % 360.0


def watch(t_s, ts, rs, every_s=1.0, settings=None, **values):
    """Return the history of a watch: (time, alarm) of each change of state; and the table."""
    watcher = ComparisonWatch(settings or Settings.from_mapping({**NORMS, **values}))
    table = AlarmTable(COMPARISON_RULES)
    stamps = T0_NS + np.rint(np.asarray(t_s) * 1e9).astype(np.int64)
    changes = []
    edges = np.searchsorted(t_s, np.arange(t_s[0] + every_s, t_s[-1] + 2.0 * every_s, every_s))
    lo = 0
    for hi in edges.tolist():
        watcher.update(Pairs.of(stamps[lo:hi], ts[lo:hi], rs[lo:hi]))
        lo = hi
        newest_ns = watcher.newest_ns or T0_NS
        changes += [((newest_ns - T0_NS) / 1e9, alarm)
                    for alarm in table.update(watcher.look(), newest_ns)]
    return changes, table


def norms_of(kind):
    """Return the settings with norms that the sensors of a kind keep."""
    return WHOLE_DEGREES if KINDS[kind].get('step_deg') == 1.0 else NORMS


def raised(changes):
    """Return the names of the alarms that were raised, in order."""
    return [alarm.rule.name for _, alarm in changes if alarm.state.active]
