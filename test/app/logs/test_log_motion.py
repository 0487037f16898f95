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

"""The choice of the log that tells the motion of the ship."""

from __future__ import annotations

import json
import math

from checksums import with_checksum
import pytest

from heading_intercompare.app.logs.log_motion import find_motion
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.readers.json_lines import read_signalk

DRIVERS = dict.fromkeys(('ts', 'rs', 'motion'), DriverSettings())
BODIES = {'HDT': 'HEHDT,1.0,T', 'VTG': 'GPVTG,90.0,T,,M,10.0,N', 'ROT': 'HEROT,6.0,A',
          'GLL': 'GPGLL,5400.0,N,01000.0,E,000000,A'}


@pytest.fixture
def log(tmp_path):
    """Return a function that writes a log with some kinds of sentences."""
    def write(name, *kinds, n=3):
        path = tmp_path / name
        lines = [f'2024-05-01T00:00:{k:02d}Z {with_checksum(body)}\n'
                 for k in range(n) for body in (BODIES[kind] for kind in kinds)]
        path.write_text(''.join(lines))
        return str(path)
    return write


def test_each_part_comes_from_the_rs_or_else_from_the_ts(log):
    ts, rs = log('ts', 'HDT', 'ROT', 'VTG', n=5), log('rs', 'HDT', 'VTG', 'GLL')
    found = find_motion({'ts': ts, 'rs': rs}, DRIVERS)
    assert [len(part()) for part in (found.rows.positions, found.rows.velocities,
                                     found.rows.rates)] == [3, 3, 5]
    assert found.notes == (
        f'motion of the ship: positions of GPGLL in {rs} (3), course and speed of GPVTG in {rs} '
        f'(3), rate of turn of HEROT in {ts} (5); not used: course and speed of GPVTG in {ts}',)
    assert found.origin == {'position': f'GPGLL {rs}', 'course': f'GPVTG {rs}',
                            'rate': f'HEROT {ts}'}


def test_a_log_of_its_own_is_the_only_one(log):
    ts, rs, own = log('ts', 'HDT', 'ROT'), log('rs', 'HDT', 'VTG'), log('own', 'GLL', n=7)
    found = find_motion({'ts': ts, 'rs': rs}, DRIVERS, own)
    assert len(found.rows) == 7 and found.origin == {'position': f'GPGLL {own}'}


def test_a_log_of_its_own_must_tell_something(log):
    ts, own = log('ts', 'HDT'), log('own', 'HDT')
    with pytest.raises(DriverError, match=f'{own}: has no motion of the ship: no VTG, RMC'):
        find_motion({'ts': ts, 'rs': ts}, DRIVERS, own)


def test_a_file_of_another_form_tells_no_motion(log, tmp_path):
    ts, streams = log('ts', 'HDT'), tmp_path / 'nav.csv'
    streams.write_text('utc,heading_gyro,heading_gps\n2024-05-01T00:00:00Z,1.0,2.0\n')
    assert len(find_motion({'ts': str(streams), 'rs': ts}, DRIVERS).rows) == 0
    with pytest.raises(DriverError, match='has no motion of the ship'):
        find_motion({'ts': ts, 'rs': ts}, DRIVERS, str(streams))


def test_logs_without_motion_give_none_and_no_note(log):
    ts, rs = log('ts', 'HDT'), log('rs', 'HDT')
    found = find_motion({'ts': ts, 'rs': rs}, DRIVERS)
    assert (len(found.rows), found.notes, found.origin) == (0, (), {})


def test_one_log_of_both_sensors_is_read_once(log):
    both = log('both', 'HDT', 'VTG')
    found = find_motion({'ts': both, 'rs': both}, DRIVERS)
    assert len(found.rows) == 3 and 'not used' not in found.notes[0]


def test_files_of_other_programs_tell_the_motion_too(log, tmp_path):
    """Another vessel, heard by AIS, is not this one."""
    path = tmp_path / 'signalk.log'
    rows = []
    for second in range(3):
        stamp = f'2024-05-01T00:00:{second:02d}Z'
        values = {'courseOverGroundTrue': 1.0, 'speedOverGround': 5.0, 'rateOfTurn': -0.01,
                  'position': {'latitude': 54.0, 'longitude': 10.0}, 'headingTrue': 1.1}
        told = [{'$source': 'n2k.5', 'timestamp': stamp, 'values': [
            {'path': f'navigation.{name}', 'value': value} for name, value in values.items()]}]
        rows += [{'context': 'vessels.self', 'updates': told},
                 {'context': 'vessels.urn:mrn:imo:mmsi:230000001', 'updates': told}]
    path.write_text('\n'.join(map(json.dumps, rows)))
    found = find_motion({'ts': log('ts', 'HDT', 'GLL'), 'rs': str(path)}, DRIVERS)
    assert [len(rows) for rows in found.rows.split().values()] == [3, 3, 3]
    assert found.rows.velocities().course_deg == pytest.approx([math.degrees(1.0)] * 3)
    assert found.rows.rates().rate_deg_s == pytest.approx([math.degrees(-0.01)] * 3)
    assert found.origin['course'] == f'n2k.5/courseOverGroundTrue {path}'


def test_a_course_of_signal_k_takes_the_newest_speed_of_its_source(tmp_path):
    def update(second, source, path, value):
        return {'$source': source, 'timestamp': f'2024-05-01T00:00:{second:02d}Z',
                'values': [{'path': f'navigation.{path}', 'value': value}]}
    told = [update(0, 'a', 'speedOverGround', 4.0), update(1, 'a', 'courseOverGroundTrue', 0.0),
            update(1, 'b', 'courseOverGroundTrue', 0.0), update(9, 'a', 'courseOverGroundTrue', 0)]
    path = tmp_path / 'signalk.log'
    path.write_text(json.dumps({'context': 'vessels.self', 'updates': told}))
    found = read_signalk(str(path))
    assert found.motion()['velocity']['a/courseOverGroundTrue'].north_m_s.tolist() == [4.0]
    assert found.not_taken == {'courseOverGroundTrue.no_speed': 2}
