# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The examples run and give the results that they are meant to show."""

from __future__ import annotations

import ast
import json
from pathlib import Path
import runpy

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / 'examples'
NOTEBOOK = EXAMPLES / 'verdict_in_a_notebook.ipynb'


@pytest.mark.parametrize('name, words', [
    ('judge_arrays.py', 'compliant: '), ('judge_arrays.py', '(j) '),
    ('three_sensors.py', 'gyro: 0.')])
def test_an_example_runs(name, words, capsys):
    runpy.run_path(str(EXAMPLES / name))
    assert words in capsys.readouterr().out


def test_every_example_is_run():
    assert {p.name for p in EXAMPLES.iterdir() if p.is_file()} == {
        'judge_arrays.py', 'three_sensors.py', NOTEBOOK.name}


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


def test_the_notebook_is_kept_without_outputs():
    cells = json.loads(NOTEBOOK.read_text('utf-8'))['cells']
    assert all(not cell.get('outputs') for cell in cells)
