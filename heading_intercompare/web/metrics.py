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
What the live page shows, as figures in the text form of Prometheus.

https://prometheus.io/docs/instrumenting/exposition_formats/ describes the form. A figure that is
missing or stale has no line, so that nobody takes an old figure for a new one; ages always have.
"""

from __future__ import annotations

from collections import Counter
from typing import Iterator, Mapping, NamedTuple

from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.sensors_panel import SensorRow
from heading_intercompare.web.figures.stream_watch import SensorView

CONTENT_TYPE = 'text/plain; version=0.0.4; charset=utf-8'

_PREFIX = 'heading_intercompare_'
_STATES = ('active_unacknowledged', 'active_acknowledged', 'rectified_unacknowledged')
_PRIORITIES = ('warning', 'caution')
_ESCAPES = str.maketrans({'\\': r'\\', '"': r'\"', '\n': r'\n'})


class _Sample(NamedTuple):
    """A figure with its labels."""

    name: str
    value: float | None
    labels: Mapping[str, str] = {}


#: Kind and meaning of each figure, in the order of the text.
_FIGURES = {
    'view_age_seconds': ('gauge', 'Age of all these figures.'),
    'graph_age_seconds': ('gauge', 'Time since anything came from the graph.'),
    'judged': ('gauge', '1 while the node that judges is heard.'),
    'reading_rate_hertz': ('gauge', 'Readings per second of a sensor lately.'),
    'reading_age_seconds': ('gauge', 'Time since the last reading of a sensor.'),
    'stamp_offset_seconds': ('gauge', 'Stamp of the last reading minus the time of its receipt.'),
    'difference_degrees': ('gauge', 'TS - RS of the newest pair.'),
    'difference_age_seconds': ('gauge', 'Time since the last pair.'),
    'paired_share': ('gauge', 'Share of the readings that were paired in the last minute.'),
    'pairs_total': ('counter', 'Pairs made, by the newest ledger.'),
    'readings_rejected_total': ('counter', 'Readings rejected, by the newest ledger.'),
    'window_differences': ('gauge', 'Differences in the rolling window.'),
    'window_mean_degrees': ('gauge', 'Mean of the differences in the rolling window.'),
    'window_sd_degrees': ('gauge', 'Standard deviation of the differences in the rolling window.'),
    'window_sd_limit_degrees': ('gauge', 'Norm for the standard deviation of the differences.'),
    'window_nu': ('gauge', 'Effective degrees of freedom of the rolling window.'),
    'run_differences': ('gauge', 'Differences analysed in the run in progress.'),
    'run_span_seconds': ('gauge', 'Time from the first to the last difference of the run.'),
    'run_needed_seconds': ('gauge', 'How much longer the run must be to decide.'),
    'disk_free_bytes': ('gauge', 'Free space on the disk of the bag.'),
    'alarms': ('gauge', 'Alarms that are not normal.'),
    'alarm_active': ('gauge', '1 while the condition of an alarm holds, 0 while it is not '
                     'acknowledged.'),
    'node_level': ('gauge', 'State of a node: 0 OK, 1 warning, 2 error.'),
    'node_age_seconds': ('gauge', 'Time since a node was heard.'),
    'page_connections': ('gauge', 'Connections to the page.'),
    'page_connections_refused_total': ('counter', 'Connections to the page that were refused.'),
    'page_connections_ended_total': ('counter', 'Connections to the page that were ended, since '
                                     'they waited too long or others needed the room.')}


class DoorCounts(NamedTuple):
    """Connections to the page: open now, refused, and ended because they waited."""

    open: int = 0
    refused: int = 0
    ended: int = 0


def metrics_text(view: BridgeView, age_s: float, door: DoorCounts | None = None) -> str:
    """
    Return the figures of a view, given its age in seconds, and of the connections to the page.

    Examples
    --------
    >>> print(metrics_text(BridgeView(), 0.5).splitlines()[2])
    heading_intercompare_view_age_seconds 0.5

    """
    samples = [_Sample('view_age_seconds', age_s),
               _Sample('graph_age_seconds', view.graph_age_s), _Sample('judged', view.judged),
               *(_list_pair(view) if view.sensors is None else _list_rows(view.sensors.rows)),
               _Sample('disk_free_bytes', None if view.bag.stale else view.bag.free_bytes),
               *_list_alarms(view)]
    if door is not None:
        samples += [_Sample('page_connections', door.open),
                    _Sample('page_connections_refused_total', door.refused),
                    _Sample('page_connections_ended_total', door.ended)]
    for node in view.nodes:
        labels = {'node': node.name}
        samples += [_Sample('node_level', None if node.stale else node.level, labels),
                    _Sample('node_age_seconds', node.age_s, labels)]
    lines = []
    for name, (kind, words) in _FIGURES.items():
        rows = [_write(sample) for sample in samples
                if sample.name == name and sample.value is not None]
        if rows:
            lines += [f'# HELP {_PREFIX}{name} {words}', f'# TYPE {_PREFIX}{name} {kind}', *rows]
    return '\n'.join([*lines, ''])


def _write(sample: _Sample) -> str:
    """Return the line of a figure."""
    labels = ','.join(f'{name}="{text.translate(_ESCAPES)}"'
                      for name, text in sample.labels.items())
    value = float(sample.value or 0.0)
    text = {float('inf'): '+Inf', float('-inf'): '-Inf'}.get(value, repr(value))
    return f'{_PREFIX}{sample.name}{f"{{{labels}}}" if labels else ""} {text}'


def _list_sensor(name: str, sensor: SensorView) -> Iterator[_Sample]:
    """Yield what a sensor reports."""
    labels = {'sensor': name}
    yield _Sample('reading_rate_hertz', 0.0 if sensor.stale else sensor.rate_hz, labels)
    yield _Sample('reading_age_seconds', sensor.age_s, labels)
    yield _Sample('stamp_offset_seconds', None if sensor.stale else sensor.offset_s, labels)


def _list_pair(view: BridgeView) -> Iterator[_Sample]:
    """Yield the figures of two sensors."""
    yield from _list_sensor('ts', view.ts)
    yield from _list_sensor('rs', view.rs)
    yield _Sample('difference_degrees', view.difference_deg)
    yield _Sample('difference_age_seconds', view.difference_age_s)
    yield _Sample('paired_share', view.paired_share)
    yield _Sample('pairs_total', view.paired)
    yield _Sample('readings_rejected_total', view.rejected)
    window, run = view.window, view.run
    if not window.stale:
        yield _Sample('window_differences', window.n)
        yield _Sample('window_mean_degrees', window.mean_deg)
        yield _Sample('window_sd_degrees', window.std_deg)
        yield _Sample('window_sd_limit_degrees', window.limit_deg)
        yield _Sample('window_nu', window.nu)
    if not run.stale:
        yield _Sample('run_differences', run.n)
        yield _Sample('run_span_seconds', run.span_s)
        yield _Sample('run_needed_seconds', run.needed_s)


def _list_rows(rows: tuple[SensorRow, ...]) -> Iterator[_Sample]:
    """Yield the figures of several sensors."""
    for row in rows:
        yield from _list_sensor(row.name, row.now)
        labels = {'sensor': row.name, 'against': row.against}
        yield _Sample('window_mean_degrees', row.mean_deg, labels)
        yield _Sample('window_sd_degrees', row.std_deg, labels)


def _list_alarms(view: BridgeView) -> Iterator[_Sample]:
    """Yield how many alarms there are of each kind, also none, and which."""
    counts = Counter((alarm.priority, alarm.state) for alarm in view.alarms)
    for kind in [*((priority, state) for priority in _PRIORITIES for state in _STATES),
                 *(kind for kind in counts
                   if kind[0] not in _PRIORITIES or kind[1] not in _STATES)]:
        yield _Sample('alarms', counts[kind], {'priority': kind[0], 'state': kind[1]})
    for alarm in view.alarms:
        yield _Sample('alarm_active', alarm.active, {'alarm': alarm.name,
                                                     'priority': alarm.priority})
