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

"""The correction card: what it says to add brings the TS to the RS, on the headings held."""

from __future__ import annotations

import csv
from dataclasses import replace
import re

import numpy as np
import pytest
from trials import make_settings

from heading_intercompare import analyze, Headings
from heading_intercompare.report.correction_card import (
    check_card,
    COLUMNS,
    list_card,
    write_card,
)

pytest.importorskip('jinja2')


@pytest.fixture
def deviating(rng):
    """Return a function of settings: the verdict on a TS with a deviation, on 0, 45, 90, 135."""
    def judge(**settings):
        rs_deg = np.repeat([0.0, 45.0, 90.0, 135.0, 90.0, 45.0, 0.0], 300)
        error_deg = 0.2 + 0.3 * np.sin(np.radians(rs_deg))
        stamps = (np.arange(rs_deg.size) + 1_700_000_000) * 10 ** 9
        ts_deg = np.mod(rs_deg + error_deg + 0.05 * rng.standard_normal(rs_deg.size), 360.0)
        return analyze(Headings.of(stamps, ts_deg), Headings.of(stamps, rs_deg),
                       make_settings(**settings))
    return judge


def read(verdict, path):
    write_card(verdict, path)
    with open(path, newline='') as file:
        return [*csv.DictReader(file)]


@pytest.mark.parametrize('offset_deg', [0.0, 0.2])
def test_the_correction_brings_the_ts_to_the_rs_whatever_the_stated_offset(
        deviating, tmp_path, offset_deg):
    rows = read(deviating(installation_offset_deg=offset_deg), tmp_path / 'card.csv')
    assert [row['heading_deg'] for row in rows] == [str(45 * at) for at in range(8)]
    for row in rows[:4]:
        expected = -0.2 - 0.3 * np.sin(np.radians(float(row['heading_deg'])))
        assert float(row['c_minus_o_deg']) == pytest.approx(expected, abs=0.02)
        low, up = float(row['c_minus_o_low_deg']), float(row['c_minus_o_high_deg'])
        assert low < float(row['c_minus_o_deg']) < up < low + 0.05
    for row in rows[4:]:
        assert (row['c_minus_o_deg'], row['c_minus_o_low_deg'], row['n']) == ('', '', '0')


def test_the_page_has_the_headings_held_and_leaves_the_others_empty(deviating, tmp_path):
    place = tmp_path / 'card.html'
    write_card(deviating(trial__ship='MV <Example>'), place)
    text = place.read_text('utf-8')
    cells = re.findall(r'<th scope="row">(\d+)</th><td>(.*?)</td><td>(.*?)</td>', text)
    assert [heading for heading, _, _ in cells] == [f'{45 * at:03d}' for at in range(8)]
    assert float(cells[2][1]) == pytest.approx(-0.5, abs=0.02) and cells[2][2] == '0.01'
    assert cells[4:] == [(f'{45 * at}', '', '') for at in range(4, 8)]
    assert 'MV &lt;Example&gt;' in text and '<Example>' not in text


def test_a_void_run_has_no_card(deviating, tmp_path):
    verdict = deviating()
    void = replace(verdict, runs=[replace(verdict.runs[0], validity_effect='void')])
    assert list_card(void.runs[0], 0.0) == [] != list_card(verdict.runs[0], 0.0)
    assert read(void, tmp_path / 'card.csv') == []
    assert (tmp_path / 'card.csv').read_text() == ','.join(COLUMNS) + '\n'
    write_card(void, tmp_path / 'card.html')
    assert 'Without a card: run 1' in (tmp_path / 'card.html').read_text('utf-8')


def test_a_pdf_is_printed(deviating, tmp_path):
    pytest.importorskip('weasyprint')
    write_card(deviating(), tmp_path / 'card.pdf')
    assert (tmp_path / 'card.pdf').read_bytes().startswith(b'%PDF')


@pytest.mark.parametrize('name', ['card', 'card.txt', 'card.json'])
def test_another_form_is_refused(name):
    with pytest.raises(ValueError, match=f'--card {name}: a card must end in'):
        check_card(name)
