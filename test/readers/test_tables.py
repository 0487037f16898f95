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

"""Csv tables with a column of times and columns of headings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.readers.stream_recording import (
    ReaderError,
    StreamOptions,
    StreamRecording,
)
from heading_intercompare.readers.tables import is_table, read_table

T_NS = 1406851200183000000


def read(tmp_path, text):
    """Return the readings by stream as lists, and what was not taken."""
    path = tmp_path / 'a.csv'
    path.write_text(text)
    found = read_table(str(path))
    return ({name: list(zip(h.stamp_ns.tolist(), h.heading_deg.tolist()))
             for name, h in found.streams().items()}, dict(found.not_taken))


@pytest.mark.parametrize('name, time', [
    ('timestamp', '1406851200.183'), ('Time', '2014-08-01T00:00:00.183Z'),
    ('UTC', '2014-08-01 02:00:00.183+02:00'), ('t_ns', str(T_NS)), ('epoch', '1406851200183'),
    ('time', '1406851200183000')])
@pytest.mark.parametrize('separator', [',', ';', '\t'])
def test_each_column_of_headings_is_a_stream(tmp_path, name, time, separator):
    text = ('# a cruise\n{0},Gyr1HeadingTrue,hdg,heading_std,lat\n{1},235.15,0.5,0.1,-60\n'
            '{1},,nan,,\n{1},361,x,,\nsoon,1,2,3,4\n').format(name, time).replace(',', separator)
    assert is_table(text.encode())
    assert read(tmp_path, text) == (
        {'Gyr1HeadingTrue': [(T_NS, 235.15)], 'hdg': [(T_NS, 0.5)]},
        {'empty_heading': 2, 'out_of_range': 1, 'bad_field': 1, 'bad_stamp': 1})


@pytest.mark.parametrize('text', [
    'stamp_ns,ts_deg,rs_deg\n', '$HEHDT,123.4,T*10\n', 'start,stop\n', 'time,lat,lon\n', '',
    'Gyr1HeadingTrue,lat\n', 't_ns,heading_deg,src\n'])
def test_other_texts_are_no_tables(text):
    assert not is_table(text.encode())


@pytest.mark.parametrize('text, problem', [
    ('dday,hdg\n212.5,1\n', 'column dday: a decimal day has no year; add a column stamp_utc'),
    ('time,hdg,hdg\n1,2,3\n', "column 'hdg' stands twice"),
    ('time,hdg\n1406851200,2,3,4\n', 'has 4 columns, more than the header')])
def test_a_mistake_is_one_line(tmp_path, text, problem):
    with pytest.raises(ReaderError, match=problem) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(f'{tmp_path / "a.csv"}: ')


def test_columns_of_motion_are_taken_with_the_unit_in_their_names(tmp_path):
    path = tmp_path / 'a.csv'
    path.write_text('time,hdg,Lat,Lon,cog,sog_kn,rot_deg_min\n'
                    '1406851200,10,54.5,10.25,90,10,-30\n1406851201,10,,10.25,400,10,\n')
    found = read_table(str(path))
    motion = {what: next(iter(streams.items())) for what, streams in found.motion().items()}
    assert {what: name for what, (name, _) in motion.items()} == {
        'fix': 'Lat Lon', 'velocity': 'cog sog_kn', 'rate': 'rot_deg_min'}
    assert motion['fix'][1].latitude_deg.tolist() == [54.5]
    assert motion['velocity'][1].east_m_s == pytest.approx([10 * 1852 / 3600])
    assert motion['rate'][1].rate_deg_s.tolist() == [-0.5]
    assert dict(found.not_taken) == {'cog sog_kn.out_of_range': 1}


def test_a_column_that_is_named_holds_headings_whatever_its_name(tmp_path):
    path, text = tmp_path / 'a.csv', 't,GYRO,POSMV,LAT\n1406851200,10.5,x,1\n1406851201,11.5,y,1\n'
    path.write_text(text)
    assert not is_table(text.encode())
    assert is_table(text.encode(), StreamOptions(names=('/GYRO',)))
    found = StreamRecording(
        path, 'csv', lambda name: read_table(name, StreamOptions(names=('/GYRO',))),
        lambda stream: 'rad' if stream == 'GYRO' else 'auto')
    assert found.resolve('/GYRO') == 'GYRO' and found.not_taken == {'out_of_range': 2}
    with pytest.raises(ReaderError, match=r"no stream 'LAT'; .*; other columns: POSMV, LAT; "):
        found.resolve('LAT')
    with pytest.raises(ReaderError, match=r"line 2: column POSMV: 'x' is no number of a heading"):
        read_table(str(path), StreamOptions(names=('GYRO', 'POSMV')))


def test_a_last_line_that_is_cut_is_left_out_and_counted(tmp_path):
    text = 't_ns,lat,hdg\n{0},1,10.5\n{0},1'.format(T_NS)
    assert read(tmp_path, text) == ({'hdg': [(T_NS, 10.5)]}, {'cut_line': 1})


STRAY = 'a quotation mark hides the rows after it; remove it, or close it in the same cell'
ROWS = [f'2014-08-01T00:00:0{at}Z,{at}.5,calm' for at in range(9)]


@pytest.mark.parametrize('changed, line', [
    ({3: '2014-08-01T00:00:03Z,"3.5,calm'}, 5),
    ({3: '2014-08-01T00:00:03Z,"3.5,calm', 6: '2014-08-01T00:00:06Z,"6.5,calm'}, 5),
    ({3: '2014-08-01T00:00:03Z,3.5,"calm', 6: '2014-08-01T00:00:06Z,6.5,calm"'}, 5),
    ({3: '2014-08-01T00:00:03Z,3.5,"calm', 4: '2014-08-01T00:00:04Z,4.5,calm"'}, 5),
    ({0: '"2014-08-01T00:00:00Z,0.5,calm'}, 2),
    ({5: '# mast,"as built'}, 7)])
@pytest.mark.parametrize('n', [1, 20_000])
def test_a_quotation_mark_that_hides_rows_is_one_line(tmp_path, changed, line, n):
    """Without a second one it hid all that follows, and no row was counted."""
    rows = [changed.get(at, row) for at, row in enumerate(ROWS)]
    with pytest.raises(ReaderError) as raised:
        read(tmp_path, '\n'.join(['utc,heading,remark', *rows, *ROWS[:1] * n, '']))
    assert f'line {line}: {STRAY}' in str(raised.value)


@pytest.mark.parametrize('remark', [
    '"calm"', '"calm,\nlater wind"', '"5 ""inches""\n3,4"', '"a\n\nb"', 'a "calm" sea'])
def test_remarks_in_quotes_may_hold_ends_of_lines(tmp_path, remark):
    rows = [row.replace('calm', remark) if at == 4 else row for at, row in enumerate(ROWS)]
    streams, not_taken = read(tmp_path, '\n'.join(['utc,heading,remark', *rows, '']))
    assert [heading_deg for _, heading_deg in streams['heading']] == [at + 0.5 for at in range(9)]
    assert not not_taken


def trial(names, make, n=900):
    """Return a csv of two sensors on a ship that turns to and fro across north; 0.1 deg apart."""
    rows = [f'time,{",".join(names)}']
    for k in range(n):
        heading_deg = 60.0 * math.sin(k / 60.0)
        rows.append(f'{1406851200 + k},' + ','.join(
            make(heading_deg + offset) for offset in (0.1, 0.0)))
    return '\n'.join(rows) + '\n'


UNITS = {'rad': lambda deg: f'{math.radians(deg % 360.0):.5f}',
         'rev': lambda deg: f'{deg / 360.0 % 1.0:.6f}',
         'deg': lambda deg: f'{(deg + 180.0) % 360.0 - 180.0:.3f}'}


def readings(tmp_path, text, unit_of=lambda stream: 'auto'):
    path = tmp_path / 'a.csv'
    path.write_text(text)
    return StreamRecording(path, 'csv', read_table, unit_of)


@pytest.mark.parametrize('unit', UNITS)
def test_columns_are_in_the_unit_of_their_names(tmp_path, unit):
    found = readings(tmp_path, trial((f'ts_hdg_{unit}', f'rs_hdg_{unit}'), UNITS[unit]))
    ts, rs = (found.streams[found.resolve(f'{name}_hdg_{unit}')] for name in ('ts', 'rs'))
    assert len(ts) == len(rs) == 900 and not found.not_taken
    assert np.abs(wrap180(ts.heading_deg - rs.heading_deg) - 0.1).max() < 3e-3
    assert ts.heading_deg.max() > 359.0


@pytest.mark.parametrize('unit', ['rad', 'rev'])
@pytest.mark.parametrize('name', ['hdg', 'hdg_deg'])
def test_columns_that_are_no_degrees_are_asked_for_their_unit_when_used(tmp_path, unit, name):
    text = trial((f'ts_{name}', f'rs_{name}'), UNITS[unit])
    found = readings(tmp_path, text)
    assert set(found.topics) == {f'ts_{name}', f'rs_{name}'}
    with pytest.raises(ReaderError, match=f'ts_{name}: the headings lie within .*state the unit'):
        found.headings({f'ts_{name}': 'enu', f'rs_{name}': 'enu'})
    stated = readings(tmp_path, text, lambda stream: unit)
    chunk, = stated.headings({f'ts_{name}': 'enu', f'rs_{name}': 'enu'})
    assert chunk[f'ts_{name}'].heading_deg.max() > 359.0


def test_a_stated_unit_wins_over_the_name(tmp_path):
    found = readings(tmp_path, trial(('ts_hdg_rad', 'rs_hdg_rad'), UNITS['deg']),
                     lambda stream: 'deg')
    assert found.streams['ts_hdg_rad'].heading_deg.max() > 359.0 and not found.not_taken


def test_the_progress_of_a_large_table_is_told(tmp_path):
    path, told = tmp_path / 'table.csv', []
    path.write_text('time,heading\n' + ''.join(
        f'{1_700_000_000 + row}.000,{row % 360}.000\n' for row in range(100_000)))
    read_table(str(path), StreamOptions(progress=told.append))
    assert len(told) > 1 and told[-1].endswith(' lines')
