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

"""What ``import`` takes of recordings, and what it does with stamps that no bag holds."""

from __future__ import annotations

from datetime import datetime, timedelta
from functools import reduce
import json
import math
from operator import xor

from command_line import analyze_json, refusal
import numpy as np
import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import Notes, read_notes, RECORD
from heading_intercompare.cli.program import main
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.utc_text import utc
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.ledger_messages import encode_losses
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE

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
    assert main(['import', '--ts', log, '--rs', log, '-o', bag]) == 0
    assert capsys.readouterr().out.count('; 5 with a stamp that a bag cannot hold') == 2
    assert BagReader(bag).topics['/ts/heading'].count == 5


@pytest.mark.parametrize('options, first_deg', [
    (['--variation-deg', '2.5'], 32.5),
    (['--variation-deg', '9', '--ts-variation-deg', '-1'], 29.0)])
def test_a_stated_variation_makes_a_magnetic_heading_true(options, first_deg, write, tmp_path):
    bag = str(tmp_path / 'bag')
    log = write('mag.log', datetime(2026, 3, 1), 'HCHDM,{},M')
    assert main(['import', '--ts', log, '--rs', log, '-o', bag, *options]) == 0
    chunk = next(BagReader(bag).headings({'/ts/heading': 'enu'}))['/ts/heading']
    assert chunk.heading_deg[0] == pytest.approx(first_deg)


@pytest.mark.parametrize('options, reason', [
    ([], 'state the variation with --variation-deg'), (['--variation-deg', 'x'], "'x'"),
    (['--variation-deg', '181'], 'variation_deg = 181')])
def test_a_magnetic_heading_without_its_variation_is_one_line(options, reason, write, tmp_path,
                                                              capsys):
    log = write('mag.log', datetime(2026, 3, 1), 'HCHDM,{},M')
    command = ['import', '--ts', log, '--rs', log, '-o', str(tmp_path / 'bag'), *options]
    try:
        code = main(command)
    except SystemExit as ended:
        code = ended.code
    assert code == 2 and reason in capsys.readouterr().err


def test_a_log_that_fits_nowhere_is_one_line_and_leaves_no_bag(write, tmp_path, capsys):
    late, log = write('late.log', datetime(2039, 1, 1)), write('gyro.log', BEFORE)
    assert main(['import', '--ts', late, '--rs', log, '-o', str(tmp_path / 'bag')]) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert f'{late}: a bag holds no stamp before 1970 or from 19 January 2038 on' in said
    assert not (tmp_path / 'bag').exists()


S = 10 ** 9
T0 = 1_700_000_000 * S
N = 1200
TWIST = 'geometry_msgs/msg/TwistStamped'


def two_headings():
    """Return the headings of a TS and an RS of a ship that yaws."""
    k = np.arange(N)
    ship_deg = 100.0 + 20.0 * np.sin(k / 30.0)
    return ship_deg + 0.1 * np.sin(3.7 * k), ship_deg + 0.02 * np.sin(2.9 * k)


