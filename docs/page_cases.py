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

"""Messages of made-up graphs with a fault each, for the pictures of the live page."""

from __future__ import annotations

from typing import Any, Sequence

import numpy as np

from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import ERROR, OK, Status, WARN
from heading_intercompare.web.bridge.bridge_view import Bridge

_S = 10 ** 9
_NOW_NS = 1_764_300_000 * _S
#: The time of the steady clock at which all messages came.
_CAME_S = 100.0
SEEN_S = 100.5
"""The time of the steady clock at which the pictures are taken, seconds."""

_RS_DEG, _SD_DEG, _LIMIT_DEG2 = 73.9, 0.12, 0.1
_PAIRS, _STEP_NS = 7000, _S // 4


def _alarm(name: str, priority: str = 'warning', **figures: Any) -> Status:
    return Status(name, WARN, name, {
        'state': 'active_unacknowledged', 'priority': priority,
        'raised_ns': str(_NOW_NS - 12 * _S),
        **{key: str(value) for key, value in figures.items()}})


def _stamps(n: int, step_ns: int) -> np.ndarray:
    return _NOW_NS - np.arange(n)[::-1] * step_ns


def _two(alarms: Sequence[Status], fault_deg: float = 0.0, silent_s: float = 0.0) -> Bridge:
    """Return a trial of two sensors with a judged run; the fault is in the last 200 s."""
    bridge = Bridge(Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}), limits_deg={'ts': 0.6})
    x_deg = 0.2 + _SD_DEG * np.random.default_rng(1).standard_normal(_PAIRS)
    stamps = _stamps(_PAIRS, _STEP_NS) - round(silent_s * _S)
    bridge.take_pairs(Pairs.of(stamps, np.mod(_RS_DEG + x_deg, 360.0),
                               np.full(_PAIRS, _RS_DEG)), _CAME_S - silent_s)
    bridge.take_health([Status(f'{node}: node', OK, 'running', {}, f'/{node} 1')
                        for node in ('compliance', 'synchronizer', 'recorder')], _CAME_S)
    bridge.view(_CAME_S)
    recent = _stamps(20, _S // 10)
    late = round(silent_s * _S)
    bridge.take_headings('ts', Headings.of(recent - late, np.full(
        20, (_RS_DEG + 0.26 + fault_deg) % 360.0)), _NOW_NS, _CAME_S - silent_s)
    bridge.take_headings('rs', Headings.of(recent, np.full(20, _RS_DEG)), _NOW_NS, _CAME_S)
    bridge.take_alarms([alarm for alarm in alarms if alarm.name.startswith('compliance')], _CAME_S)
    bridge.take_alarms([alarm for alarm in alarms if alarm.name.startswith('sync')], _CAME_S)
    if fault_deg:
        bridge.take_pairs(Pairs.of(
            recent, np.mod(_RS_DEG + fault_deg + x_deg[-20:], 360.0), np.full(20, _RS_DEG)),
            _CAME_S)
    std_deg = _SD_DEG + 0.18 * abs(fault_deg)
    figures = {'std_deg': str(std_deg), 'limit_deg2': str(_LIMIT_DEG2), 'mean_deg': '0.2'}
    bridge.take_rolling(_NOW_NS, [Status('rolling', OK, '', {'n': '2400', **figures})], _CAME_S)
    bridge.take_run(_NOW_NS, [Status('run', OK, '', {
        'run': '3', 'n': '7000', 'span_s': '1750', 'needed_s': '650',
        'start_ns': str(_NOW_NS - 1750 * _S), 'next_look_ns': str(_NOW_NS + 650 * _S),
        **figures})], _CAME_S)
    run = {'start_ns': str(_NOW_NS - 9000 * _S), 'end_ns': str(_NOW_NS - 1800 * _S), 'n': '28800',
           'mean_deg': '0.21', 'std_deg': '0.13', 'outcome': 'compliant', 'validity': 'holds'}
    bridge.take_verdict(_NOW_NS, [
        Status('verdict', OK, 'COMPLIANT for errors within 30 s',
               {'outcome': 'compliant', 'validity': 'holds', 'runs': '1'}),
        Status('run 1', OK, 'variance within the limit', run)], _CAME_S)
    return bridge


def _four() -> Bridge:
    """Return four sensors of which gyro2 has drifted away in the last ten minutes."""
    means_deg = {'gyro1': 0.2, 'gyro2': 0.3, 'ins': 0.05}
    bridge = Bridge(Settings(sensors='gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; '
                             'ins sigma_max_deg=0.1; gnss sigma_max_deg=0.1 rs'),
                    limits_deg={'gyro1': 0.6, 'gyro2': 0.6, 'ins': 0.3})
    headings_deg = {'gyro1': 45.1, 'gyro2': 48.2, 'ins': 45.0, 'gnss': 44.9}
    figures = [Status(name, OK, '', {
        'heading_deg': str(heading_deg), 'last_deg': str(heading_deg), 'age_s': '0.1',
        'rate_hz': '10', 'stale': 'false'}) for name, heading_deg in headings_deg.items()]
    figures += [Status(f'{name} - gnss', OK, '', {
        'mean_deg': str(means_deg[name]), 'std_deg': str(std_deg),
        'share': str(std_deg / norm_deg)})
        for name, std_deg, norm_deg in (('gyro1', 0.1, 0.32), ('gyro2', 1.0, 0.32),
                                        ('ins', 0.05, 0.14))]
    bridge.take_sensors('figures', _NOW_NS, figures, _CAME_S)
    bridge.take_sensors('vote', _NOW_NS, [Status(
        'now', ERROR, 'gyro2 differs from gyro1, ins and gnss', {'wrong': 'gyro2'})], _CAME_S)
    noise = np.random.default_rng(2)
    for name, mean_deg in means_deg.items():
        x_deg = mean_deg + 0.1 * noise.standard_normal(_PAIRS)
        if name == 'gyro2':
            x_deg[-2500:] += np.linspace(0.0, 3.0, 2500)
        bridge.take_pairs(Pairs.of(_stamps(_PAIRS, _STEP_NS), 45.0 + x_deg,
                                   np.full(_PAIRS, 45.0)), _CAME_S, name)
    bridge.take_health([Status('compliance: node', OK, 'running', {}, '/compliance 1')], _CAME_S)
    bridge.take_alarms([_alarm('compliance: gyro2_wrong')], _CAME_S)
    return bridge


def make_cases() -> dict[str, Bridge]:
    """Return a bridge for each picture, by its name."""
    return {
        'sound': _two([]),
        'frozen': _two([_alarm('compliance: ts_frozen'), _alarm('compliance: jump', size_deg=3.1)],
                       3.1),
        'silent': _two([_alarm('compliance: ts_driver_silent'),
                        _alarm('synchronizer: ts_silent')], silent_s=12.0),
        'turned': _two([_alarm('compliance: rotated'), _alarm('compliance: jump', size_deg=90.1)],
                       90.0),
        'clock': _two([_alarm('synchronizer: clock_step', step_s=3600.0)], silent_s=9.0),
        'disk': _two([_alarm('compliance: not_recorded', 'caution')]),
        'stopped': _two([_alarm('compliance: recorder_silent', 'caution'),
                         _alarm('compliance: not_recorded', 'caution')]),
        'four': _four(),
    }
