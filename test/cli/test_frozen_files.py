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

"""Frozen files of 0.1.0 give the figures that they gave."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from command_line import analyze_json
import pytest

from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.cli import main
from heading_intercompare.report.json import read

FROZEN = Path(__file__).resolve().parents[1] / 'data' / '0_1_0'
BAG, PAIRS, ENSEMBLES, VERDICT = (str(FROZEN / name) for name in (
    'bag', 'pairs.csv', 'ensembles.csv', 'verdict.json'))
NORMS = ['--set=norms.sigma_max_deg=0.3', '--set=norms.sigma_ref_max_deg=0.1',
         '--set=risk.min_duration_s=0']
RUN = json.loads(Path(VERDICT).read_text('utf-8'))['runs'][0]
FIGURES = ('start_ns', 'end_ns', 'n_input', 'n', 'mean_deg', 'min_deg', 'max_deg',
           'variance_deg2', 'std_deg', 'outcome', 'paper_outcome')


def analyze_run(capsys, *arguments: str) -> dict:
    """Return the only run of a verdict."""
    return analyze_json(capsys, *arguments, norms=NORMS)[0]['runs'][0]


@pytest.mark.parametrize('recording', [[BAG], [f'{BAG}/bag_0.mcap'], [PAIRS]])
def test_a_bag_and_a_csv_of_pairs_give_the_figures_that_they_gave(capsys, recording):
    run = analyze_run(capsys, *recording)
    for name in FIGURES:
        assert run[name] == (pytest.approx(RUN[name], rel=1e-9) if isinstance(
            RUN[name], float) else RUN[name]), name
    assert run['pairing']['paired'] == RUN['pairing']['paired'] == 145


def test_a_bag_is_sound_and_shows_what_it_holds(capsys):
    assert check_bag(BAG).faults == []
    assert main(['info', BAG]) == 0
    shown = capsys.readouterr().out
    assert 'software: heading_intercompare 0.1.0' in shown and 'norms.sigma_max_deg: 0.3' in shown
    assert RUN['headline'] in shown


def test_a_bag_is_judged_as_its_report_says(capsys):
    assert main(['rejudge', BAG, '--check']) == 0
    assert ': same: ' in capsys.readouterr().out


def test_the_tables_are_written_as_they_were(capsys, tmp_path):
    analyze_run(capsys, BAG, '--csv', tmp_path / 'p.csv', '--ensembles', tmp_path / 'e.csv',
                '--ensemble-s', '60')
    assert (tmp_path / 'e.csv').read_bytes() == Path(ENSEMBLES).read_bytes()
    now, then = (list(csv.DictReader(Path(path).open(newline='', encoding='utf-8')))
                 for path in (tmp_path / 'p.csv', PAIRS))
    assert [row['stamp_ns'] for row in now] == [row['stamp_ns'] for row in then]
    for name in [*then[0]][1:]:  # the last bit of a sine is the processor's own
        assert [float(row[name]) for row in now] == pytest.approx(
            [float(row[name]) for row in then], rel=0, abs=1e-12), name


def test_a_verdict_is_read_as_it_was(tmp_path):
    assert read(VERDICT).to_dict() == json.loads(Path(VERDICT).read_text('utf-8'))
    assert main(['report', VERDICT, '-o', str(tmp_path / 'r.html')]) == 0
