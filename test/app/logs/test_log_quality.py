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

"""What a sensor says of its readings reaches the verdict on its log."""

from __future__ import annotations

from checksums import with_checksum
from command_line import analyze_json
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import Headings
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.messages.cdr import decode
from heading_intercompare.messages.heading_messages import IMU
from heading_intercompare.messages.status_messages import STATUS_TYPE

N = 1800


@pytest.fixture
def logs(tmp_path, rng):
    """Return half an hour of a gyrocompass, and of an INS that loses GNSS and its heading."""
    second = np.arange(N)
    ship = 220.0 + 10.0 * np.sin(second / 40.0)
    is_poor = (second >= 900) & (second < 1100)
    headings = {'gyro': ship + 0.12 * rng.standard_normal(N),
                'ins': ship + 0.02 * rng.standard_normal(N) + is_poor * np.sin(second / 9.0)}
    sentences = {
        'gyro': [f'HEHDT,{heading:.2f},T' for heading in headings['gyro']],
        'ins': [f'PASHR,12{at // 60:02d}{at % 60:02d}.00,{heading:.2f},T,0.1,0.2,0.0,0.01,0.01,'
                + ('0.400,0,1' if poor else '0.020,2,1')
                for at, heading, poor in zip(second, headings['ins'], is_poor)]}
    paths = []
    for name, texts in sentences.items():
        paths.append(tmp_path / f'{name}.log')
        paths[-1].write_text(''.join(
            f'2014-08-01T12:{at // 60:02d}:{at % 60:02d}.000000Z {with_checksum(text)}\n'
            for at, text in enumerate(texts)))
    return paths


def test_a_bag_keeps_what_the_sensors_say(logs, capsys, tmp_path):
    """Of the logs, of the bag that `import` makes of them, and of a bag made of that bag."""
    bag, copy = str(tmp_path / 'bag'), str(tmp_path / 'copy')
    assert main(['import', *map(str, logs), '-o', bag, '--quiet']) == 0
    assert main(['import', bag, '-o', copy, '--quiet']) == 0
    by_logs, by_bag, by_copy = (analyze_json(capsys, *inputs)[0] for inputs in (
        logs, [bag], [copy]))
    assert by_logs['headline'] == by_bag['headline'] == by_copy['headline']
    assert (by_logs['runs'][0]['quality'] == by_bag['runs'][0]['quality']
            == by_copy['runs'][0]['quality'])


def test_a_claim_stands_in_the_covariance_of_an_imported_heading(logs, tmp_path):
    """Other programs find it where ROS has it: the variance about the vertical axis, rad²."""
    assert main(['import', *map(str, logs), '-o', str(tmp_path / 'bag'), '--quiet']) == 0
    variances: dict[str, list[float]] = {}
    for message in BagReader(tmp_path / 'bag').messages(['/ts/heading', '/rs/heading']):
        variances.setdefault(message.topic, []).append(
            decode(IMU, message.data)['orientation_covariance'][8])
    assert set(variances['/ts/heading']) == {0.0}
    assert np.degrees(np.sqrt(variances['/rs/heading'])) == pytest.approx(
        np.where((np.arange(N) >= 900) & (np.arange(N) < 1100), 0.4, 0.02))


def test_a_table_of_pairs_keeps_what_the_sensors_say(logs, capsys, tmp_path):
    table = tmp_path / 'pairs.csv'
    by_logs, _ = analyze_json(capsys, *logs, '--csv', table)
    by_table, _ = analyze_json(capsys, table)
    assert by_table['headline'] == by_logs['headline']
    assert by_table['runs'][0]['quality'] == by_logs['runs'][0]['quality']


def test_a_message_of_quality_that_cannot_be_read_is_said(tmp_path, rng, capsys):
    stamps = 1_800_000_000 * 10 ** 9 + np.arange(N) * 10 ** 9
    ship = 100.0 + 20.0 * np.sin(np.arange(N) / 40.0)

    def write_more(bag):
        bag.add_topic('/rs/heading/quality', STATUS_TYPE)
        bag.write('/rs/heading/quality', b'\0\1\0\0', int(stamps[-1]))
    write_headings(tmp_path / 'bag', {
        topic: Headings.of(stamps, ship + 0.05 * rng.standard_normal(N))
        for topic in ('/ts/heading', '/rs/heading')}, write_more=write_more)
    verdict, notes = analyze_json(capsys, tmp_path / 'bag')
    assert any('1 message about the quality of readings cannot be read (topic '
               '/rs/heading/quality)' in note for note in notes)
    assert 'quality' not in verdict['runs'][0]


@pytest.mark.parametrize('skew, n_reduced', [('report', 200), ('apply', 201)])
def test_an_ins_without_gnss_is_named_with_the_outcome_without_these_readings(
        logs, capsys, skew, n_reduced):
    """With a skew removed a pair lies between two readings, and one of them may be poor."""
    verdict, _ = analyze_json(capsys, *logs, '--set', f'alignment.skew={skew}')
    run = verdict['runs'][0]
    assert run['quality']['rs'] == {
        'n': run['n'], 'n_reduced': n_reduced, 'reduced_share': n_reduced / run['n'],
        'flags': {'normal': run['n'] - n_reduced, 'no GNSS aiding': n_reduced},
        'stated_median_deg': 0.02, 'stated_largest_deg': 0.4}
    assert run['quality']['without_reduced'] == 'compliant' and 'ts' not in run['quality']
    assert f'(RS no GNSS aiding {n_reduced}), without them compliant' in verdict['headline']


def test_two_gyrocompasses_say_nothing_of_their_readings(logs, capsys, tmp_path, rng):
    """HDT has no quality: the verdict has no block and no finding."""
    other = tmp_path / 'other.log'
    other.write_text(''.join(
        f'{line.partition(" ")[0]} ' + with_checksum(
            f'GPHDT,{float(line.split(",")[1]) + 0.02 * rng.standard_normal():.2f},T') + '\n'
        for line in logs[0].read_text().splitlines()))
    run = analyze_json(capsys, logs[0], other)[0]['runs'][0]
    assert 'quality' not in run
    assert 'reduced_quality' not in [finding['condition'] for finding in run['validity']]
