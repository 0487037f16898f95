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

"""The alarms of a graph as what sends them to the bridge takes them."""

from __future__ import annotations

from typing import Iterable, Mapping

from heading_intercompare.core.alarms.alarm import AlarmState, Priority
from heading_intercompare.drivers.alerts.alert_list import ReportedAlert
from heading_intercompare.messages.status_messages import Status

_TIMES = ('raised_ns', 'acknowledged_ns', 'cleared_ns')


def read_reports(statuses: Iterable[Status]) -> dict[str, list[ReportedAlert]]:
    """
    Return the alarms in a message of `compliance/alarms` by node; what is no alarm is left out.

    Parameters
    ----------
    statuses
        As `AlarmPanel` publishes them: all of one node.

    """
    reports: dict[str, list[ReportedAlert]] = {}
    for status in statuses:
        node, colon, name = status.name.rpartition(': ')
        if status.owner and not status.owner.partition(' ')[0].endswith(f'/{node}'):
            continue
        try:
            state = AlarmState(status.values['state'])
            priority = Priority(status.values['priority'])
        except (KeyError, ValueError):
            continue
        if colon and name:
            times = _read_times(status.values)
            reports.setdefault(node, []).append(ReportedAlert(
                node, name, state, priority, status.message, times.get('raised_ns'),
                max(times.values(), default=None)))
    return reports


def _read_times(values: Mapping[str, str]) -> dict[str, int]:
    """Return the times of an alarm that are there."""
    return {name: int(values[name]) for name in _TIMES
            if values.get(name, '').isascii() and values.get(name, '').isdigit()}
