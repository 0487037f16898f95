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

"""Where each sensor has its topics and files."""

from __future__ import annotations

from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.interface.places import (
    heading_places,
    judging_topics,
    label_tested,
    name_place,
    place_files,
)
from heading_intercompare.nodes.settings import ComplianceNode

ROWS = 'a; b topic=/bridge/b; c convention=ned; d topic=gnss/imu rs'
SEVERAL = Settings(sensors=ROWS)
FREE = Settings(sensors=ROWS.removesuffix(' rs'))


def test_the_topics_of_a_sensor_begin_with_its_name_unless_it_is_the_only_one():
    assert label_tested(SEVERAL) == {(name, 'd'): name for name in 'abc'}
    assert label_tested(Settings()) == {('ts', 'rs'): ''} and label_tested(FREE) == {}
    assert name_place('c') == 'c/' and name_place('') == ''


def test_the_files_of_a_sensor_have_its_name():
    own = ComplianceNode(report_dir='reports', journal='x/trial.journal', ship='MV')
    of_sensor = place_files(own, 'a')
    assert (of_sensor.report_dir, of_sensor.journal, of_sensor.ship) == (
        'reports/a', 'x/trial.a.journal', 'MV/a')
    assert place_files(ComplianceNode(journal='-'), 'a') == ComplianceNode(journal='-', ship='a')
    assert place_files(own, '') is own


def test_the_topics_are_those_of_all_sensors_or_of_two():
    assert [*heading_places(SEVERAL)] == ['a/heading', '/bridge/b', 'c/heading', 'gnss/imu']
    assert [*heading_places(Settings())] == ['ts/heading', 'rs/heading']


def test_who_publishes_pairs_takes_all_headings():
    assert judging_topics(SEVERAL) == dict.fromkeys(
        heading_places(SEVERAL), ['a/pairs', 'b/pairs', 'c/pairs'])
    assert judging_topics(Settings()) == {'ts/heading': ['pairs'], 'rs/heading': ['pairs']}
    assert judging_topics(FREE) == {}
