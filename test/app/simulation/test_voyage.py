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

"""Recorded voyages, read from every kind of file."""

from __future__ import annotations

import math
from pathlib import Path

from checksums import with_checksum
import numpy as np
import pytest

from heading_intercompare.ahrs.settings import TrackSettings
from heading_intercompare.app.simulation.voyage import read_voyage
from heading_intercompare.cli import main
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.utc_text import utc

SHARED = Path(__file__).resolve().parents[4] / 'shared' / 'data' / 'nbp1406'
T_S = np.arange(0.0, 90.0, 0.5)
START_NS = 1_714_521_600 * 10**9
TURN = 80.0 + 40.0 * np.sin(T_S / 20.0)


def stamp(t_s):
    """Return a time as the logs write it."""
    return f'{utc(START_NS + round(t_s * 1e9))}Z'.replace(' ', 'T')


def write_csv(path):
    """Write a csv with everything that a ship may tell."""
    rows = ['utc,heading_deg,lat,lon,cog_deg,sog_kn,roll_deg,pitch_deg']
    rows += [f'{stamp(t)},{psi % 360.0:.4f},{54.0 + 1e-5 * t:.7f},10.0,0.0,4.0,'
             f'{2.0 * math.sin(t):.4f},{math.cos(t):.4f}' for t, psi in zip(T_S, TURN)]
    path.write_text('\n'.join(rows) + '\n', encoding='ascii')
    return path


def write_log(path):
    """Write a log of NMEA sentences with the same."""
    rows = []
    for t, psi in zip(T_S, TURN):
        rows += [f'{stamp(t)} {with_checksum(body)}' for body in (
            f'HEHDT,{psi % 360.0:.3f},T', 'GPVTG,0.0,T,,M,4.0,N,7.4,K,A',
            f'GPGGA,000000.00,54{6e-4 * t:07.4f},N,01000.0000,E,1,12,0.7,1.0,M,1.0,M,,',
            f'PSXN,23,{2.0 * math.sin(t):.3f},{math.cos(t):.3f},{psi % 360.0:.3f},0.1')]
    path.write_text('\r\n'.join(rows) + '\r\n', encoding='ascii')
    return path


@pytest.mark.parametrize('write, name', [(write_csv, 'a.csv'), (write_log, 'a.log')])
def test_a_file_tells_all_that_a_ship_may_tell(tmp_path, write, name):
    path = write(tmp_path / name)
    voyage = read_voyage(TrackSettings(file=name), tmp_path)
    track, at = voyage.track, np.linspace(5.0, 85.0, 99)
    off = wrap180(np.degrees(track.heading_rad.read(at)) - (80.0 + 40.0 * np.sin(at / 20.0)))
    assert np.abs(off).max() < 0.01
    assert track.start_ns == START_NS
    assert track.north_m_s.read(at) == pytest.approx(np.full(99, 4.0 * 1852.0 / 3600.0), abs=1e-3)
    assert track.position_deg == pytest.approx((54.0, 10.0), abs=1e-6)
    assert np.degrees(track.roll_rad.read(at)) == pytest.approx(2.0 * np.sin(at), abs=0.05)
    assert np.degrees(track.pitch_rad.read(at)) == pytest.approx(np.cos(at), abs=0.03)
    assert voyage.words[0].endswith(f' of {path}, 89.5 s')
    assert len(voyage.words) == 7 and len(voyage.origin['sha256']) == 64


def test_the_motion_may_stand_in_another_file(tmp_path):
    write_csv(tmp_path / 'motion.csv')
    lines = [f'{stamp(t)} {with_checksum(f"HEHDT,{psi % 360.0:.3f},T")}'
             for t, psi in zip(T_S, TURN)]
    (tmp_path / 'gyro.log').write_text('\r\n'.join(lines) + '\r\n', encoding='ascii')
    voyage = read_voyage(TrackSettings(file='gyro.log', motion_file='motion.csv'), tmp_path)
    assert voyage.track.roll_rad is not None
    assert voyage.track.north_m_s.read(np.array([40.0]))[0] == pytest.approx(2.058, abs=1e-3)
    assert set(voyage.origin) == {'file', 'heading', 'sha256', 'motion_file', 'motion_sha256'}


