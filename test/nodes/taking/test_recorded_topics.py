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

"""Texts that the recorder keeps as files."""

from __future__ import annotations

import pytest
from rclpy.node import Node

from heading_intercompare.bags.recording.part_states import PartStates
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import HeadingTypes, Taking
from heading_intercompare.nodes.taking.recorded_topics import make_intakes, report_files
from heading_intercompare.report.json import render


def test_the_run_table_of_a_report_cuts_the_same_runs(verdict_of_two_runs):
    text = render(verdict_of_two_runs)
    (_, _, report), (name, _, table) = report_files(text)
    assert report == text.encode() and name == 'runs.csv'
    assert table.decode().splitlines() == [
        'start,stop',
        f'{10 ** 18 + 10 ** 9},{10 ** 18 + 200 * 10 ** 9 + 1}',
        f'{10 ** 18 + 400 * 10 ** 9},{10 ** 18 + 600 * 10 ** 9 + 1}']


@pytest.mark.parametrize('rows, judged', [
    (None, ['compliance/verdict']),
    ('gyro1\ngyro2\ngnss rs', ['gyro1/compliance/verdict', 'gyro2/compliance/verdict',
                               'sensors/verdict']),
    ('gyro1\ngyro2\ngnss', ['sensors/verdict']),
], ids=['two sensors', 'a reference', 'no reference'])
def test_the_recorder_waits_for_the_verdicts_of_the_judged_sensors_alone(ros, rows, judged):
    node = ros.add(Node, 'recording')
    settings = Settings.of(sensors=rows, sigma_max_deg=0.2, sigma_ref_max_deg=0.1)
    topics = make_intakes(node, settings, Taking(), HeadingTypes(), Health(node),
                          PartStates(10.0))
    assert [topic for topic in topics if topic.endswith('/verdict')] == judged
