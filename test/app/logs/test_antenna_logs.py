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

"""Two antennas as the RS: from logs of their receivers, and from topics of a bag."""

from __future__ import annotations

from functools import partial
import math

from checksums import with_checksum
import command_line
import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.cli import main
from heading_intercompare.core.motion.tangent_plane import radii_m
from heading_intercompare.core.records import Headings, Motion
from heading_intercompare.messages.heading_messages import encode_imu
from heading_intercompare.messages.motion.motion_messages import encode_motion, FIX

N, S, LENGTH_M = 900, 10 ** 9, 20.0
START_NS = 1_714_564_800 * S
NORMS = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.2']
analyze_json = partial(command_line.analyze_json, norms=NORMS)
HEADING = 100.0 + 20.0 * np.sin(np.arange(N) / 60.0)


def positions(rng):
    """Return latitudes and longitudes of the fore and the aft antenna, 2 cm of noise."""
    meridian, normal = radii_m(54.0)
    t, found = np.arange(N), []
    for length in (LENGTH_M, 0.0):
        east = 3.5 * t + length * np.sin(np.radians(HEADING)) + 0.02 * rng.standard_normal(N)
        north = -0.6 * t + length * np.cos(np.radians(HEADING)) + 0.02 * rng.standard_normal(N)
        found.append((54.0 + np.degrees(north / meridian),
                      10.0 + np.degrees(east / normal / math.cos(math.radians(54.0)))))
    return found


def line(second, body):
    """Return a line of a log from noon on."""
    return f'2024-05-01T12:{second // 60:02d}:{second % 60:02d}Z {with_checksum(body)}\n'


def angle(value, digits, sides):
    """Return an angle as NMEA writes it, with its side."""
    whole, minutes = divmod(abs(value), 1.0)
    return f'{int(whole):0{digits}d}{60.0 * minutes:010.7f},{sides[int(value < 0.0)]}'


@pytest.fixture
def logs(tmp_path, rng):
    """Return the log of a TS with 0.1 deg, and those of the two antennas."""
    ts = HEADING + 0.1 * rng.standard_normal(N)
    paths = [tmp_path / name for name in ('gyro.log', 'fore.log', 'aft.log')]
    paths[0].write_text(''.join(line(k, f'HEHDT,{one:.2f},T') for k, one in enumerate(ts)))
    for path, (latitude, longitude) in zip(paths[1:], positions(rng)):
        path.write_text(''.join(
            line(k, f'GPGGA,{120000 + k // 60 * 100 + k % 60:06d}.00,'
                 f'{angle(latitude[k], 2, "NS")},{angle(longitude[k], 3, "EW")},4,9,1.0,3.0,M,,,,')
            for k in range(N)))
    return [str(path) for path in paths]


def test_two_logs_of_positions_are_an_rs(logs, capsys):
    """2 cm in each direction: sqrt(2) 0.02 / 20 rad = 0.081 deg."""
    ts, fore, aft = logs
    verdict, notes = analyze_json(capsys, ts, '--rs-antennas', fore, aft)
    run = verdict['runs'][0]
    assert verdict['outcome'] == 'compliant' and run['n'] == N
    assert run['std_deg'] == pytest.approx(math.hypot(0.1, 0.081), rel=0.1)
    assert abs(run['mean_deg']) < 0.02
    assert verdict['inputs'][1]['path'] == f'{fore} and {aft}'
    assert verdict['inputs'][1]['rs_topic'] == 'GPGGA - GPGGA'
    said = next(note for note in notes if 'reference sensor' in note)
    assert f'{N} headings of GPGGA - GPGGA' in said and 'baseline of 20.00 m, which' in said
    assert 'standard uncertainty of a heading 0.08' in said
    # Each antenna also tells the motion of the ship.
    assert run['motion']['kind'] == 'agrees'


def test_length_and_angle_of_the_baseline_are_options(logs, capsys):
    ts, fore, aft = logs
    verdict, _ = analyze_json(capsys, ts, '--rs-antennas', fore, aft, '--baseline-m', '20',
                            '--baseline-angle', '5')
    assert verdict['runs'][0]['mean_deg'] == pytest.approx(-5.0, abs=0.02)
    assert verdict['settings']['antennas.baseline_m'] == 20.0
    wrong = ['analyze', ts, *NORMS, '--rs-antennas', fore, aft, '--baseline-m', '30']
    assert main(wrong) == 2
    assert capsys.readouterr().err.count('\n') == 1