def of_twist(ns, heading_deg):
    """Return a message of another program with a heading in one of its fields."""
    return encode(TWIST, {'header': {'stamp': {'sec': ns // S, 'nanosec': ns % S}, 'frame_id': ''},
                          'twist': {'linear': {}, 'angular': {'z': heading_deg}}})


def compare(capsys, tmp_path, inputs, names=(), options=()):
    """Return the verdict on an import, after a check that it is that on the inputs."""
    bag = str(tmp_path / 'imported')
    capsys.readouterr()
    assert main(['import', *map(str, [*inputs, *names, *options]), '-o', bag, '--quiet']) == 0
    of_input, _ = analyze_json(capsys, *inputs, *names, *options)
    of_bag, _ = analyze_json(capsys, bag, *options)
    assert of_bag['headline'] == of_input['headline']
    assert len(of_bag['runs']) == len(of_input['runs'])
    for run, run_of_input in zip(of_bag['runs'], of_input['runs']):
        for name in ('n', 'start_ns', 'pairing'):
            assert run[name] == run_of_input[name], name
        for name in ('variance_deg2', 'mean_deg', 'max_deg'):
            assert run[name] == pytest.approx(run_of_input[name], rel=1e-6, abs=1e-9), name
    return of_bag


@pytest.fixture
def foreign_bag(tmp_path):
    """Return a bag with a field of a foreign type, an Imu, marks, losses and a note."""
    ts_deg, rs_deg = two_headings()
    with BagWriter(tmp_path / 'foreign') as bag:
        bag.metadata(RECORD, {'version': 'x'})
        Notes(bag.metadata).add('2023-11-14T22:15:00Z the helmsman changes', 0)
        bag.add_topic('/gyro', TWIST)
        bag.add_topic('/ins/imu', IMU)
        bag.add_topic('/ins/imu/lost', STATUS_TYPE)
        bag.add_topic(MARKER_TOPIC, STATUS_TYPE)
        imu = encode_imu(Headings.of(T0 + np.arange(N) * S, rs_deg), 'ins')
        for k in range(N):
            ns = T0 + k * S
            if k in (100, 1000):
                bag.write(MARKER_TOPIC, encode_mark('start' if k == 100 else 'stop', ns), ns)
            if k == 500:
                bag.write('/ins/imu/lost', encode_losses(
                    {'lost.at_source': Losses.of([ns], [ns - S], [3])}), ns)
            if not 300 <= k < 340:
                bag.write('/gyro', of_twist(ns, ts_deg[k]), ns, sequence=k + 1)
            bag.write('/ins/imu', imu[k].tobytes(), ns, sequence=k + 1)
    return tmp_path / 'foreign'


def test_a_bag_of_topics_of_other_programs_is_imported_with_all_that_counts(
        foreign_bag, tmp_path, capsys):
    verdict = compare(capsys, tmp_path, [foreign_bag],
                      ['--ts', '/gyro.twist.angular.z@deg', '--rs', '/ins/imu'],
                      ['--set', 'runs.min_duration_s=60'])
    assert verdict['runs'][0]['pairing']['lost'] == {
        'ts': {'on_the_way': 40}, 'rs': {'at_source': 3}}
    imported = BagReader(tmp_path / 'imported')
    assert imported.topics['/compliance/marker'].count == 2
    assert [note.text for note in read_notes(imported)] == ['the helmsman changes']
    record = imported.metadata()[RECORD]
    assert record['source.recording.format'] == 'rosbag2, MCAP'
    assert record['settings.ts_topic'] == 'ts/heading'
    assert record['source.recording.topic.ts'] == '/gyro.twist.angular.z@deg'


def test_axes_that_the_settings_state_hold_for_the_bag_too(foreign_bag, tmp_path, capsys):
    """The bag had ENU in it whatever its settings said, so the heading was mirrored."""
    verdict = compare(capsys, tmp_path, [foreign_bag],
                      ['--ts', '/gyro.twist.angular.z@deg', '--rs', '/ins/imu'],
                      ['--set', 'rs_convention=ned', '--set', 'ts_convention=ned'])
    assert verdict['settings']['rs_convention'] == 'ned'


def test_a_field_in_a_row_of_sensors_gets_a_topic_of_its_own(foreign_bag, tmp_path, capsys):
    rows = 'gyro {}sigma_max_deg=0.3; ins topic=/ins/imu sigma_max_deg=0.1 rs'
    read = rows.format('topic=/gyro.twist.angular.z ')
    bag = str(tmp_path / 'imported')
    assert main(['import', str(foreign_bag), '--set', f'sensors={read}', '-o', bag]) == 0
    out = capsys.readouterr().out
    assert '/foreign: 1160 headings on gyro/heading' in out
    assert '/foreign: 1200 headings on /ins/imu' in out
    headlines = []
    for path, table in ((foreign_bag, read), (bag, rows.format(''))):
        assert main(['analyze', str(path), '--set', f'sensors={table}', '--json', '-']) == 0
        headlines.append(json.loads(capsys.readouterr().out)['headline'])
    assert headlines[0] == headlines[1]


def test_a_clock_that_is_set_back_gives_the_same_runs(tmp_path, capsys):
    ts_deg, rs_deg = two_headings()
    seconds = np.arange(N) - np.where(np.arange(N) < 700, 0, 600)
    rows = [f'{utc(T0 + int(at) * S)},{a:.6f},{b:.6f}\n'
            for at, a, b in zip(seconds, ts_deg, rs_deg)]
    table = tmp_path / 'set_back.csv'
    table.write_text('time,A,B\n' + ''.join(rows))
    verdict = compare(capsys, tmp_path, [table], ['--ts', 'A', '--rs', 'B'])
    assert len(verdict['runs']) == 2


def test_a_log_of_gpsd_is_imported(tmp_path, capsys):
    log = tmp_path / 'gpsd.json'
    log.write_text(''.join(json.dumps({
        'class': 'ATT', 'device': device, 'time': utc(T0 + k * S).replace(' ', 'T') + 'Z',
        'heading': round(float(heading_deg), 4)}) + '\n' for k in range(N)
        for device, heading_deg in zip(('/dev/gyro', '/dev/ins'), (x[k] for x in two_headings()))))
    verdict = compare(capsys, tmp_path, [log], ['--ts', '/dev/gyro', '--rs', '/dev/ins'])
    assert verdict['runs'][0]['n'] == N


@pytest.mark.parametrize('options', [
    ['--time-column', 'uhr'], ['--time-column', 'uhr', '--stamp-zone', '+02:00']])
def test_options_of_tables_hold_and_radians_are_turned_to_degrees(tmp_path, capsys, options):
    table = tmp_path / 'radians.csv'
    table.write_text('uhr;A;B\n' + ''.join(
        f'{(datetime(2024, 5, 28, 20) + timedelta(seconds=k)):%d.%m.%Y %H:%M:%S};'
        + ';'.join(f'{math.radians(x[k]):.8f}'.replace('.', ',') for x in two_headings()) + '\n'
        for k in range(N)))
    verdict = compare(capsys, tmp_path, [table], ['--ts', 'A', '--rs', 'B', *options], [
        '--ts-unit', 'rad', '--rs-unit', 'rad'])
    assert verdict['runs'][0]['n'] == N


def test_what_is_no_recording_of_headings_is_one_line(foreign_bag, tmp_path, capsys):
    pairs = tmp_path / 'pairs.csv'
    pairs.write_text('stamp_s,ts_deg,rs_deg\n1700000000.0,10.0,10.1\n')
    end = ('-o', tmp_path / 'imported')
    assert refusal(capsys, 'import', pairs, *end) == (
        f'{pairs}: holds pairs, and a bag holds headings: give it to analyze')
    assert refusal(capsys, 'import', foreign_bag, foreign_bag, *end).endswith(
        'is a second recording, and a bag is made of one; import each by itself')
    assert "has no topic 'ts/heading'" in refusal(capsys, 'import', foreign_bag, *end)
    assert '--motion x: is for logs' in refusal(
        capsys, 'import', foreign_bag, '--ts', 'a', '--rs', 'b', '--motion', 'x', *end)
    assert not (tmp_path / 'imported').exists()
