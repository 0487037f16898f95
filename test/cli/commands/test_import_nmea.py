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

"""What ``import-nmea`` does with stamps that no message of ROS holds."""

from __future__ import annotations

from datetime import datetime, timedelta
from functools import reduce
from operator import xor

import pytest

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli.program import main

#: Four seconds and a half before the 32-bit seconds of ROS end.
BEFORE = datetime(2038, 1, 19, 3, 14, 3, 500_000)


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a log of ten seconds from a time, and returns its path."""
    def write_from(name, begin, form='HEHDT,{},T'):
        said = [form.format(30.0 + second) for second in range(10)]
        lines = [f'{(begin + timedelta(seconds=second)).isoformat()}Z ${one}'
                 f'*{reduce(xor, one.encode()):02X}\n' for second, one in enumerate(said)]
        (tmp_path / name).write_text(''.join(lines))
        return str(tmp_path / name)
    return write_from


def test_what_fits_a_bag_is_imported_and_the_rest_is_named(write, tmp_path, capsys):
    """Before, one such stamp was an error, which left an empty bag."""
    bag = str(tmp_path / 'bag')
    log = write('gyro.log', BEFORE)
    assert main(['import-nmea', '--ts', log, '--rs', log, '-o', bag]) == 0
    assert capsys.readouterr().out.count('; 5 with a stamp that a bag cannot hold') == 2
    assert BagReader(bag).topics['/ts/heading'].count == 5


@pytest.mark.parametrize('options, first_deg', [
    (['--variation-deg', '2.5'], 32.5),
    (['--variation-deg', '9', '--ts-variation-deg', '-1'], 29.0)])
def test_a_stated_variation_makes_a_magnetic_heading_true(options, first_deg, write, tmp_path):
    bag = str(tmp_path / 'bag')
    log = write('mag.log', datetime(2026, 3, 1), 'HCHDM,{},M')
    assert main(['import-nmea', '--ts', log, '--rs', log, '-o', bag, *options]) == 0
    chunk = next(BagReader(bag).headings({'/ts/heading': 'enu'}))['/ts/heading']
    assert chunk.heading_deg[0] == pytest.approx(first_deg)


@pytest.mark.parametrize('options, reason', [
    ([], 'state the variation with --variation-deg'), (['--variation-deg', 'x'], "'x'"),
    (['--variation-deg', '181'], 'variation_deg = 181')])
def test_a_magnetic_heading_without_its_variation_is_one_line(options, reason, write, tmp_path,
                                                              capsys):
    log = write('mag.log', datetime(2026, 3, 1), 'HCHDM,{},M')
    command = ['import-nmea', '--ts', log, '--rs', log, '-o', str(tmp_path / 'bag'), *options]
    try:
        code = main(command)
    except SystemExit as ended:
        code = ended.code
    assert code == 2 and reason in capsys.readouterr().err


def test_a_log_that_fits_nowhere_is_one_line_and_leaves_no_bag(write, tmp_path, capsys):
    late, log = write('late.log', datetime(2039, 1, 1)), write('gyro.log', BEFORE)
    assert main(['import-nmea', '--ts', late, '--rs', log, '-o', str(tmp_path / 'bag')]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert f'{late}: a bag holds no stamp before 1970 or from 19 January 2038 on' in said
    assert not (tmp_path / 'bag').exists()
