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

"""One sensor judged by observations, whatever its readings are kept in."""

from __future__ import annotations

from checksums import with_checksum
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare.app.observations.observed_sensor import observe, Uncertainties
from heading_intercompare.app.observations.targets import Target
from heading_intercompare.bags.csv.pairs_csv import write_pairs_csv
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

START = 1_773_136_800
STATED = Uncertainties(common_u_deg=0.05)
SETTINGS = Settings.of(systematic_max_deg=0.75)


@pytest.fixture
def table(tmp_path):
    """Return the path of a table: the ship lies at 73.42 deg."""
    rows = [f'2026-03-10 10:{m:02d}:00,{0.01 * (m % 3)}' for m in range(1, 9)]
    path = tmp_path / 'table.csv'
    path.write_text('\n'.join(['time,relative_bearing_deg', *rows]) + '\n')
    return str(path)


def readings():
    """Return ten minutes of a TS that shows 0.2 deg too much."""
    t = START + np.arange(600)
    return t * 1_000_000_000, np.full(600, 73.62)


def write_bag(path, stamps, headings):
    return write_headings(path, {'ts/heading': Headings.of(stamps, headings)})


def write_log(path, stamps, headings):
    lines = []
    for stamp, heading in zip(stamps, headings):
        text = f'HEHDT,{heading:.2f},T'
        second = stamp // 1_000_000_000 - START
        lines.append(f'2026-03-10T10:{second // 60:02d}:{second % 60:02d}.000Z '
                     f'{with_checksum(text)}\r\n')
    path.write_text(''.join(lines))
    return str(path)


def write_pairs(path, stamps, headings):
    write_pairs_csv(path, [Pairs.of(stamps, headings, headings + 1.0)])
    return str(path)


def write_table(path, stamps, headings):
    path.write_text('\n'.join(['t_ns,heading_deg', *(
        f'{stamp},{heading}' for stamp, heading in zip(stamps, headings))]) + '\n')
    return str(path)


@pytest.mark.parametrize('write, name', [
    (write_bag, 'bag'), (write_log, 'gyro.log'), (write_pairs, 'pairs.csv'),
    (write_table, 'gyro.csv')])
def test_each_kind_of_recording_gives_the_same_correction(tmp_path, table, write, name):
    recording = write(tmp_path / name, *readings())
    found = observe(recording, table, SETTINGS, target=Target('bearing', (73.42,)), stated=STATED)
    # The mean relative bearing of 0.01, 0.02, 0, 0.01, 0.02, 0, 0.01, 0.02 is 0.01125.
    assert found.error.correction_deg == pytest.approx(-0.2 - 0.01125, abs=1e-9)
    assert found.error.outcome is Outcome.COMPLIANT and found.error.n == 8
    assert found.corrections.step_deg == pytest.approx(0.01)


def test_the_points_of_a_line_add_to_what_all_share(tmp_path, table):
    recording = write_table(tmp_path / 'gyro.csv', *readings())
    target = Target('line', (54.0, 10.0, 54.0002, 10.001), 0.05)
    found = observe(recording, table, SETTINGS, target=target, stated=STATED)
    common = next(c for c in found.error.components if c.name == 'common')
    assert common.u_deg == pytest.approx(np.hypot(0.05, found.table.target_u_deg))
    assert found.table.target_u_deg == pytest.approx(np.degrees(2 ** 0.5 * 0.05 / 69.2), rel=0.01)


def test_what_all_share_must_be_stated_once(tmp_path, table):
    with pytest.raises(ValueError, match=r'--common-u-deg, or a column common_u_deg; 0 if'):
        observe(None, table, SETTINGS, target=Target('bearing', (73.42,)))
    both = tmp_path / 'both.csv'
    both.write_text('time,true_heading_deg,ts_heading_deg,common_u_deg\n'
                    '2026-03-10 10:00:00,73.4,73.6,0.1\n2026-03-10 10:01:00,73.4,73.6,0.1\n')
    with pytest.raises(ValueError, match='leave out one of them'):
        observe(None, str(both), SETTINGS, stated=STATED)
    found = observe(None, str(both), SETTINGS)
    assert found.error.components[1].u_deg == 0.1 and found.recording is None
