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

"""The command rejudge: the verdicts stored in bags compared with new ones."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from ship_of_sensors import make_three, TABLE, write_bag

from heading_intercompare import analyze, analyze_sensors, Headings, Settings
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import describe_origin, RECORD, REPORT_TOPIC
from heading_intercompare.cli import main
from heading_intercompare.core.version import RULE_VERSION
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu

S = 1_000_000_000
STAMPS = (np.arange(700) + 1_700_000_000) * S
SETTINGS = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1})
STORED = describe_origin(SETTINGS.to_mapping())


@pytest.fixture(scope='module')
def trial():
    """Return the headings of a good TS and of the RS, and the verdict on them."""
    true = 100.0 + 50.0 * np.sin(np.arange(700) / 40.0)
    ts = Headings.of(STAMPS, true + 0.1 * np.random.default_rng(3).standard_normal(700))
    rs = Headings.of(STAMPS, true)
    return ts, rs, analyze(ts, rs, SETTINGS).to_dict()


@pytest.fixture
def make_bag(trial, tmp_path):
    """Return a function that makes a bag of the trial, given what it stores."""
    ts, rs, verdict = trial

    def make(name='bag', *, stored=STORED, report=True, published=False, **changes):
        path = tmp_path / name
        text = report if isinstance(report, str) else json.dumps({**verdict, **changes})
        with BagWriter(path) as writer:
            if stored:
                writer.metadata(RECORD, stored)
            for topic, readings in (('ts/heading', ts), ('rs/heading', rs)):
                writer.add_topic(topic, 'sensor_msgs/msg/Imu')
                writer.write_rows([Rows(topic, encode_imu(readings, 'x'), STAMPS)])
            if published:
                writer.add_topic(REPORT_TOPIC, 'std_msgs/msg/String')
                writer.write(REPORT_TOPIC, encode('std_msgs/msg/String', {'data': text}),
                             int(STAMPS[-1]))
            elif report:
                writer.attachment('report.json', 'application/json', text.encode())
        return str(path)
    return make


@pytest.fixture
def told(capsys):
    """Return a function that runs the command and returns exit code, lines and stderr."""
    def run(*arguments):
        code = main(['rejudge', *map(str, arguments)])
        out, err = capsys.readouterr()
        return code, out.splitlines(), err
    return run


def test_a_bag_that_is_judged_as_it_was_is_the_same(make_bag, told):
    bag = make_bag()
    code, lines, said = told(bag, '--check')
    assert (code, said) == (0, '')
    assert lines[0].startswith(f'{bag}: same: COMPLIANT for errors that change within ')
    assert lines[1] == 'of 1: 0 changed, 0 not judged, 0 without a report, 1 the same'


def test_the_report_that_was_published_last_counts_where_none_is_attached(make_bag, told):
    code, lines, _ = told(make_bag(published=True, outcome='non_compliant'), '--check')
    assert code == 1 and f': NON-COMPLIANT by rule {RULE_VERSION} -> COMPLIANT' in lines[0]


def test_other_settings_change_an_outcome_and_are_named(make_bag, told):
    bag = make_bag()
    code, lines, _ = told(bag, '--set', 'norms.sigma_max_deg=0.01', '--check')
    assert code == 1
    assert lines[0].startswith(f'{bag}: COMPLIANT by rule {RULE_VERSION} -> ')
    assert lines[0].endswith(' (other settings: norms.sigma_max_deg)')
    assert told(bag, '--set', 'norms.sigma_max_deg=0.01')[0] == 0


@pytest.mark.parametrize('kept', ['report', 'published'])
def test_a_bag_of_several_sensors_is_judged_with_all_of_them(told, tmp_path, kept):
    """The last published report counts where a recorder that was killed attached none."""
    headings = make_three(gyro2=0.9)
    settings = Settings.of(sensors=TABLE, slowest_error_s=60.0)
    verdict = analyze_sensors(headings, settings)
    bags = []
    for name, changes in (('same', {}), ('changed', {'outcome': 'compliant'})):
        bags.append(str(write_bag(tmp_path / name, headings, stored={
            **describe_origin(settings.to_mapping())}, **{kept: json.dumps(
                {**verdict.to_dict(), **changes})})))
    code, lines, _ = told(*bags, '--check')
    assert code == 1
    assert lines[0].startswith(f'{bags[1]}: COMPLIANT by rule {RULE_VERSION} -> gyro1 COMPLIANT; '
                               'gyro2 NON-COMPLIANT')
    assert lines[1].startswith(f'{bags[0]}: same: gyro1 COMPLIANT; gyro2 NON-COMPLIANT')


def test_a_file_of_settings_takes_the_place_of_the_stored_ones(make_bag, told, tmp_path):
    config = tmp_path / 'mine.yaml'
    config.write_text('/**:\n  ros__parameters:\n    norms: {sigma_max_deg: 0.2, '
                      'sigma_ref_max_deg: 0.1}\n', 'utf-8')
    bag = make_bag(stored=describe_origin({'ts_topic': 'elsewhere', 'risk.method': 'x'}))
    assert 'ts_topic' not in told(bag, '--config', config)[2]
    assert told(bag, '--config', config)[1][0].startswith(f'{bag}: same: COMPLIANT')


def test_a_doubt_that_was_not_there_is_a_change(make_bag, told):
    code, lines, _ = told(make_bag(validity_effect='doubtful'), '--check')
    assert code == 1 and ': COMPLIANT, DOUBTFUL by rule ' in lines[0]


def test_the_worst_stands_first_and_a_bad_bag_stops_no_other(make_bag, told, tmp_path):
    same, better = make_bag('same'), make_bag('better', outcome='non_compliant')
    worse = make_bag('worse', stored={**STORED, 'settings.norms.sigma_max_deg': '0.01'})
    silent, absent = make_bag('silent', report=False), str(tmp_path / 'absent')
    code, lines, _ = told(same, absent, better, silent, worse, '--check')
    assert code == 1
    assert [line.partition(': ')[0] for line in lines[:-1]] == [
        worse, better, absent, silent, same]
    assert lines[2] == f'{absent}: not judged: No such file or directory'
    assert lines[3].startswith(f'{silent}: no report in it to compare with: COMPLIANT')
    assert lines[-1] == 'of 5: 2 changed, 1 not judged, 1 without a report, 1 the same'
    assert told(same, absent, '--check')[0] == told(same, silent, '--check')[0] == 3
    assert told(same, absent)[0] == 0


def test_a_bag_without_settings_asks_for_norms_or_takes_those_of_its_report(make_bag, told):
    code, lines, said = told(make_bag('none', stored={}, report=False))
    assert (code, lines) == (2, []) and said.count('\n') == 1
    assert ('none: it stores no settings: give norms.sigma_max_deg (or norms.preset) and '
            'norms.sigma_ref_max_deg with --config or --set') in said
    given = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1']
    assert ': no report in it' in told(make_bag('given', stored={}, report=False), *given)[1][0]
    assert ': same: ' in told(make_bag('report', stored={}))[1][0]
    lacking = describe_origin({**SETTINGS.to_mapping(), 'norms.sigma_max_deg': None})
    assert 'its settings have no norm: ' in told(make_bag('lacking', stored=lacking))[2]
    unknown = describe_origin({**SETTINGS.to_mapping(), 'norms.sigma': 0.3})
    assert "its settings: unknown setting 'norms.sigma'; did you mean " in told(
        make_bag('unknown', stored=unknown))[2]
    wrong = describe_origin({**SETTINGS.to_mapping(), 'window_s': 0.0})
    assert 'wrong: its settings: window_s = 0.0: must be ' in told(
        make_bag('wrong', stored=wrong))[2]


@pytest.mark.parametrize('report, words', [
    ('{', 'the report in it: is not JSON: '),
    ('[' * 100_000, 'the report in it: is not JSON of a verdict: nested too deeply'),
    ('[]', 'the report in it: a verdict must be an object, not list'),
    ('{"schema": "heading_intercompare/verdict/1"}', 'the report in it: schema_version = None: '),
    ('{"schema": "heading_intercompare/verdict/2"}', 'a newer version of heading_intercompare ')])
def test_a_report_that_is_none_is_told_and_the_bag_is_judged(make_bag, told, report, words):
    code, lines, said = told(make_bag(report=report), '--check')
    assert code == 3 and ': no report in it to compare with: COMPLIANT' in lines[0]
    assert words in said and said.count('\n') == 1


def test_a_bag_that_is_cut_is_judged_as_far_as_it_goes(make_bag, told):
    bag = make_bag()
    (file,) = Path(bag).glob('*.mcap')
    file.write_bytes(file.read_bytes()[:-file.stat().st_size // 3])
    code, lines, said = told(bag, '--check')
    assert code == 0 and f'note: {bag}: ' in said and ': same: COMPLIANT' in lines[0], said
    file.write_bytes(b'no bag')
    code, lines, said = told(bag)
    assert (code, lines) == (2, []) and said.count('\n') == 1 and 'bag' in said


def test_the_json_holds_all_and_is_no_input(make_bag, told, tmp_path):
    bag, file = make_bag(), tmp_path / 'r.json'
    assert told(bag, '--json', file)[0] == 0
    mapping = json.loads(file.read_text('utf-8'))
    assert mapping['schema'] == 'heading_intercompare/rejudge/1'
    assert mapping['rule_version'] == RULE_VERSION
    (entry,) = mapping['bags']
    assert (entry['path'], entry['status'], entry['outcome']) == (bag, 'same', 'compliant')
    assert entry['former']['settings_sha256'] == entry['settings_sha256']
    _, lines, _ = told(bag, '--json', '-')
    assert json.loads('\n'.join(lines)) == mapping
    (part,) = Path(bag).glob('*.mcap')
    before = part.read_bytes()
    assert told(part, '--json', part)[0] == 2 and part.read_bytes() == before


@pytest.mark.parametrize('options, words', [
    (['--set', 'norms.sigma=1'], "unknown setting 'norms.sigma'"),
    (['--config', 'absent.yaml'], 'absent.yaml: No such file or directory')])
def test_a_mistake_is_one_line(make_bag, told, options, words):
    code, lines, said = told(make_bag(), *options)
    assert (code, lines) == (2, []) and words in said and said.count('\n') == 1


def test_a_cut_by_the_clock_that_a_report_did_not_have_is_another_setting(make_bag, told):
    _, lines, _ = told(make_bag(), '--set', 'runs.every_h=0.1', '--json', '-')
    (entry,) = json.loads('\n'.join(lines))['bags']
    assert entry['settings_changed'] == ['runs.every_h']


@pytest.fixture
def make_verdict(make_bag, tmp_path, capsys):
    """Return a function that analyses a bag without settings, and returns bag and verdict."""
    def make(name='foreign'):
        bag, verdict = make_bag(name, stored=None, report=False), tmp_path / f'{name}.json'
        assert main(['analyze', bag, '--set', 'norms.sigma_max_deg=0.3', '--set',
                     'norms.sigma_ref_max_deg=0.1', '--json', str(verdict)]) == 0
        capsys.readouterr()
        return Path(bag), verdict
    return make


def test_a_verdict_is_judged_again_with_its_settings_and_inputs(make_verdict, told):
    bag, verdict = make_verdict()
    code, lines, said = told(verdict, '--check')
    assert (code, said) == (0, '')
    assert lines[0].startswith(f'{verdict}: same: COMPLIANT for errors that change within ')
    code, lines, _ = told(verdict, '--set', 'norms.sigma_max_deg=0.01', '--check')
    assert code == 1 and lines[0].endswith(' (other settings: norms.sigma_max_deg)')


def test_the_input_of_a_verdict_may_have_moved_with_it(make_verdict, told, tmp_path):
    bag, verdict = make_verdict()
    (tmp_path / 'archive').mkdir()
    bag.rename(tmp_path / 'archive' / bag.name)
    moved = verdict.rename(tmp_path / 'archive' / verdict.name)
    assert told(moved, '--check')[0] == 0


def test_a_verdict_whose_inputs_changed_or_are_gone_is_not_judged(make_verdict, make_bag, told):
    bag, verdict = make_verdict()
    Path(bag).rename(bag.with_name('away'))
    code, _, said = told(verdict)
    assert code == 2 and f'its input {bag} is neither there nor beside the verdict' in said
    make_bag('foreign', stored=STORED, report=False)
    code, _, said = told(verdict)
    assert code == 2 and 'holds other data than those that were judged' in said


def test_a_verdict_on_logs_says_what_to_do(told, tmp_path, trial):
    verdict = tmp_path / 'logs.json'
    verdict.write_text(json.dumps({**trial[2], 'inputs': [
        {'path': 'gyro.log', 'sha256': None, 'ts_topic': 'HDT', 'rs_topic': None,
         'not_taken': {}}]}), 'utf-8')
    code, _, said = told(verdict)
    assert code == 2 and 'gyro.log is a log' in said and 'use analyze' in said


def test_a_changed_verdict_is_a_change(make_verdict, told):
    bag, verdict = make_verdict()
    changed = json.loads(verdict.read_text('utf-8'))
    verdict.write_text(json.dumps({**changed, 'outcome': 'non_compliant'}), 'utf-8')
    code, lines, _ = told(verdict, '--check')
    assert code == 1 and f': NON-COMPLIANT by rule {RULE_VERSION} -> COMPLIANT' in lines[0]
