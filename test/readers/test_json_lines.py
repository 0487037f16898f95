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

"""Deltas of Signal K and records of OpenRVDAS, written by hand after their descriptions."""

from __future__ import annotations

import json
import math

import pytest

from heading_intercompare.readers.json_lines import (
    is_gpsd,
    is_openrvdas,
    is_signalk,
    read_gpsd,
    read_openrvdas,
    read_signalk,
)

T_NS = 1408118400081000000
TIME = '2014-08-15T16:00:00.081Z'
OWN = 'urn:mrn:signalk:uuid:c0d79334-4e25-4245-8892-54e8ccc8021d'


def delta(source, context='vessels.self', time=TIME, **values):
    """Return a delta; the names of the values are those after `navigation.`."""
    named = {'$source': source} if isinstance(source, str) else {'source': source}
    return {'context': context, 'updates': [{**named, 'timestamp': time, 'values': [
        {'path': f'navigation.{name}', 'value': value} for name, value in values.items()]}]}


def read(tmp_path, reader, text):
    """Return the readings by stream as lists, and what was not taken."""
    path = tmp_path / 'a.log'
    path.write_text(text)
    found = reader(str(path))
    return ({name: list(zip(h.stamp_ns.tolist(), h.heading_deg.tolist()))
             for name, h in found.streams().items()}, dict(found.not_taken))


def test_what_no_ship_does_is_not_taken_from_signal_k(tmp_path):
    """It was believed: 300 m/s, a course of 9 rad, 70 degrees per second."""
    rows = [delta('gps', speedOverGround=300.0, courseOverGroundTrue=1.0),
            delta('gps', speedOverGround=5.0, courseOverGroundTrue=9.0),
            delta('gps', speedOverGround=-5.0, courseOverGroundTrue=1.0),
            delta('gps', rateOfTurn=math.radians(70.0)),
            delta('gps', speedOverGround=5.0, courseOverGroundTrue=6.2832, rateOfTurn=0.01)]
    path = tmp_path / 'a.log'
    path.write_text(''.join(f'{json.dumps(row)}\n' for row in rows))
    found = read_signalk(str(path))
    assert dict(found.not_taken) == {'velocity.out_of_range': 3, 'rateOfTurn.out_of_range': 1}
    motion = found.motion()
    assert motion['velocity']['gps/courseOverGroundTrue'].north_m_s == pytest.approx([5.0])
    assert motion['rate']['gps/rateOfTurn'].rate_deg_s == pytest.approx([math.degrees(0.01)])


@pytest.mark.parametrize('prefix', ['', '1408118400081;I;'])
def test_deltas_of_signal_k(tmp_path, prefix):
    rows = [
        {'self': f'vessels.{OWN}', 'version': '1.0.0'},
        delta('n2k.35', headingTrue=1.0),
        delta({'label': 'actisense', 'src': '115', 'pgn': 127250}, f'vessels.{OWN}',
              headingTrue=2.0),
        delta('n2k.36', headingMagnetic=3.0),
        delta('gps.1', magneticVariation=0.25),
        delta('n2k.36', headingMagnetic=3.0),
        delta('n2k.36', headingMagnetic=6.2, magneticVariation=-0.2),
        delta('ais', 'vessels.urn:mrn:imo:mmsi:230099999', headingTrue=0.5),
        delta('ais', 'vessels.urn:mrn:imo:mmsi:230099999', headingMagnetic=0.5),
        delta('n2k.35', headingTrue=None), delta('n2k.35', headingTrue=7.0),
        delta('n2k.35', time='soon', headingTrue=1.0), delta('n2k.35', speedOverGround=5.0),
    ]
    text = ''.join(f'{prefix}{json.dumps(row)}\n' for row in rows) + f'{prefix}{{"updates": [\n'
    assert is_signalk(text.encode()) and not is_openrvdas(text.encode())
    streams, not_taken = read(tmp_path, read_signalk, text)
    deg = math.degrees
    assert streams == {
        'n2k.35/headingTrue': [(T_NS, pytest.approx(deg(1.0)))],
        'actisense.115/headingTrue': [(T_NS, pytest.approx(deg(2.0)))],
        'n2k.36/headingMagnetic': [(T_NS, pytest.approx(deg(3.25))),
                                   (T_NS, pytest.approx(deg(6.0)))],
        'vessels.urn:mrn:imo:mmsi:230099999/ais/headingTrue': [(T_NS, pytest.approx(deg(0.5)))]}
    assert not_taken == {'no_variation': 2, 'empty_heading': 1, 'out_of_range': 1, 'no_stamp': 1,
                         'bad_field': 1}


