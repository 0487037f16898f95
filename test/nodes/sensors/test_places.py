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

"""Where the nodes of each sensor are."""

from __future__ import annotations

from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.sensors.places import (
    choose_streams,
    count_judges,
    count_subscribers,
    further_subscribers,
    heading_topics,
    place_files,
    remap_rules,
)
from heading_intercompare.nodes.settings import ComplianceNode

ROWS = 'a; b topic=/bridge/b; c convention=ned; d topic=gnss/imu rs'
SEVERAL = Settings(sensors=ROWS)
FREE = Settings(sensors=ROWS.removesuffix(' rs'))


def test_the_streams_of_a_sensor_are_its_own_and_those_of_the_reference():
    found = choose_streams(SEVERAL, 'c')
    assert (found.ts_topic, found.rs_topic) == ('c/heading', 'gnss/imu')
    assert (found.ts_convention, found.rs_convention) == ('ned', 'enu')
    assert choose_streams(SEVERAL, None) is SEVERAL


def test_the_nodes_of_a_sensor_find_shared_topics_above_their_namespace():
    rules = remap_rules(read_sensors(ROWS), '/ship1')
    assert rules['rostopic://gnss/imu'] == '/ship1/gnss/imu'
    assert rules['rostopic://compliance/marker'] == '/ship1/compliance/marker'
    assert not [name for name in rules if 'bridge' in name], 'an absolute name stays as it is'
    assert remap_rules(read_sensors(ROWS), '/')['rostopic://a/heading'] == '/a/heading'


def test_the_files_of_a_sensor_have_its_name():
    own = ComplianceNode(sensor='a', report_dir='reports', journal='x/trial.journal', ship='MV')
    found = place_files(own)
    assert (found.report_dir, found.journal, found.ship) == (
        'reports/a', 'x/trial.a.journal', 'MV/a')
    assert place_files(ComplianceNode(sensor='a', journal='-')) == ComplianceNode(
        sensor='a', journal='-', ship='a')
    plain = ComplianceNode(report_dir='reports')
    assert place_files(plain) is plain


def test_every_reading_waits_for_all_that_hear_it():
    """Three tested sensors: the reference also has two synchronizers more."""
    sensors, free = read_sensors(ROWS), read_sensors(FREE.sensors)
    assert (count_subscribers(sensors, True), count_subscribers(sensors, False)) == (3, 2)
    assert further_subscribers(SEVERAL) == {'gnss/imu': 2}
    assert (count_subscribers(free, True), further_subscribers(FREE)) == (2, {})
    assert (count_subscribers((), True), further_subscribers(Settings())) == (2, {})


def test_marks_wait_for_all_that_judge():
    assert [count_judges(one) for one in (SEVERAL, FREE, Settings())] == [7, 1, 2]


def test_the_topics_are_those_of_all_sensors_or_of_two():
    assert heading_topics(SEVERAL) == ['a/heading', '/bridge/b', 'c/heading', 'gnss/imu']
    assert heading_topics(Settings()) == ['ts/heading', 'rs/heading']
