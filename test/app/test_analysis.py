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

"""Recorded runs judged from Python: the verdicts of the command line, its notes as warnings."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import warnings

from command_line import analyze_json
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import analyze_bag, analyze_bags, Headings, judge_bags, Norms, Settings
from heading_intercompare.bags.csv.pairs_csv import write_pairs_csv
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.core.records import Pairs
from heading_intercompare.messages.heading_messages import encode_imu, IMU

S = 1_000_000_000
SETTINGS = Settings(norms=Norms(sigma_max_deg=0.3, sigma_ref_max_deg=0.1))


def start_ns(number: int) -> int:
    """Return the first stamp of a bag."""
    return (1_400_000_000 + 1000 * number) * S


@pytest.fixture
def bags(tmp_path):
    """Return two bags of two minutes at 10 Hz, TS 0.1° sd, RS exact."""
    for number in range(2):
        rng = np.random.default_rng(number)
        stamps = start_ns(number) + np.arange(1200) * (S // 10)
        write_headings(tmp_path / f'trial_{number}', {
            topic: Headings.of(stamps, 100.0 + error * rng.standard_normal(1200))
            for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.0))})
    return [tmp_path / f'trial_{number}' for number in range(2)]


def printed(capsys, *arguments) -> tuple[dict, list[str]]:
    """Return the JSON and the notes of `analyze`."""
    verdict, notes = analyze_json(capsys, *arguments)
    return verdict, [note.removeprefix('note: ') for note in notes]


def test_a_bag_is_judged_as_on_the_command_line(bags, capsys):
    expected, _ = printed(capsys, bags[0])
    assert analyze_bag(bags[0], SETTINGS).to_dict() == expected
    assert analyze_bag(str(bags[0]), SETTINGS).to_dict() == expected
    assert capsys.readouterr() == ('', '')


def test_several_bags_are_judged_as_on_the_command_line_by_whoever(bags, capsys):
    expected, _ = printed(capsys, *bags)
    assert analyze_bags(bags, SETTINGS).to_dict() == expected
    with ThreadPoolExecutor(2) as executor:
        assert analyze_bags(bags, SETTINGS, executor=executor).to_dict() == expected


def test_a_bad_bag_is_a_warning_and_the_verdict_is_not_compliant(bags, tmp_path, capsys):
    (tmp_path / 'bad.mcap').write_bytes(b'no bag')
    expected, notes = printed(capsys, bags[0], tmp_path / 'bad.mcap')
    with pytest.warns(UserWarning) as said:
        verdict = analyze_bags([bags[0], tmp_path / 'bad.mcap'], SETTINGS)
    assert [str(each.message) for each in said] == notes
    assert [each.filename for each in said] == [__file__]
    assert verdict.to_dict() == expected and verdict.outcome.value == 'indeterminate'


def test_runs_are_given_as_a_table_or_as_its_file(bags, tmp_path, capsys):
    table = [(start_ns(0), start_ns(0) + 50 * S, 'trial_0'),
             (start_ns(1), start_ns(1) + 60 * S, 'trial_1')]
    file = tmp_path / 'runs.csv'
    file.write_text('start,stop,source\n' + ''.join(f'{a},{b},{c}\n' for a, b, c in table))
    expected, _ = printed(capsys, *bags, '--runs', file)
    assert [run['n'] for run in expected['runs']] == [500, 600]
    assert analyze_bags(bags, SETTINGS, runs=file).to_dict() == expected
    assert analyze_bags(bags, SETTINGS, runs=table).to_dict() == expected


def test_the_notes_come_back_with_the_graphs(bags):
    told = []
    judged = judge_bags([bags[0]], SETTINGS, sketched=True, progress=told.append,
                        runs=[(start_ns(0), start_ns(0) + 50 * S, ''), (1, 2, 'gone')])
    assert judged.notes == ('runs: source gone is not one of the INPUTs',)
    assert [sketch.n for sketch in judged.sketches['ts']] == [1200]
    assert {'2,400 of 2,400 headings', '91% of run 1 judged'} <= {*told}


@pytest.mark.parametrize('paths, settings, error, words', [
    ([], SETTINGS, ValueError, 'must be a list of at least one path'),
    ('trial_0', SETTINGS, ValueError, "paths = 'trial_0': must be a list"),
    (['a', 'b'], Settings(), ValueError, 'norms.sigma_max_deg'),
    (['nowhere'], SETTINGS, FileNotFoundError, 'nowhere'),
    (['nowhere', 'neither'], SETTINGS, ValueError, 'none of the 2 inputs can be read')])
def test_a_mistake_is_an_error(tmp_path, monkeypatch, paths, settings, error, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(error, match=words):
        analyze_bags(paths, settings)


def test_pairs_are_given_of_one_input_and_refused_of_more(bags):
    taken = []
    judge_bags([bags[0]], SETTINGS, takers={'ts': [taken.append]})
    assert sum(map(len, taken)) == 1200
    with ThreadPoolExecutor(1) as executor, pytest.raises(ValueError, match='takers: '):
        judge_bags([bags[0]], SETTINGS, takers={'ts': [taken.append]}, executor=executor)
    with pytest.raises(ValueError, match='takers: must be empty with several inputs'):
        judge_bags(bags, SETTINGS, takers={'ts': [taken.append]})


def jumpy(fault):
    """Return 24 min of stamps at 10 Hz with a fault."""
    stamps = start_ns(0) + np.arange(14_400) * (S // 10)
    if fault == 'first':
        stamps[0] += 3600 * S
    elif fault == 'first in 2038':
        stamps[0] = (2**31 - 1) * S
    elif fault == 'one':
        stamps[3000] += 3600 * S
    elif fault == 'two in a row':
        stamps[[3000, 3001]] += 3600 * S
    elif fault == 'last':
        stamps[-1] += 3600 * S
    elif fault == 'silence':
        stamps[7200:] += 7200 * S
    elif fault == 'back an hour':
        stamps[13_400:] -= 3600 * S
    elif fault == 'back half a second':
        stamps[7200:] -= S // 2
    return stamps


JUMPS = {'first': {'jump': 1}, 'first in 2038': {'jump': 1}, 'one': {'jump': 1},
         'two in a row': {'jump': 2}, 'last': {'jump': 1}, 'silence': {},
         'back an hour': {}, 'back half a second': {'stamp_not_increasing': 5}}


def check_jumps(verdict, fault, who):
    """Check outcome, counts and words of a verdict on jumpy stamps of a sensor, or of both."""
    n = sum(run.n for run in verdict.runs)
    if fault == 'back an hour':
        # The last 1000 readings; of one sensor alone they have no partner.
        run, *after = verdict.runs
        assert [(later.n, later.clock_segment) for later in after] == [(1000, 1)] * (len(who) == 2)
        assert (run.outcome.value, run.validity_effect) == ('compliant', 'doubtful')
        for sensor in who:
            assert (f'the clock of the {sensor.upper()} was set back by 3600.0 s at 2014-05-13 '
                    '17:15:39.900 UTC') in run.headline
            assert getattr(run.pairing.rejected, sensor) == {}
        assert 13_399 <= run.n <= 13_400
        return
    assert verdict.outcome.value == 'compliant'
    if fault == 'silence':
        assert [run.n for run in verdict.runs] == [7200, 7200]
        return
    (run,) = verdict.runs
    for sensor in who:
        assert getattr(run.pairing.rejected, sensor) == JUMPS[fault]
    assert run.validity_effect == 'holds'
    # An RS is interpolated over its bad readings, but nothing beyond its ends is paired.
    assert 14_400 - sum(JUMPS[fault].values()) - 1 <= n <= 14_400


@pytest.mark.parametrize('fault, who', [
    (fault, who) for fault in JUMPS for who in (('ts', 'rs'), ('ts',), ('rs',))
    if fault != 'silence' or len(who) == 2])
def test_stamps_that_jump_in_a_bag_cost_only_their_readings(tmp_path, rng, fault, who):
    log = start_ns(0) + np.arange(14_400) * (S // 10)
    with BagWriter(tmp_path / 'bag') as writer:
        for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.02)):
            writer.add_topic(topic, IMU)
            stamps = jumpy(fault) if topic[:2] in who else log
            readings = Headings.of(stamps, 100.0 + error * rng.standard_normal(14_400))
            writer.write_rows([Rows(topic, encode_imu(readings, 'x'), log)])
    check_jumps(analyze_bag(tmp_path / 'bag', SETTINGS), fault, who)


@pytest.mark.parametrize('fault', JUMPS)
def test_stamps_that_jump_in_a_csv_cost_only_their_rows(tmp_path, rng, fault):
    stamps = jumpy(fault)
    ts, rs = (100.0 + error * rng.standard_normal(14_400) for error in (0.1, 0.02))
    write_pairs_csv(tmp_path / 'pairs.csv', [Pairs.of(stamps, ts, rs)])
    check_jumps(analyze_bag(tmp_path / 'pairs.csv', SETTINGS), fault, ('ts', 'rs'))


@pytest.mark.parametrize('start_s', [2**31 - 600, 2**31, 2**32 - 600, 2**32, 9_223_370_000])
def test_a_csv_of_any_year_up_to_2262_is_read(tmp_path, rng, start_s):
    stamps = start_s * S + np.arange(14_400) * (S // 10)
    ts, rs = (100.0 + error * rng.standard_normal(14_400) for error in (0.1, 0.02))
    write_pairs_csv(tmp_path / 'pairs.csv', [Pairs.of(stamps, ts, rs)])
    run, = analyze_bag(tmp_path / 'pairs.csv', SETTINGS).runs
    assert run.n == 14_400 and run.pairing.rejected.ts == {}


@pytest.mark.parametrize('late_s', [1440, 720])
def test_stamps_in_a_bag_from_2038_on_are_readings_without_stamp(tmp_path, rng, late_s):
    """The seconds of a ROS message have 32 bits and a sign; after them stamps are negative."""
    log = (2**31 - 1440 + late_s) * S + np.arange(14_400) * (S // 10)
    with BagWriter(tmp_path / 'bag') as writer:
        for topic, error in (('ts/heading', 0.1), ('rs/heading', 0.02)):
            writer.add_topic(topic, IMU)
            rows = encode_imu(Headings.of(
                log - 2**30 * S, 100.0 + error * rng.standard_normal(14_400)), 'x')
            rows[:, 4:8] = (log // S).astype('<u4').view(np.uint8).reshape(-1, 4)
            writer.write_rows([Rows(topic, rows, log)])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter('always')
        verdict = analyze_bag(tmp_path / 'bag', SETTINGS)
    rejected = 10 * late_s
    assert sum(run.n for run in verdict.runs) == 14_400 - rejected
    for run in verdict.runs:
        assert run.pairing.rejected.ts == run.pairing.rejected.rs == {'no_stamp': rejected}
        assert run.validity_effect == 'doubtful'
    if not verdict.runs:
        assert f'rejected: {rejected} RS no_stamp, {rejected} TS no_stamp' in str(said[0].message)
