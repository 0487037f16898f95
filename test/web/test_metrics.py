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

"""The figures in the text form of Prometheus: form, labels, what is missing, and the address."""

from __future__ import annotations

from importlib.util import find_spec
import re
import subprocess
import sys

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.web.bridge.bridge_records import (
    AlarmView,
    BagView,
    NodeView,
    RunView,
    WindowView,
)
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.sensors_panel import SensorRow, SensorsView
from heading_intercompare.web.figures.stream_watch import SensorView
from heading_intercompare.web.metrics import DoorCounts, metrics_text

LINE = re.compile(r'heading_intercompare_([a-z_]+)'
                  r'(?:\{((?:[a-z]+="(?:[^"\\\n]|\\[\\"n])*",?)+)\})? '
                  r'(-?[0-9.]+(?:e[+-]?[0-9]+)?|[+-]Inf)')


def parse(text):
    """Return the values by name and labels; fail if a line has not the form."""
    assert text.endswith('\n') and not text.endswith('\n\n')
    values, typed = {}, set()
    for line in text.splitlines():
        if line.startswith('#'):
            _, what, name, words = line.split(' ', 3)
            assert what in ('HELP', 'TYPE') and words
            if what == 'TYPE':
                assert words in ('gauge', 'counter') and name not in typed
                typed.add(name)
            continue
        name, labels, value = LINE.fullmatch(line).groups()
        assert f'heading_intercompare_{name}' in typed, 'the type comes first'
        key = (name, labels) if labels else name
        assert key not in values
        values[key] = float(value)
    return values


def test_the_figures_of_two_sensors():
    values = parse(metrics_text(BridgeView(
        ts=SensorView(heading_deg=1.0, age_s=0.1, rate_hz=10.0, offset_s=-0.02, stale=False),
        rs=SensorView(age_s=9.0, rate_hz=10.0, stale=True),
        difference_deg=0.25, difference_age_s=0.2, paired_share=0.97, paired=1_234_567,
        rejected=3, window=WindowView(n=600, mean_deg=0.1, std_deg=0.2, limit_deg=0.3, nu=57.5,
                                      age_s=0.1, stale=False),
        run=RunView(number=1, n=900, span_s=90.0, needed_s=float('inf'), age_s=0.5, stale=False),
        bag=BagView(free_bytes=5 * 10 ** 12, stale=False), graph_age_s=0.1, judged=True), 0.05))
    assert values['reading_rate_hertz', 'sensor="ts"'] == 10.0
    # A sensor that is silent has no rate but 0, and its age grows.
    assert values['reading_rate_hertz', 'sensor="rs"'] == 0.0
    assert values['reading_age_seconds', 'sensor="rs"'] == 9.0
    assert ('stamp_offset_seconds', 'sensor="rs"') not in values
    assert [values[name] for name in (
        'paired_share', 'pairs_total', 'readings_rejected_total', 'window_sd_degrees',
        'window_nu', 'disk_free_bytes', 'judged', 'view_age_seconds')] == [
        0.97, 1_234_567, 3, 0.2, 57.5, 5e12, 1, 0.05]
    assert values['run_needed_seconds'] == float('inf')


def test_what_is_not_known_or_stale_has_no_line():
    values = parse(metrics_text(BridgeView(window=WindowView(n=5, std_deg=0.2, stale=True)), 0.0))
    assert {name for name in values if isinstance(name, str)} == {'view_age_seconds', 'judged'}
    assert not any(name[0] in ('reading_age_seconds', 'window_sd_degrees') for name in values)


def test_alarms_are_counted_also_where_there_are_none():
    """An alert on a figure that is missing would never fire."""
    def text(*alarms):
        return parse(metrics_text(BridgeView(alarms=alarms), 0.0))
    kind = 'priority="warning",state="active_unacknowledged"'
    assert text()['alarms', kind] == 0
    raised = AlarmView('compliance: jump', 'warning', 'active_unacknowledged', 'words', 5)
    gone = AlarmView('ts_driver: burst', 'caution', 'rectified_unacknowledged', 'words', 5)
    values = text(raised, gone)
    assert values['alarms', kind] == 1
    assert values['alarm_active', 'alarm="compliance: jump",priority="warning"'] == 1
    assert values['alarm_active', 'alarm="ts_driver: burst",priority="caution"'] == 0


def test_foreign_words_cannot_break_the_form():
    name = 'a"b\\c\nd 1\n# TYPE x gauge'
    values = parse(metrics_text(BridgeView(
        alarms=(AlarmView(name, 'x"', 'y\n', '', None),),
        nodes=(NodeView(name, 2, '', 1.0, False),)), 0.0))
    escaped = r'a\"b\\c\nd 1\n# TYPE x gauge'
    assert values['node_level', f'node="{escaped}"'] == 2
    assert values['alarms', r'priority="x\"",state="y\n"'] == 1


def test_the_figures_of_several_sensors_name_the_other_one():
    values = parse(metrics_text(BridgeView(sensors=SensorsView(rows=(
        SensorRow('gyro1', now=SensorView(age_s=0.1, rate_hz=5.0, stale=False), against='gnss',
                  mean_deg=0.3, std_deg=0.4),))), 0.0))
    assert values['reading_rate_hertz', 'sensor="gyro1"'] == 5.0
    assert values['window_sd_degrees', 'sensor="gyro1",against="gnss"'] == 0.4
    assert ('reading_age_seconds', 'sensor="ts"') not in values


CODE = """
import urllib.request
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer
server = PageServer(Controls(lambda: (BridgeView(paired_share=0.5), 0.25), None), port=0)
answer = urllib.request.urlopen(server.url + 'metrics', timeout=120)
print(answer.headers['content-type'])
print(answer.read().decode(), end='')
server.close()
"""


@pytest.mark.process
@pytest.mark.skipif(find_spec('nicegui') is None, reason='NiceGUI is not installed')
def test_the_server_of_the_page_has_them_at_an_address_of_their_own():
    done = subprocess.run([sys.executable, '-c', CODE], capture_output=True, text=True,
                          timeout=DEADLINE_S, check=False)
    assert done.returncode == 0, done.stderr
    kind, _, text = done.stdout.partition('\n')
    assert kind == 'text/plain; version=0.0.4; charset=utf-8'
    assert parse(text)['paired_share'] == 0.5 and parse(text)['view_age_seconds'] == 0.25


def test_the_connections_to_the_page_are_counted():
    values = parse(metrics_text(BridgeView(), 0.0, DoorCounts(3, refused=2, ended=1)))
    assert values['page_connections'] == 3.0
    assert values['page_connections_refused_total'] == 2.0
    assert values['page_connections_ended_total'] == 1.0
