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

"""Files of 0.1.0 give the right figures, or are rejected in a line that says what to do."""

from __future__ import annotations

import csv
import json
from pathlib import Path
import re

import jsonschema
import pytest
import yaml

from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.cli import main
from heading_intercompare.core.settings import leave_out_gone, Settings
from heading_intercompare.report.json import read

FORMER = Path(__file__).resolve().parents[1] / 'data' / '0_1_0'
BAG, PAIRS, ENSEMBLES, VERDICT, PARAMETERS = (str(FORMER / name) for name in (
    'bag', 'pairs.csv', 'ensembles.csv', 'verdict.json', 'parameters.yaml'))
NORMS = ['--set=norms.sigma_max_deg=0.3', '--set=norms.sigma_ref_max_deg=0.1',
         '--set=risk.min_duration_s=0', '--set=pairing.kernel=line']
THEN = json.loads(Path(VERDICT).read_text('utf-8'))['runs'][0]
#: Figures that neither the rule nor the pairing by a line has changed.
KEPT = ('start_ns', 'end_ns', 'n_input', 'n', 'mean_deg', 'min_deg', 'max_deg', 'variance_deg2',
        'std_deg', 'outcome', 'paper_outcome')
GONE = ['detectors.same_source_ratio', 'risk.method', 'risk.nu_min', 'risk.r1_max',
        'risk.share_max']


def judged(capsys, *arguments: str) -> dict:
    """Return the only run of a verdict."""
    assert main(['analyze', *arguments, *NORMS, '--json', '-']) == 0
    return json.loads(capsys.readouterr().out)['runs'][0]


def refused(capsys, *arguments: str) -> str:
    """Return the one line with which a command rejects its input."""
    assert main([*arguments]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    return said


@pytest.mark.parametrize('given', [[BAG], [f'{BAG}/bag_0.mcap'], [PAIRS]])
def test_a_bag_and_a_csv_of_pairs_give_the_figures_that_they_gave(capsys, given):
    run = judged(capsys, *given)
    for name in KEPT:
        assert run[name] == (pytest.approx(THEN[name], rel=1e-9) if isinstance(
            THEN[name], float) else THEN[name]), name
    assert run['pairing']['paired'] == THEN['pairing']['paired'] == 149


def test_a_bag_is_sound_and_shows_what_it_holds(capsys):
    assert check_bag(BAG).faults == []
    assert main(['info', BAG]) == 0
    said = capsys.readouterr().out
    assert 'software: heading_intercompare 0.1.0' in said and 'risk.method: dyadic+acf' in said
    assert re.search(r'not a verdict that this version can read: .*: judge the recordings again',
                     said)


def test_the_tables_are_written_as_they_were(capsys, tmp_path):
    judged(capsys, BAG, '--csv', str(tmp_path / 'p.csv'), '--ensembles', str(tmp_path / 'e.csv'),
           '--ensemble-s', '60')
    assert (tmp_path / 'e.csv').read_bytes() == Path(ENSEMBLES).read_bytes()
    now, then = (list(csv.DictReader(Path(path).open(newline='', encoding='utf-8')))
                 for path in (tmp_path / 'p.csv', PAIRS))
    assert [row['stamp_ns'] for row in now] == [row['stamp_ns'] for row in then]
    for name in [*then[0]][1:]:  # the last bit of a sine is the processor's own
        assert [float(row[name]) for row in now] == pytest.approx(
            [float(row[name]) for row in then], rel=0, abs=1e-12), name


def test_a_refused_verdict_says_how_to_make_it_again(capsys, tmp_path):
    said = refused(capsys, 'report', VERDICT, '-o', str(tmp_path / 'r.html'))
    assert f"{VERDICT}: schema = 'heading_intercompare/verdict/1'" in said
    assert said.endswith('judge the recordings again, with `analyze` or `rejudge`\n')


@pytest.mark.parametrize('version, rule', [('2_0', None), ('2_1', 2)])
def test_a_verdict_of_before_is_read_as_it_was(version, rule, tmp_path):
    path = FORMER / f'verdict_{version}.json'
    given, verdict = json.loads(path.read_text('utf-8')), read(path)
    assert verdict.rule_version == rule
    given.pop('schema_version', None)
    assert {name: thing for name, thing in verdict.to_dict().items() if name in given} == given
    assert main(['report', str(path), '-o', str(tmp_path / 'r.html')]) == 0


def test_a_verdict_of_2_1_meets_the_schema_that_is_installed():
    schema = json.loads((FORMER.parents[2] / 'schema' / 'verdict.schema.json').read_text('utf-8'))
    jsonschema.Draft202012Validator(schema).validate(
        json.loads((FORMER / 'verdict_2_1.json').read_text('utf-8')))


def test_a_parameter_file_is_refused_with_all_that_is_gone_and_read_without(capsys, tmp_path):
    said = refused(capsys, 'analyze', BAG, '--config', PARAMETERS, *NORMS)
    assert sorted(re.findall(r"'([a-z_.0-9]+)'", said)) == GONE
    for words in ('leave it out', 'use detectors.same_source_share instead'):
        assert words in said
    text = Path(PARAMETERS).read_text('utf-8')
    for name in GONE:
        text = re.sub(rf'^ +{name.partition(".")[2]}: .*\n', '', text, flags=re.MULTILINE)
    (tmp_path / 'mine.yaml').write_text(text, 'utf-8')
    run = judged(capsys, BAG, '--config', str(tmp_path / 'mine.yaml'))
    assert run['variance_deg2'] == pytest.approx(THEN['variance_deg2'], rel=1e-9)


def test_every_setting_of_then_is_taken_or_said_to_be_gone():
    stored = json.loads(Path(VERDICT).read_text('utf-8'))['settings']
    kept, gone = leave_out_gone(stored)
    assert [line.partition(' = ')[0] for line in sorted(gone)] == GONE
    assert all(' is gone: ' in line for line in gone)
    settings = Settings.from_mapping(kept).to_mapping()
    assert {name: settings[name] for name in kept} == kept


def test_the_sections_of_the_nodes_hold_settings_that_nodes_have_still():
    now = yaml.safe_load((FORMER.parents[2] / 'config' / 'heading_intercompare.yaml').read_text())
    then = yaml.safe_load(Path(PARAMETERS).read_text('utf-8'))
    for node in {*then} - {'/**'}:
        known = {*now[node]['ros__parameters'], *now['ts_driver']['ros__parameters']} | {
            'note', 'report_dir', 'bag', 'duration_s', 'parameter_file', 'output'}
        assert {*then[node]['ros__parameters']} <= known, node
