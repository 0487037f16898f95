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

"""The overview of several sensors: outcomes, links to the protocols, nothing raw."""

from __future__ import annotations

from dataclasses import replace
import re

import pytest
from ship_of_sensors import make_three, TABLE

from heading_intercompare import analyze_sensors
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.report.sensors_report import sensor_path, write_protocols


@pytest.fixture(scope='module')
def verdict():
    return analyze_sensors(make_three(gyro2=0.9), Settings.of(
        sensors=TABLE, slowest_error_s=60.0, trial={'ship': 'Palmer <b>'}))


def test_the_protocol_of_a_sensor_lies_beside_the_overview(tmp_path):
    assert sensor_path(tmp_path / 'a.b.pdf', 'ins') == tmp_path / 'a.b-ins.pdf'


def test_the_overview_says_each_outcome_and_links_its_protocol(verdict, tmp_path):
    pytest.importorskip('matplotlib')
    given = replace(verdict, inputs=[Input('bag <script>', 'a' * 64)])
    files = write_protocols(given, tmp_path / 'ship.html')
    assert [file.name for file in files] == ['ship.html', 'ship-gyro1.html', 'ship-gyro2.html']
    assert [file.name for file in write_protocols(given, tmp_path / 's.html', annexes_apart=True)
            ] == ['s.html', 's-gyro1.html', 's-gyro1-annexes.html', 's-gyro2.html',
                  's-gyro2-annexes.html']
    text = files[0].read_text('utf-8')
    assert {*re.findall('href="([^"]*)"', text)} == {file.name for file in files[1:]}
    assert '<script>' not in text and 'Palmer &lt;b&gt;' in text
    assert 'src=' not in text and 'http' not in text
    blocks = re.findall('<div class="verdict ([a-z-]*)">.*?<b>([a-z0-9]*)</b>', text, re.S)
    assert blocks == [('compliant', 'gyro1'), ('non-compliant', 'gyro2'),
                      ('indeterminate', 'gnss')]
    for pair in given.pairs:
        assert text.count(f'{pair.std_deg:.4f}') >= 2


def test_json_and_pdf(verdict, tmp_path):
    assert write_protocols(verdict, tmp_path / 'ship.json') == [tmp_path / 'ship.json']
    pytest.importorskip('weasyprint')
    pytest.importorskip('matplotlib')
    alone = replace(verdict, verdicts={})
    file, = write_protocols(alone, tmp_path / 'ship.pdf')
    assert file.read_bytes().startswith(b'%PDF')
