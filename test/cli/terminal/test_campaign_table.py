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

"""A campaign is one line per recording by name, the worst first."""

from __future__ import annotations

import csv
from dataclasses import replace
import re

from journals import NORMS, some_pairs
import numpy as np
import pytest

from heading_intercompare import Pairs, Settings
from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.bags.csv.pairs_csv import PairsCsvWriter
from heading_intercompare.cli import main
from heading_intercompare.cli.terminal.campaign_table import campaign_lines, is_campaign

S = 1_000_000_000
SET = [part for name, value in NORMS.items() for part in ('--set', f'{name}={value}')]


def write_pairs(path, pairs):
    """Write a csv file of pairs, and return its path."""
    path.parent.mkdir(exist_ok=True)
    writer = PairsCsvWriter(str(path))
    writer.write(pairs)
    writer.close()
    return str(path)


@pytest.fixture
def recordings(tmp_path):
    """Return recordings: one within the norm, one of two runs, one above, one that is none."""
    later = some_pairs(1500, 0.5, seed=8)
    two = Pairs.concatenate([some_pairs(1500, 0.1, seed=7), Pairs.of(
        later.stamp_ns + 2500 * S, later.ts_deg, later.rs_deg)])
    found = [write_pairs(tmp_path / name, pairs) for name, pairs in (
        ('quiet.csv', some_pairs(1500, 0.1)), ('two.csv', two),
        ('wild.csv', some_pairs(1500, 0.6, seed=6)))]
    (tmp_path / 'torn.csv').write_text('nothing\n')
    return [*found, str(tmp_path / 'torn.csv')]


def cells(line):
    """Return the cells of a line of the table."""
    return [cell for cell in line.split('  ') if cell]


def test_one_line_per_recording_the_worst_first(recordings):
    verdict = judge_bags(recordings, Settings.from_mapping(NORMS)).verdict
    lines = campaign_lines(verdict)
    assert lines[0] == f'VERDICT: {verdict.headline}'
    table = [[cell.strip() for cell in cells(line)] for line in lines[3:8]]
    assert table[0] == ['recording', 'outcome', 'sd/deg', 'of norm', 'mean/deg', 'run', 'n',
                        'duration', 'in doubt']
    assert [row[0] for row in table[1:]] == ['wild.csv', 'two.csv', 'torn.csv', 'quiet.csv']
    wild, two, torn, quiet = table[1:]
    # The norm of the scatter: sqrt(0.3^2 + 0.1^2) = 0.316 degrees.
    run = verdict.runs[-1]
    assert wild[1] == 'NON-COMPLIANT' and wild[2] == f'{run.std_deg:.3f}'
    assert wild[3] == f'{run.std_deg / np.sqrt(0.1):.0%}'
    assert two[1] == 'NON-COMPLIANT' and two[5:7] == ['3, worst of 2', '1500']
    assert torn[1] == 'NOT JUDGED' and torn[-1] == verdict.inputs[-1].error
    assert quiet[1].startswith('COMPLIANT') and quiet[7] == '25 min'
    assert re.match(r'\d+ of \d+ runs comply.*; together \(every_run\): ', lines[-1])


def test_a_narrow_terminal_cuts_lines_and_a_long_name_loses_its_middle(tmp_path):
    name = f'{"a" * 30}{"b" * 30}.csv'
    paths = [write_pairs(tmp_path / folder / name, some_pairs(300, seed=seed))
             for folder, seed in (('x', 1), ('y', 2))]
    verdict = judge_bags(paths, Settings.from_mapping(NORMS)).verdict
    table = campaign_lines(verdict, 60)[3:6]
    assert all(len(line) <= 60 for line in table) and table[0].endswith('…')
    # Two files of one name are told apart by their folders.
    assert {line.split()[0][:15] for line in table[1:]} == {path[:15] for path in paths}


def test_the_logs_of_two_sensors_are_no_campaign(recordings):
    verdict = judge_bags(recordings[:2], Settings.from_mapping(NORMS)).verdict
    assert is_campaign(verdict)
    logs = [replace(given, not_taken={}) for given in verdict.inputs]
    assert not is_campaign(replace(verdict, inputs=logs))
    assert not is_campaign(replace(verdict, inputs=verdict.inputs[:1]))


def test_the_table_of_runs_has_a_row_per_run_and_names_what_was_not_judged(recordings, tmp_path,
                                                                        capsys):
    table = tmp_path / 'runs.csv'
    assert main(['analyze', *recordings, *SET, '--runs-csv', str(table)]) == 0
    assert capsys.readouterr().out.count('\n') == 10
    with open(table, newline='', encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    verdict = judge_bags(recordings, Settings.from_mapping(NORMS)).verdict
    assert [(row['recording'], row['run']) for row in rows] == [
        *((run.source, str(run.run)) for run in verdict.runs), (recordings[-1], '')]
    for row, run in zip(rows, verdict.runs):
        assert int(row['start_ns']) == run.start_ns and int(row['n']) == run.n
        assert float(row['sd_deg']) == run.std_deg
        assert float(row['upper_bound_deg2']) == run.guarded.upper_bound_deg2
        assert (row['outcome'], row['validity']) == (run.outcome.value, run.validity_effect)
    assert rows[-1]['reason'] == verdict.inputs[-1].error


@pytest.mark.parametrize('target', ['.', 'nowhere/runs.csv', ''])
def test_a_table_of_runs_that_cannot_be_written_is_rejected_before_any_work(
        recordings, tmp_path, capsys, monkeypatch, target):
    monkeypatch.chdir(tmp_path)
    assert main(['analyze', *recordings, *SET, '--runs-csv', target]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f'heading-intercompare: error: --runs-csv {target}: ')
    assert error.count('\n') == 1


def test_a_table_of_runs_overwrites_no_input(recordings, capsys):
    assert main(['analyze', *recordings, *SET, '--runs-csv', recordings[0]]) == 2
    assert 'that is an INPUT; name another file' in capsys.readouterr().err
