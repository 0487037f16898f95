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

"""All pairs of sensors: each is what a comparison of the two alone gives."""

from __future__ import annotations

import numpy as np
import pytest
from ship_of_sensors import make_sensor

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_settings import settings_of_pair
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences

TABLE = 'gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; ins sigma_max_deg=0.1'
WITH = f'{TABLE}; gnss sigma_max_deg=0.1 rs'
HEADINGS = {'gyro1': make_sensor(1, 0.15), 'gyro2': make_sensor(2, 0.2, phase_s=0.07),
            'ins': make_sensor(3, 0.05, rate_hz=20.0), 'gnss': make_sensor(4, 0.05, rate_hz=1.0)}


def compare(table, cuts=1):
    comparison = SensorsComparison(Settings.of(sensors=table))
    names = [one.name for one in comparison.sensors]
    for part in range(cuts):
        comparison.update({name: HEADINGS[name][len(HEADINGS[name]) * part // cuts:
                                                len(HEADINGS[name]) * (part + 1) // cuts]
                           for name in names})
    comparison.finish()
    return comparison


def test_a_tested_sensor_has_the_verdict_of_the_two_alone():
    comparison = compare(WITH)
    assert [*comparison.tested] == ['gyro1', 'gyro2', 'ins']
    assert [*comparison.others] == [('gyro1', 'gyro2'), ('gyro1', 'ins'), ('gyro2', 'ins')]
    *free, reference = read_sensors(WITH)
    for sensor in free:
        alone = Intercomparison(settings_of_pair(Settings.of(sensors=WITH), sensor, reference))
        alone.update(HEADINGS[sensor.name], HEADINGS['gnss'])
        alone.finish()
        assert comparison.tested[sensor.name].verdict().to_dict() == alone.verdict().to_dict()


def test_the_other_pairs_have_every_reading_in_their_ledger_and_two_a_second_in_their_runs():
    other = compare(WITH).others['gyro1', 'ins']
    run, = other.results()
    assert run.verdict.pairing.ts_received == len(HEADINGS['gyro1'])
    assert run.verdict.pairing.rs_received == len(HEADINGS['ins'])
    assert run.verdict.n == pytest.approx(2 * 1800, abs=2)


def test_without_a_reference_all_pairs_are_others():
    comparison = compare(TABLE)
    assert comparison.tested == {} and len(comparison.others) == 3


@pytest.mark.parametrize('table', [WITH, TABLE])
def test_the_cuts_of_the_streams_change_nothing(table):
    whole, cut = compare(table), compare(table, 37)
    for one, other in ((whole.tested, cut.tested), (whole.others, cut.others)):
        for key in one:
            assert list(find_differences(one[key].verdict(),
                                         other[key].verdict())) == []


def test_losses_of_a_sensor_count_in_each_of_its_pairs():
    comparison = SensorsComparison(Settings.of(sensors=WITH))
    comparison.update(HEADINGS)
    stamp_ns = int(HEADINGS['gnss'].stamp_ns[100])
    for name in ('ins', 'gnss'):
        comparison.lose(name, LedgerKey.TS_LOST_ON_THE_WAY, Losses.of([stamp_ns], [0], [7]))
    comparison.finish()

    def lost(one):
        counts = one.ledger.total.counts
        return [counts.get(key, 0) for key in (LedgerKey.TS_LOST_ON_THE_WAY,
                                               LedgerKey.RS_LOST_ON_THE_WAY)]
    assert {name: lost(one) for name, one in comparison.tested.items()} == {
        'gyro1': [0, 7], 'gyro2': [0, 7], 'ins': [7, 7]}
    assert {names: lost(one) for names, one in comparison.others.items()} == {
        ('gyro1', 'gyro2'): [0, 0], ('gyro1', 'ins'): [0, 7], ('gyro2', 'ins'): [0, 7]}


def test_marks_start_and_stop_the_runs_of_every_pair():
    comparison = SensorsComparison(Settings.of(sensors=WITH))
    start_ns, stop_ns = (int(HEADINGS['gnss'].stamp_ns[at]) for at in (300, 1500))
    comparison.mark('start', start_ns)
    comparison.mark('stop', stop_ns)
    comparison.update(HEADINGS)
    comparison.finish()
    assert comparison.newest_ns == max(int(one.stamp_ns[-1]) for one in HEADINGS.values())
    for one in (*comparison.tested.values(), *comparison.others.values()):
        run, = one.results()
        assert start_ns <= run.verdict.start_ns and run.verdict.end_ns <= stop_ns


def test_a_sensor_without_readings_leaves_the_others_as_they_are():
    comparison = SensorsComparison(Settings.of(sensors=WITH))
    comparison.update({**HEADINGS, 'gyro2': Headings.of(np.empty(0, np.int64), [])})
    comparison.finish()
    assert comparison.tested['gyro2'].results() == []
    assert comparison.tested['gyro1'].verdict().to_dict() == (
        compare(WITH).tested['gyro1'].verdict().to_dict())


def test_the_pairs_go_on_after_a_restart():
    comparison = SensorsComparison(Settings.of(sensors=WITH))
    halves = [{name: headings[:len(headings) // 2] for name, headings in HEADINGS.items()},
              {name: headings[len(headings) // 2:] for name, headings in HEADINGS.items()}]
    comparison.update(halves[0])
    last = comparison.begin_again()
    assert {*last} == {'gyro1', 'gyro2', 'ins'}
    comparison.update(halves[1])
    comparison.finish()
    for one in (*comparison.tested.values(), *comparison.others.values()):
        assert len(one.results()) == 1