def test_records_of_openrvdas(tmp_path):
    rows = [
        {'data_id': 's330', 'timestamp': 1406851200.183, 'fields': {
            'S330HeadingTrue': 235.15, 'S330HeadingRate': 0.1, 'S330CourseTrue': 12.0},
         'metadata': {}},
        {'data_id': 'gyr1', 'timestamp': 1406851200, 'fields': {'Gyr1HeadingTrue': '234.5'}},
        {'timestamp': 1406851201.25, 'fields': {'Hdg': 359.99}},
        {'data_id': 'gyr1', 'timestamp': 1406851202, 'fields': {'Gyr1HeadingTrue': 'x'}},
        {'data_id': 'gyr1', 'timestamp': None, 'fields': {'Gyr1HeadingTrue': 1.0}},
        {'data_id': 'gyr1', 'timestamp': 1406851203, 'fields': {'Gyr1HeadingTrue': -1.0}},
        {'data_id': 'gyr1', 'timestamp': 1406851203, 'fields': None},
    ]
    text = ''.join(json.dumps(row) + '\n' for row in rows)
    assert is_openrvdas(text.encode()) and not is_signalk(text.encode())
    assert read(tmp_path, read_openrvdas, text) == (
        {'s330/S330HeadingTrue': [(1406851200183000000, 235.15)],
         'gyr1/Gyr1HeadingTrue': [(1406851200000000000, 234.5)],
         'Hdg': [(1406851201250000000, 359.99)]},
        {'bad_field': 2, 'out_of_range': 1})


def test_records_of_openrvdas_tell_the_motion(tmp_path):
    """Positions as decimal degrees with a sign or a hemisphere, and as in the sentence."""
    def record(second, **fields):
        return {'data_id': 's330', 'timestamp': 1406851200 + second, 'fields': {
            f'S330{name}': value for name, value in fields.items()}}
    rows = [
        record(0, Latitude=-54.5, Longitude=-45.25),
        record(1, Latitude=54.5, NorS='S', Longitude=45.25, EorW='W'),
        record(2, Latitude='5430.0', NorS='S', Longitude='04515.0', EorW='W'),
        record(3, Latitude=5430.0, NorS='N', Longitude=15.0, EorW='E'),
        record(4, Latitude=5461.0, NorS='N', Longitude=15.0, EorW='E'),
        record(5, Latitude=54.5, NorS='N', Longitude=None, EorW=None),
        record(6, Latitude=None, Longitude=None),
        record(7, CourseTrue=90.0, SpeedKt=10.0),
        record(8, CourseTrue=361.0, SpeedKt=10.0),
        record(9, CourseTrue=90.0, SpeedKt=None, RateOfTurn=2.0),
        {'data_id': 's330', 'timestamp': 'x', 'fields': {'Latitude': 1.0, 'Longitude': 2.0}}]
    path = tmp_path / 'a.log'
    path.write_text(''.join(json.dumps(row) + '\n' for row in rows))
    found = read_openrvdas(str(path))
    motion = found.motion()
    assert dict(found.not_taken) == {'position.bad_field': 2, 'velocity.out_of_range': 1}
    (fixes,), (moved,) = motion['fix'].items(), motion['velocity'].items()
    assert set(motion) == {'fix', 'velocity'}
    assert fixes[0] == 's330/S330Latitude' and moved[0] == 's330/S330CourseTrue'
    assert (fixes[1].stamp_ns // 10**9 - 1406851200).tolist() == [0, 1, 2, 3]
    assert fixes[1].latitude_deg.tolist() == pytest.approx([-54.5, -54.5, -54.5, 54.5])
    assert fixes[1].longitude_deg.tolist() == pytest.approx([-45.25, -45.25, -45.25, 0.25])
    assert moved[1].east_m_s.tolist() == pytest.approx([10.0 * 1852.0 / 3600.0])
    assert moved[1].north_m_s.tolist() == pytest.approx([0.0], abs=1e-12)


def test_reports_of_gpsd_give_headings_by_device(tmp_path):
    rows = [{'class': 'VERSION', 'release': '3.25'},
            {'class': 'ATT', 'device': '/dev/gyro', 'time': TIME, 'heading': 219.05},
            {'class': 'ATT', 'device': '/dev/gps', 'time': TIME, 'heading': 218.74, 'roll': 1.0},
            {'class': 'ATT', 'device': '/dev/gps', 'time': TIME, 'pitch': 1.0},
            {'class': 'ATT', 'device': '/dev/gps', 'heading': 1.0},
            {'class': 'ATT', 'device': '/dev/gps', 'time': TIME, 'heading': 360.5},
            {'class': 'ATT', 'device': '/dev/gps', 'time': TIME, 'heading': True}]
    text = ''.join(f'{json.dumps(row)}\n' for row in rows) + '{"class":"ATT", broken\n'
    assert is_gpsd(text.encode()) and not is_signalk(text.encode())
    assert not is_openrvdas(text.encode())
    assert read(tmp_path, read_gpsd, text) == (
        {'/dev/gyro': [(T_NS, 219.05)], '/dev/gps': [(T_NS, 218.74)]},
        {'empty_heading': 2, 'no_stamp': 1, 'out_of_range': 1, 'bad_field': 1})


def test_reports_of_gpsd_give_the_motion_where_there_is_a_fix(tmp_path):
    report = {'class': 'TPV', 'device': '/dev/gps', 'time': TIME, 'lat': -33.5, 'lon': 151.25,
              'track': 90.0, 'speed': 5.0}
    path = tmp_path / 'a.log'
    path.write_text(''.join(f'{json.dumps({**report, **more})}\n' for more in (
        {'mode': 3}, {'mode': 2, 'lat': 95.0, 'track': None}, {'mode': 1}, {})))
    collected = read_gpsd(str(path))
    motion = collected.motion()
    assert motion['fix']['/dev/gps/position'].latitude_deg.tolist() == [-33.5]
    assert motion['velocity']['/dev/gps/track'].east_m_s == pytest.approx([5.0])
    assert dict(collected.not_taken) == {'position.out_of_range': 1}
