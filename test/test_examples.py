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

"""The examples run and give the results that they are meant to show."""

from __future__ import annotations

import ast
from itertools import pairwise
import json
from pathlib import Path
import re
import runpy

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / 'examples'
NOTEBOOK = EXAMPLES / 'verdict_in_a_notebook.ipynb'
NOTEBOOKS = sorted(EXAMPLES.glob('*.ipynb'))


@pytest.mark.parametrize('name, words', [
    ('judge_arrays.py', 'compliant: '), ('judge_arrays.py', '(j) '),
    ('three_sensors.py', 'gyro: 0.')])
def test_an_example_runs(name, words, capsys):
    runpy.run_path(str(EXAMPLES / name))
    assert words in capsys.readouterr().out


def test_every_example_is_run():
    assert {p.name for p in EXAMPLES.iterdir() if p.is_file()} == {
        'judge_arrays.py', 'three_sensors.py', NOTEBOOK.name, 'two_loggers.ipynb',
        'how_long.ipynb'}


def run_cells(path):
    """Run the code cells of a notebook in one namespace; return the value each ends with."""
    namespace, values = {}, []
    for cell in json.loads(path.read_text('utf-8'))['cells']:
        if cell['cell_type'] == 'code':
            body = ast.parse(''.join(cell['source'])).body
            last = body.pop() if isinstance(body[-1], ast.Expr) else None
            exec(compile(ast.Module(body, []), path.name, 'exec'), namespace)
            values.append(None if last is None else eval(
                compile(ast.Expression(last.value), path.name, 'eval'), namespace))
    return values


@pytest.mark.slow
def test_the_notebook_runs_and_shows_the_verdict(capsys, monkeypatch):
    pytest.importorskip('matplotlib')
    monkeypatch.setenv('MPLBACKEND', 'Agg')
    _, verdict, *_ = run_cells(NOTEBOOK)
    assert verdict._repr_html_().count('COMPLIANT') >= 2
    printed = capsys.readouterr().out
    assert 'COMPLIANT' in printed and printed.rstrip().endswith('1.50 s')


@pytest.mark.slow
def test_the_notebook_of_two_loggers_reads_their_tables_and_judges(capsys, monkeypatch):
    pytest.importorskip('matplotlib')
    monkeypatch.setenv('MPLBACKEND', 'Agg')
    *_, verdict, pairing, _, figure, _ = run_cells(EXAMPLES / 'two_loggers.ipynb')
    assert verdict.outcome == 'compliant' and pairing.ts_received == 3000
    assert 'COMPLIANT for errors' in capsys.readouterr().out
    assert figure.axes[0].lines and 'difference' in figure.axes[0].get_ylabel()


@pytest.mark.slow
@pytest.mark.endurance
def test_the_notebook_on_lengths_shows_that_a_poor_sensor_is_not_certified(capsys):
    run_cells(EXAMPLES / 'how_long.ipynb')
    printed = capsys.readouterr().out
    fast, slow = re.findall(r'worth +([0-9]+) independent ones: (\w+)', printed)
    assert int(fast[0]) > 20 * int(slow[0])
    assert (fast[1], slow[1]) == ('compliant', 'indeterminate')
    as_printed, guarded = re.search(r'printed: (\d+) of 20; .*: (\d+) of 20', printed).groups()
    assert int(as_printed) >= 5 and int(guarded) == 0
    chances = re.findall(r'^ *(\d+) x .* at 0.70 of norm: .* ([0-9.]+)$', printed, re.MULTILINE)
    for runs in ('1', '20'):
        of_these = [float(chance) for number, chance in chances if number == runs]
        assert of_these[-1] > 0.9
        assert all(later > earlier - 0.05 for earlier, later in pairwise(of_these))
    assert len(chances) > 5


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path):
    cells = json.loads(path.read_text('utf-8'))['cells']
    assert len(cells) > 4 and all(not cell.get('outputs') for cell in cells)
