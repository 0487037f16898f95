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

"""The motion and the attitude of the ship in whole logs."""

from __future__ import annotations

from checksums import with_checksum
import pytest

from heading_intercompare.drivers.motion.motion_log import (
    LoggedMotion,
    read_log_attitude,
    read_log_motion,
)
from heading_intercompare.drivers.settings import DriverError, DriverSettings

S = 10 ** 9
VTG = 'VTG,90.0,T,,M,10.0,N,18.5,K,A'
RMC = 'RMC,{0:06d}.00,A,5400.0,N,01000.0,E,10.0,91.0,010524,,'
START_NS = 1_714_521_600 * S


def sentence(body):
    """Return a sentence with its checksum."""
    return with_checksum(body)


def write(path, rows, *, stamped=True):
    """Write sentences, one second apart; each second may hold several."""
    with open(path, 'w', encoding='ascii') as file:
        for second, bodies in enumerate(rows):
            for body in bodies:
                stamp = f'2024-05-01T00:00:{second:02d}.500Z ' if stamped else ''
                file.write(f'{stamp}{sentence(body.format(second))}\r\n')
    return str(path)


def test_a_log_tells_position_course_and_rate(tmp_path):
    log = write(tmp_path / 'a.log', [['HEHDT,1.0,T', f'GP{VTG}', f'GP{RMC}', 'HEROT,6.0,A']] * 5)
    found = read_log_motion(log)
    assert found.sentences == {'fix': 'GPRMC', 'velocity': 'GPVTG', 'rate': 'HEROT'}
    assert found.rows['velocity'].stamp_ns.tolist() == [
        START_NS + k * S + S // 2 for k in range(5)]
    assert found.rows['velocity'].course_deg == pytest.approx([90.0] * 5)
    assert found.rows['rate'].rate_deg_s.tolist() == [0.1] * 5
    assert found.rows['fix'].latitude_deg.tolist() == [54.0] * 5
    assert found.not_taken == {}


@pytest.mark.parametrize('kinds, what, best', [
    (['GPRMC', 'GPVTG'], 'velocity', 'GPVTG'), (['GPRMC'], 'velocity', 'GPRMC'),
    (['GPGLL', 'GPRMC', 'GPGGA'], 'fix', 'GPGGA'),
    (['GPGLL', 'INGGA', 'GPGGA'], 'fix', 'INGGA')])
def test_the_best_kind_and_the_first_talker_are_taken(tmp_path, kinds, what, best):
    bodies = {'VTG': VTG, 'RMC': RMC, 'GLL': 'GLL,5400.0,N,01000.0,E,{0:06d},A',
              'GGA': 'GGA,{0:06d},5400.0,N,01000.0,E,1,9,1.0,3.0,M,,,,'}
    log = write(tmp_path / 'a.log', [[kind[:2] + bodies[kind[2:]] for kind in kinds]] * 3)
    assert read_log_motion(log).sentences[what] == best


def test_times_of_validity_are_those_of_the_sentences(tmp_path):
    log = write(tmp_path / 'a.log', [[f'GP{RMC}', f'GP{VTG}']] * 4, stamped=False)
    found = read_log_motion(log, DriverSettings(time='validity'))
    assert found.rows['velocity'].stamp_ns.tolist() == [START_NS + k * S for k in range(4)]
    bare = read_log_motion(log)
    assert bare.rows == {} and bare.not_taken == {'no_stamp': 8}


def test_a_position_takes_the_time_of_its_own_sentence(tmp_path):
    """A ZDA may come after the position of its second, or before it."""
    zda, gga = 'GPZDA,{0:06d}.00,01,05,2024,,', 'GPGGA,{0:06d}.25,5400.0,N,01000.0,E,1,9,1.0,3.0,M'
    for name, order in (('a.log', [zda, gga]), ('b.log', [gga, zda])):
        log = write(tmp_path / name, [order] * 4, stamped=False)
        stamps = read_log_motion(log, DriverSettings(time='validity')).rows['fix'].stamp_ns
        assert stamps.tolist() == [START_NS + k * S + S // 4 for k in range(4)]


def test_a_line_without_a_stamp_takes_that_of_the_last_line_with_one(tmp_path):
    path = tmp_path / 'a.log'
    path.write_text(f'2024-05-01T00:00:00Z {sentence("HEHDT,1.0,T")}\n{sentence("GP" + VTG)}\n')
    assert read_log_motion(path).rows['velocity'].stamp_ns.tolist() == [START_NS]


def test_what_is_not_taken_is_counted(tmp_path):
    path = tmp_path / 'a.log'
    path.write_text(f'2024-05-01T00:00:00Z $GP{VTG}\n'
                    f'2024-05-01T00:00:01Z {sentence("GPVTG,,T,,M,,N,,K,N")}\n')
    assert read_log_motion(path).not_taken == {'GPVTG.invalid_mode': 1, 'no_checksum': 1}
    taken = read_log_motion(path, DriverSettings(checksum='if_present'))
    assert len(taken.rows['velocity']) == 1


@pytest.mark.parametrize('text', ['stamp,heading_deg\n1,2\n', '', 'nothing\n',
                                  f'2024-05-01T00:00:00Z {sentence("HEHDT,1.0,T")}\n'])
def test_a_log_without_motion_has_none(tmp_path, text):
    path = tmp_path / 'a.log'
    path.write_text(text)
    assert read_log_motion(path) == LoggedMotion()


def test_a_log_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(OSError):
        read_log_motion(tmp_path / 'none.log')
    with pytest.raises(DriverError, match='no file'):
        read_log_motion(str(tmp_path / '*.log'))


def test_real_logs(shared_data):
    """Counts by grep; the Gould has no VTG."""
    palmer = read_log_motion(shared_data / 'nbp1406' / 'NBP1406_s330-2014-08-01')
    assert palmer.sentences == {'fix': 'INGGA', 'velocity': 'INVTG'}
    assert {what: len(rows) for what, rows in palmer.rows.items()} == {
        'fix': 625, 'velocity': 625}
    gould = read_log_motion(shared_data / 'lmg1903' / 'LMG1903_lsep.d085')
    assert gould.sentences['velocity'] == 'INRMC' and len(gould.rows['velocity']) == 2000
    zeus = read_log_motion(shared_data / 'gpsd' / 'bundg_zeus_9.log',
                           DriverSettings(time='validity'))
    assert zeus.sentences['velocity'] == 'GPVTG' and len(zeus.rows['velocity']) == 147
    start_up = read_log_motion(shared_data / 'gpsd' / 'hemi.log', DriverSettings(time='validity'))
    assert start_up.not_taken['GPVTG.invalid_mode'] == 193


def write_attitude(path, bodies):
    """Write a sentence a second."""
    return write(path, [[body] for body in bodies])


def test_psxn_comes_before_pashr(tmp_path):
    """Roll and pitch of PSXN,23; the mean of other sentences is not taken."""
    log = write_attitude(tmp_path / 'a.log', [
        'PSXN,23,0.35,-1.74,218.26,0.58', 'PSXN,20,1,0,0,0',
        'PASHR,000002.00,218.1,T,9.9,9.9,0.1,0.0,0.0,0.0,1,1', 'PSXN,23,-0.40,1.00,218.00,0.10'])
    attitude = read_log_attitude(log)
    assert attitude.stamp_ns.tolist() == [START_NS + S // 2, START_NS + 3 * S + S // 2]
    assert attitude.roll_deg.tolist() == [0.35, -0.40]
    assert attitude.pitch_deg.tolist() == [-1.74, 1.00]


def test_pashr_without_psxn(tmp_path):
    log = write_attitude(tmp_path / 'a.log',
                         ['PASHR,000000.00,218.1,T,-3.25,1.5,0.1,0.0,0.0,0.0,1,1'])
    attitude = read_log_attitude(log)
    assert (attitude.roll_deg.tolist(), attitude.pitch_deg.tolist()) == ([-3.25], [1.5])


def test_pashr_att_has_another_order_and_is_not_read(tmp_path):
    log = write_attitude(tmp_path / 'a.log', ['PASHR,ATT,0.0,218.1,1.5,-3.25,0.01,0.02,0'])
    assert not len(read_log_attitude(log))


def test_what_is_no_angle_is_left_out(tmp_path):
    log = write_attitude(tmp_path / 'a.log', [
        'PSXN,23,0.35,,218.26,0.58', 'PSXN,23,95.0,0.0,218.26,0.5',
        'PSXN,23,1.0,2.0,218.00,0.1', 'PSXN,23,nan,2.0,218.0,0.1'])
    assert read_log_attitude(log).roll_deg.tolist() == [1.0]


@pytest.mark.parametrize('text', ['', '2024-05-01T00:00:00Z $HEHDT,1.0,T*28\r\n',
                                  't_ns,heading_deg\n1,2\n',
                                  sentence('PSXN,23,1.0,2.0,218.00,0.1') + '\r\n'])
def test_a_log_without_angles_or_stamps(tmp_path, text):
    path = tmp_path / 'a.log'
    path.write_text(text, encoding='ascii')
    try:
        assert not len(read_log_attitude(path))
    except DriverError:
        assert not text
