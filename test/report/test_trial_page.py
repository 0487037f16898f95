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

"""The page of a simulated trial."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('matplotlib')

from heading_intercompare.cli import main  # noqa: E402
from heading_intercompare.report.sketching.track import Trace  # noqa: E402
from heading_intercompare.report.trial_page import compose_trial_page  # noqa: E402


def make_trace(name, modes=()):
    """Return a trace that passes through north and has a hole."""
    t_h = np.linspace(0.0, 2.0, 50)
    heading = (350.0 + 20.0 * t_h) % 360.0
    heading[20:25] = np.nan
    return Trace(name, 12_345, t_h, heading, heading, np.full(50, -0.1), np.full(50, 0.2),
                 np.full(50, 0.1), modes)


def test_a_sensor_has_its_headings_its_errors_and_its_modes():
    page = compose_trial_page('A <trial>', ['said & done'], [
        make_trace('TS', ((0.0, 'COARSE_LEVELLING'), (1.0, 'GYROCOMPASS'))), make_trace('RS')])
    assert '<h1>A &lt;trial&gt;</h1>' in page and '<p>said &amp; done</p>' in page
    assert page.count('<svg') == 4
    for text in ('TS: heading, 12345 readings', 'TS: error', 'true heading', 'reading',
                 'twice the claimed standard deviation', 'COARSE_LEVELLING', 'GYROCOMPASS',
                 'time [h]', 'heading [deg]', 'error [deg]'):
        assert text in page
    assert 'http://' not in page.replace('http://www.w3.org', '') and '<script' not in page


def test_the_page_is_sound_and_its_ids_are_unique():
    page = compose_trial_page('T', [], [make_trace('TS'), make_trace('RS')])
    body = page.replace('<!DOCTYPE html>', '').replace('<meta charset="utf-8">', '')
    ids = [one.get('id') for one in ElementTree.fromstring(body).iter() if one.get('id')]
    assert len(ids) == len(set(ids))


def test_seeds_have_a_chart():
    columns = {'seed': [1, 2, 3], 'true_mean_deg': [0.1, 0.2, 0.15], 'mean_deg': [0.1, 0.2, 0.1],
               'low_deg': [0.0, 0.1, np.nan], 'high_deg': [0.2, 0.3, np.nan]}
    page = compose_trial_page('T', [], (), columns)
    assert page.count('<svg') == 1 and '95 % interval of the mean difference' in page


def test_simulate_writes_the_page(tmp_path, capsys):
    trial = tmp_path / 'trial.yaml'
    trial.write_text('duration_s: 60\nts: {model: imo, ahrs: {initial_state: aligned}}\n',
                     encoding='utf-8')
    assert main(['simulate', '--scenario', str(trial), '-o', str(tmp_path / 'bag'), '--page',
                 str(tmp_path / 'page.html')]) == 0
    assert capsys.readouterr().out.endswith(f'page: {tmp_path / "page.html"}\n')
    page = (tmp_path / 'page.html').read_text(encoding='utf-8')
    assert page.count('<svg') == 4 and 'GYROCOMPASS' in page
