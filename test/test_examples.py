# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The examples run and say what they are there to say."""

from __future__ import annotations

from pathlib import Path
import runpy

import pytest

EXAMPLES = Path(__file__).resolve().parent.parent / 'examples'


@pytest.mark.parametrize('name, words', [
    ('judge_arrays.py', 'compliant: '), ('judge_arrays.py', '(j) '),
    ('three_sensors.py', 'gyro: 0.')])
def test_an_example_runs(name, words, capsys):
    runpy.run_path(str(EXAMPLES / name))
    assert words in capsys.readouterr().out


def test_every_example_is_run():
    assert {p.name for p in EXAMPLES.glob('*.py')} == {'judge_arrays.py', 'three_sensors.py'}