@pytest.mark.parametrize('head', ['utc,heading', 'utc,speed_kn'])
def test_a_file_without_headings_offers_no_choice(tmp_path, head):
    path = tmp_path / 'none.csv'
    path.write_text(f'{head}\n', encoding='ascii')
    with pytest.raises(ValueError, match=r'none.csv: has no headings$'):
        read_voyage(TrackSettings(file='none.csv'), tmp_path)


def test_a_file_of_several_sensors_needs_a_choice(tmp_path):
    path = tmp_path / 'two.csv'
    path.write_text('utc,gyro_heading,gnss_heading\n' + ''.join(
        f'{stamp(t)},{t},{t + 1.0}\n' for t in range(30)), encoding='ascii')
    with pytest.raises(ValueError, match=r'two.csv: has headings of several sensors; it has '
                       r'gyro_heading, gnss_heading; choose with track.heading'):
        read_voyage(TrackSettings(file='two.csv'), tmp_path)
    with pytest.raises(ValueError, match="has no headings 'sun'; it has gyro_heading"):
        read_voyage(TrackSettings(file='two.csv', heading='sun'), tmp_path)
    track = read_voyage(TrackSettings(file='two.csv', heading='gnss_heading'), tmp_path).track
    assert math.degrees(track.heading_rad.read(np.array([10.0]))[0]) == pytest.approx(11.0)


def test_a_log_in_several_files(tmp_path):
    """The log of `write_log`, cut in two; a pattern names both."""
    lines = write_log(tmp_path / 'whole.log').read_text(encoding='ascii').splitlines(True)
    for name, part in (('day1.log', lines[:400]), ('day2.log', lines[400:])):
        (tmp_path / name).write_text(''.join(part), encoding='ascii')
    whole = read_voyage(TrackSettings(file='whole.log'), tmp_path)
    parts = read_voyage(TrackSettings(file='day*.log'), tmp_path)
    at = np.linspace(0.0, 89.0, 99)
    assert parts.track.heading_rad.read(at).tolist() == whole.track.heading_rad.read(at).tolist()
    assert parts.track.roll_rad.read(at).tolist() == whole.track.roll_rad.read(at).tolist()


def test_a_file_that_is_absent(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_voyage(TrackSettings(file='none.csv'), tmp_path)


@pytest.mark.skipif(not SHARED.is_dir(), reason='the logs of a real ship are not here')
def test_a_real_ship(tmp_path):
    """Ten minutes in the swell of the South Atlantic at 9 knots, with outliers and bursts."""
    voyage = read_voyage(TrackSettings(file=str(SHARED / 'NBP1406_s330-2014-08-01')))
    track, t_s = voyage.track, np.arange(10.0, 610.0, 0.1)
    assert track.duration_s == pytest.approx(624.0, abs=1.0)
    speed = np.hypot(track.east_m_s.read(t_s), track.north_m_s.read(t_s)) * 3600.0 / 1852.0
    assert 8.5 < speed.min() and speed.max() < 10.5
    push = np.hypot(track.east_m_s.read(t_s, 1), track.north_m_s.read(t_s, 1))
    assert push.max() < 0.05
    assert np.degrees(np.abs(track.heading_rad.read(t_s, 1))).max() < 1.0
    assert 'stays within' in voyage.words[-1]
    assert int(voyage.words[-1].split()[-5]) < 30


def test_simulate_says_what_became_of_a_voyage(tmp_path, capsys):
    """The trial ends with the record, and begins at its stamps."""
    path = write_csv(tmp_path / 'a.csv')
    assert main(['simulate', '--scenario', 'real_track', '--track', str(path), '-o',
                 str(tmp_path / 'bag')]) == 0
    out = capsys.readouterr().out
    assert 'real_track.yaml: 89.5 s' in out
    assert 'heading: 180 samples; smoothed over 3 s' in out
    assert main(['info', str(tmp_path / 'bag')]) == 0


@pytest.mark.parametrize('words, told', [
    (['--track', 'absent.csv'], 'absent.csv'),
    (['--track-heading', 'x'], '--track-heading: needs a voyage; give its file with --track')])
def test_a_mistake_is_one_line(tmp_path, capsys, monkeypatch, words, told):
    monkeypatch.chdir(tmp_path)
    assert main(['simulate', '--scenario', 'real_track', *words, '-o', 'bag']) == 2
    error = capsys.readouterr().err
    assert told in error and len(error.strip().splitlines()) == 1
