# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Roll and pitch in whole logs."""

from __future__ import annotations

from checksums import with_checksum
import pytest

from heading_intercompare.drivers.motion.attitude_log import read_log_attitude
from heading_intercompare.drivers.settings import DriverError, DriverSettings

S = 10 ** 9
START_NS = 1_714_521_600 * S


def write(path, bodies):
    """Write a sentence a second."""
    path.write_text(''.join(f'2024-05-01T00:00:{k:02d}.500Z {with_checksum(body)}\r\n'
                            for k, body in enumerate(bodies)), encoding='ascii')
    return str(path)


def test_psxn_comes_before_pashr(tmp_path):
    """Roll and pitch of PSXN,23; the mean of other sentences is not taken."""
    log = write(tmp_path / 'a.log', ['PSXN,23,0.35,-1.74,218.26,0.58', 'PSXN,20,1,0,0,0',
                                     'PASHR,000002.00,218.1,T,9.9,9.9,0.1,0.0,0.0,0.0,1,1',
                                     'PSXN,23,-0.40,1.00,218.00,0.10'])
    found = read_log_attitude(log)
    assert found.sentence == 'PSXN,23'
    assert found.rows.stamp_ns.tolist() == [START_NS + S // 2, START_NS + 3 * S + S // 2]
    assert found.rows.roll_deg.tolist() == [0.35, -0.40]
    assert found.rows.pitch_deg.tolist() == [-1.74, 1.00]


def test_pashr_without_psxn(tmp_path):
    log = write(tmp_path / 'a.log', ['PASHR,000000.00,218.1,T,-3.25,1.5,0.1,0.0,0.0,0.0,1,1'])
    found = read_log_attitude(log)
    assert (found.sentence, found.rows.roll_deg.tolist(), found.rows.pitch_deg.tolist()) == (
        'PASHR', [-3.25], [1.5])


def test_what_is_no_angle_is_counted(tmp_path):
    log = write(tmp_path / 'a.log', ['PSXN,23,0.35,,218.26,0.58', 'PSXN,23,95.0,0.0,218.26,0.5',
                                     'PSXN,23,1.0,2.0,218.00,0.1', 'PSXN,23,nan,2.0,218.0,0.1'])
    found = read_log_attitude(log)
    assert len(found.rows) == 1 and found.not_taken == {'bad_field': 3}


@pytest.mark.parametrize('text', ['', '2024-05-01T00:00:00Z $HEHDT,1.0,T*28\r\n',
                                  't_ns,heading_deg\n1,2\n'])
def test_a_log_without_angles(tmp_path, text):
    path = tmp_path / 'a.log'
    path.write_text(text, encoding='ascii')
    try:
        assert not len(read_log_attitude(path).rows)
    except DriverError:
        assert not text


def test_sentences_without_a_stamp_are_counted(tmp_path):
    path = tmp_path / 'a.log'
    path.write_text(with_checksum('PSXN,23,1.0,2.0,218.00,0.1') + '\r\n', encoding='ascii')
    assert not len(read_log_attitude(path, DriverSettings()).rows)