def test_exchanged_antennas_turn_the_rs_round_and_the_course_says_so(logs, capsys):
    ts, fore, aft = logs
    gps = fore.replace('fore', 'gps')
    with open(gps, 'w', encoding='ascii') as file:
        file.write(''.join(line(k, f'GPVTG,{one:.1f},T,,M,9.0,N,,K,A')
                           for k, one in enumerate(np.full(N, 100.0))))
    verdict, _ = analyze_json(capsys, ts, '--rs-antennas', aft, fore, '--motion', gps,
                            '--set', 'motion.current_max_kn=1')
    assert 'the RS points' in verdict['headline'] and 'VOID' in verdict['headline']


def test_an_import_gives_the_verdict_of_the_logs(logs, tmp_path, capsys):
    ts, fore, aft = logs
    options = ['--baseline-angle', '5', '--baseline-m', '20']
    of_logs, _ = analyze_json(capsys, ts, '--rs-antennas', fore, aft, *options)
    bag = str(tmp_path / 'imported')
    assert main(['import-nmea', '--ts', ts, '--rs-antennas', fore, aft, *options, '-o', bag]) == 0
    assert 'baseline of 20.00 m' in capsys.readouterr().out
    of_bag, _ = analyze_json(capsys, bag)
    assert of_bag['headline'] == of_logs['headline']
    (one,), (other,) = of_bag['runs'], of_logs['runs']
    assert one['n'] == other['n'] == N
    assert one['motion'] == other['motion']
    for figure in ('mean_deg', 'std_deg', 'variance_deg2'):
        assert one[figure] == pytest.approx(other[figure], rel=1e-9)


@pytest.mark.parametrize('more, why', [
    (['--ts', 'ts.log', '--rs', 'rs.log'], '--rs-antennas {} {}: rs.log is another log'),
    (['gyro=gyro.log'], 'gyro=gyro.log: No such file'),
    (['{}', '{}'], 'is one of 3 logs')])
def test_an_import_takes_the_antennas_or_another_rs(logs, tmp_path, capsys, more, why):
    ts, fore, aft = logs
    assert main(['import', *(text.format(ts) for text in more), '--rs-antennas', fore, aft, '-o',
                 str(tmp_path / 'b')]) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1 and why.format(fore, aft) in error


def test_a_log_without_positions_is_refused_in_one_line(logs, capsys):
    ts, fore, _ = logs
    assert main(['analyze', ts, *NORMS, '--rs-antennas', fore, ts]) == 2
    assert capsys.readouterr().err == (
        f'heading-intercompare: error: {ts}: has no position: no GNS, GGA, RMC or GLL with a '
        'stamp\n')


def test_a_bag_with_two_fixes_gives_the_same(logs, tmp_path, rng, capsys):
    ts = Headings.of(START_NS + np.arange(N) * S, HEADING + 0.1 * rng.standard_normal(N))
    with BagWriter(tmp_path / 'bag') as writer:
        writer.add_topic('ts/heading', 'sensor_msgs/msg/Imu')
        writer.write_rows([Rows('ts/heading', encode_imu(ts, 'ts'), ts.stamp_ns)])
        for topic, (latitude, longitude) in zip(('gps/fore', 'gps/aft'), positions(rng)):
            writer.add_topic(topic, FIX)
            rows = Motion.of_positions(ts.stamp_ns, latitude, longitude)
            writer.write_rows([Rows(topic, encode_motion(rows, 'fix', 'gps'), ts.stamp_ns)])
    verdict, notes = analyze_json(
        capsys, tmp_path / 'bag', '--set', 'antennas.fore_topic=gps/fore',
        '--set', 'antennas.aft_topic=gps/aft')
    assert verdict['outcome'] == 'compliant' and verdict['runs'][0]['n'] == N
    assert verdict['inputs'][0]['rs_topic'] == 'gps/fore - gps/aft'
    assert verdict['ledger_complete'] is True
    assert any('900 headings of two antennas, baseline of 20.00 m' in note for note in notes)
    assert main(['analyze', str(tmp_path / 'bag'), *NORMS, '--set', 'antennas.fore_topic=gps/x',
                 '--set', 'antennas.aft_topic=gps/aft']) == 2
    assert "has no topic 'gps/x'" in capsys.readouterr().err
