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

"""Several sensors from bags, logs and arrays: one verdict, the same from each."""

from __future__ import annotations

from dataclasses import replace
import shutil

import pytest
from ship_of_sensors import make_sensor, make_three, START_NS, TABLE, write_bag, write_log

from heading_intercompare import (
    analyze,
    analyze_bag,
    analyze_sensors,
    BagReader,
    Headings,
    judge_bags,
    judge_logs,
)
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.pair_settings import settings_of_pair
from heading_intercompare.core.sensors.sensors_verdict import find_sensor_differences
from heading_intercompare.core.settings import Settings

SETTINGS = Settings.of(sensors=TABLE, slowest_error_s=60.0)
HEADINGS = make_three()
GYRO1, GYRO2, GNSS = read_sensors(TABLE)


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    return str(write_bag(tmp_path_factory.mktemp('bag') / 'trial', HEADINGS))


def test_bag_logs_and_arrays_give_one_verdict(bag, tmp_path):
    from_bag = judge_bags([bag], SETTINGS).verdict
    # In the bag headings are quaternions, so their last bits differ.
    topics = {one.heading_topic: 'enu' for one in read_sensors(TABLE)}
    chunks = list(BagReader(bag).headings(topics))
    from_arrays = analyze_sensors(
        {one.name: Headings.concatenate(chunk[one.heading_topic] for chunk in chunks)
         for one in read_sensors(TABLE)}, SETTINGS)
    assert list(find_sensor_differences(from_bag, from_arrays)) == []
    other = analyze_sensors(make_three(3), SETTINGS)
    assert len(list(find_sensor_differences(from_bag, other))) > 100
    logs = {name: str(write_log(tmp_path / f'{name}.log', readings, 'HE'))
            for name, readings in HEADINGS.items()}
    judged = judge_logs(logs, SETTINGS)
    # A log rounds to milliseconds and thousandths of a degree.
    for one, other in zip(judged.verdict.pairs, from_bag.pairs):
        assert one.std_deg == pytest.approx(other.std_deg, rel=1e-3)
    assert [given.path for given in judged.verdict.inputs] == [*logs.values()]
    assert len(judged.notes) == 3 and judged.notes[0].startswith('gyro1: ')


def test_the_verdict_on_a_tested_sensor_is_that_of_the_two_alone(bag):
    verdict = judge_bags([bag], SETTINGS).verdict
    alone = analyze_bag(bag, settings_of_pair(SETTINGS, GYRO2, GNSS))
    assert verdict.verdicts['gyro2'].to_dict() == alone.to_dict()


def test_two_bags_are_runs_of_one_verdict(bag, tmp_path):
    later = {name: replace(readings, stamp_ns=readings.stamp_ns + 10 ** 13)
             for name, readings in make_three(1).items()}
    write_bag(tmp_path / 'second', later, START_NS + 10 ** 13)
    judged = judge_bags([bag, str(tmp_path / 'second')], SETTINGS)
    assert {pair.runs for pair in judged.verdict.pairs} == {2}
    assert all(len(one.runs) == 2 for one in judged.verdict.verdicts.values())


def test_an_input_that_cannot_be_read_leaves_no_sensor_compliant(bag, tmp_path):
    judged = judge_bags([bag, str(tmp_path / 'none')], SETTINGS)
    assert judged.verdict.outcome is Outcome.INDETERMINATE
    assert any('none: not judged' in note for note in judged.notes)
    with pytest.raises(ValueError, match='none of the 2 inputs can be read'):
        judge_bags([str(tmp_path / 'none'), str(tmp_path / 'nil')], SETTINGS)
    with pytest.raises(OSError):
        judge_bags([str(tmp_path / 'none')], SETTINGS)


def test_an_input_that_cannot_be_read_certifies_nothing_without_a_reference(bag, tmp_path):
    free = Settings.of(sensors=TABLE.replace(' rs', ''), slowest_error_s=60.0)
    alone = judge_bags([bag], free).verdict
    assert Outcome.COMPLIANT in {one.outcome for one in alone.sensors}
    judged = judge_bags([bag, str(tmp_path / 'none')], free).verdict
    assert Outcome.COMPLIANT not in {one.outcome for one in judged.sensors}


def test_a_bag_given_twice_counts_once(bag, tmp_path):
    """Twice the same runs would look like more evidence than there is."""
    shutil.copytree(bag, tmp_path / 'copy')
    again = str(tmp_path / 'copy')
    judged = judge_bags([bag, again], SETTINGS)
    assert {pair.runs for pair in judged.verdict.pairs} == {1}
    assert judged.verdict.inputs[1].same_as == bag
    assert judged.notes == (f'{again}: not judged again: it has the data of {bag}',)
    assert judged.verdict.outcome is judge_bags([bag], SETTINGS).verdict.outcome


def test_a_topic_that_is_missing_is_named(bag):
    settings = Settings.of(sensors=f'{TABLE}\nins sigma_max_deg=0.1')
    with pytest.raises(ValueError, match='ins/heading.*has'):
        judge_bags([bag], settings)


def test_runs_of_a_table(bag):
    table = [(START_NS, START_NS + 600 * 10 ** 9, ''),
             (START_NS + 700 * 10 ** 9, START_NS + 1400 * 10 ** 9, '')]
    judged = judge_bags([bag], SETTINGS, runs=table)
    assert {pair.runs for pair in judged.verdict.pairs} == {2}
    judged = judge_bags([bag], SETTINGS, runs=[(0, 1, '')])
    assert any('no run' in note for note in judged.notes)
    assert judged.verdict.outcome is Outcome.INDETERMINATE


def test_a_skew_is_removed_from_every_pair_on_request():
    headings = {**HEADINGS, 'gyro1': make_sensor(0, 0.1, age_s=1.0)}
    as_paired = analyze_sensors(headings, SETTINGS)
    aligned = analyze_sensors(headings, Settings.of(
        sensors=TABLE, slowest_error_s=60.0, alignment={'skew': 'apply'}))
    assert as_paired.vote.wrong == ('gyro1',) and aligned.vote.wrong == ()
    for other in ('gyro2', 'gnss'):
        assert aligned.find_pair('gyro1', other)[0].std_deg < 0.3 < (
            as_paired.find_pair('gyro1', other)[0].std_deg)


def test_a_sensor_without_readings_in_a_program_is_named():
    with pytest.raises(ValueError, match='has no gnss'):
        analyze_sensors({'gyro1': HEADINGS['gyro1'], 'gyro2': HEADINGS['gyro2']}, SETTINGS)


def test_verdicts_of_arrays_draw_their_figures():
    pytest.importorskip('matplotlib')
    verdict = analyze_sensors(HEADINGS, SETTINGS)
    assert verdict.verdicts['gyro1'].plot('histogram') is not None
    assert verdict.verdicts['gyro1'].outcome is analyze(
        HEADINGS['gyro1'], HEADINGS['gnss'], settings_of_pair(SETTINGS, GYRO1, GNSS)).outcome
