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

"""Parquet tables of headings and of pairs, written by pyarrow."""

from __future__ import annotations

import json

from command_line import NORMS
import numpy as np
import pytest

from heading_intercompare.bags.csv.pairs_csv import write_pairs_csv
from heading_intercompare.cli import main
from heading_intercompare.core.records import Pairs
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions

pa = pytest.importorskip('pyarrow', reason='pyarrow is not installed')
pq = pytest.importorskip('pyarrow.parquet')

# After the check that pyarrow is here.
from heading_intercompare.readers.parquet import (  # noqa: E402
    has_pairs,
    PairsParquet,
    read_parquet,
)

S = 1_000_000_000
T0 = 1_406_851_200 * S + 183_000_001
QUIET_NORMS = (*NORMS, '--quiet')


def written(tmp_path, **columns):
    """Return the path of a table with these columns."""
    path = str(tmp_path / 'a.parquet')
    pq.write_table(pa.table(columns), path)
    return path


def lists(found):
    """Return the readings by stream as lists."""
    return {name: list(zip(h.stamp_ns.tolist(), h.heading_deg.tolist()))
            for name, h in found.streams().items()}


@pytest.mark.parametrize('name, stamps', [
    ('t_ns', pa.array([T0, T0 + S], pa.int64())),
    ('stamp_ns', pa.array([T0, T0 + S], pa.uint64())),
    ('time', pa.array([T0, T0 + S], pa.timestamp('ns'))),
    ('timestamp', pa.array([T0, T0 + S], pa.timestamp('ns', 'UTC')))])
def test_times_are_exact(tmp_path, name, stamps):
    path = written(tmp_path, **{name: stamps, 'heading_deg': [1.5, 360.0]})
    assert lists(read_parquet(path)) == {'heading_deg': [(T0, 1.5), (T0 + S, 0.0)]}


def test_columns_that_are_named_are_taken_whatever_their_names(tmp_path):
    path = written(tmp_path, when=pa.array([T0, T0 + S], pa.timestamp('ns')), Date=['a', 'b'],
                   GYRO=[1.5, 2.5])
    options = StreamOptions(DriverSettings(time_column='when'), ('/GYRO',))
    assert lists(read_parquet(path, options)) == {'GYRO': [(T0, 1.5), (T0 + S, 2.5)]}
    for stated, problem in (('clock', 'must be the time, clock or'),
                            ('Date,when', '--time-column Date,when: the times of Parquet are')):
        with pytest.raises(ReaderError, match=problem):
            read_parquet(path, StreamOptions(DriverSettings(time_column=stated), ('GYRO',)))


def test_times_in_seconds_are_those_of_their_float(tmp_path):
    path = written(tmp_path, stamp_s=[1406851200.25, 1406851201.5], heading_deg=[1.0, 2.0])
    assert lists(read_parquet(path))['heading_deg'] == [
        (1406851200250000000, 1.0), (1406851201500000000, 2.0)]
    path = written(tmp_path, timestamp=[1406851200, 1406851201], heading_deg=[1.0, 2.0])
    assert lists(read_parquet(path))['heading_deg'][0] == (1406851200000000000, 1.0)


NOON_NS = 1_406_894_400 * S


@pytest.mark.parametrize('columns, options', [
    ({'utc': ['2014-08-01T12:00:00.25Z', '2014-08-01T12:00:01.25Z']}, {}),
    ({'time': ['2014-08-01 14:00:00.25', '2014-08-01 14:00:01.25']}, {'stamp_zone': '+02:00'}),
    ({'time': pa.array(['1406894400.25', '1406894401.25'], pa.large_string())}, {}),
    ({'stamp_utc': pa.array(['20140801T120000.25Z', '20140801T120001.25Z']).dictionary_encode()},
     {}),
    ({'Date': ['2014-08-01'] * 2, 'Time': ['12:00:00.25', '12:00:01.25']},
     {'time_column': 'Date,Time'}),
    ({'Date': pa.array([16283] * 2, pa.int32()).cast(pa.date32()),
      'Time': pa.array([43_200_250, 43_201_250], pa.int32()).cast(pa.time32('ms'))},
     {'time_column': 'Date,Time'}),
    ({'time': ['12:00:00.25', '12:00:01.25']}, {'date': '2014-08-01'})])
def test_times_that_are_texts_are_read_as_those_of_a_csv(tmp_path, columns, options):
    path = written(tmp_path, **columns, heading_deg=[1.5, 2.5], cog_deg=[1.0, 2.0],
                   sog_kn=[1.0, 2.0])
    found = read_parquet(path, StreamOptions(DriverSettings(**options)))
    assert lists(found) == {'heading_deg': [(NOON_NS + S // 4, 1.5), (NOON_NS + 5 * S // 4, 2.5)]}


def test_texts_without_a_stamp_are_counted_and_the_first_is_said(tmp_path):
    path = written(tmp_path, utc=['2014-08-01T12:00:00Z', None, 'noon', '2014-08-01T12:00:03Z'],
                   src=['a', 'b', 'a', 'b'], heading_deg=[1.0, 2.0, 3.0, 4.0])
    found = read_parquet(path)
    assert lists(found) == {'a': [(NOON_NS, 1.0)], 'b': [(NOON_NS + 3 * S, 4.0)]}
    assert dict(found.not_taken) == {'no_stamp': 1, 'bad_stamp': 1}
    said, = found.oddities
    assert "first row without a stamp: row 3: column utc: 'noon' is no stamp" in said


@pytest.mark.parametrize('second, problem', [
    ('2014-08-01T12:00:01Z', None), ('noon', "row 2: column utc: 'noon' is no stamp"),
    (None, 'row 2: column utc is empty')])
def test_pairs_may_have_times_that_are_texts(tmp_path, second, problem):
    path = written(tmp_path, utc=['2014-08-01T12:00:00Z', second], ts_deg=[1.0, 2.0],
                   rs_deg=[3.0, 4.0])
    if problem is None:
        pairs, = PairsParquet(path)
        assert pairs.stamp_ns.tolist() == [NOON_NS, NOON_NS + S]
    else:
        with pytest.raises(ReaderError, match=problem):
            list(PairsParquet(path))


def test_each_source_is_a_stream_and_what_is_no_heading_is_counted(tmp_path):
    path = written(tmp_path, t_ns=[1, 2, 3, 4, 5], src=[35, 36, 35, 36, 35],
                   heading_deg=[1.0, 2.0, None, 361.0, float('nan')])
    found = read_parquet(path)
    assert lists(found) == {'35': [(1, 1.0)], '36': [(2, 2.0)]}
    assert dict(found.not_taken) == {'empty_heading': 2, 'out_of_range': 1}


def test_pairs_in_parquet_give_the_verdict_of_their_csv(tmp_path, capsys):
    rng = np.random.default_rng(2)
    n = 900
    pairs = Pairs.of(T0 + np.arange(n) * S, 90.0 + 0.1 * rng.standard_normal(n), np.full(n, 90.0),
                     rng.integers(-10**6, 10**6, n), rng.uniform(0.5, 1.0, n))
    write_pairs_csv(tmp_path / 'a.csv', [pairs])
    path = written(tmp_path, stamp_ns=pairs.stamp_ns, ts_deg=pairs.ts_deg, rs_deg=pairs.rs_deg,
                   lag_ns=pairs.lag_ns, rs_variance_factor=pairs.rs_variance_factor,
                   remark=['x'] * n)
    assert has_pairs(path) and Pairs.concatenate(list(PairsParquet(path))) == pairs
    runs = []
    for one in (path, tmp_path / 'a.csv'):
        assert main(['analyze', str(one), *QUIET_NORMS, '--json', '-']) == 0
        out, err = capsys.readouterr()
        run, = json.loads(out)['runs']
        runs.append({**run, 'source': ''})
        if one == path:
            assert err == f'note: {path}: columns that are not read: remark\n'
    assert runs[0] == runs[1]


def test_nulls_in_pairs_are_nan_and_absent_factors_1(tmp_path):
    path = written(tmp_path, t_ns=[1, 2], ts_deg=[1.0, None], rs_deg=[float('inf'), 2.0],
                   ts_variance_factor=[None, 0.5], lag_s=[0.003, None])
    found, = PairsParquet(path)
    assert found == Pairs.of([1, 2], [1.0, np.nan], [np.nan, 2.0], [3_000_000, 0], [1.0, 1.0],
                             [1.0, 0.5])


@pytest.mark.parametrize('columns, problem', [
    ({'heading_deg': [1.0]}, 'has the columns heading_deg: one must be the time'),
    ({'dday': [1.0], 'heading_deg': [1.0]}, 'one must be the time'),
    ({'t_ns': [1]}, 'has the columns t_ns: one must be heading_deg'),
    ({'t_ns': [1.5], 'heading_deg': [1.0]}, 'column t_ns is double: nanoseconds must be integers'),
    ({'t_ns': ['x'], 'heading_deg': [1.0]}, "row 1: column t_ns: 'x' is no stamp that can be"),
    ({'t_ns': [True], 'heading_deg': [1.0]}, 'column t_ns is bool: must be integers'),
    ({'t_ns': [1], 'heading_deg': ['north']}, 'column heading_deg is .*string: must be numbers')])
def test_a_wrong_column_is_one_line(tmp_path, columns, problem):
    path = written(tmp_path, **columns)
    with pytest.raises(ReaderError, match=problem):
        read_parquet(path)


def test_wrong_pairs_and_damage_are_one_line(tmp_path):
    path = written(tmp_path, t_ns=[1], ts_deg=[1.0], rs_deg=[1.0], rs_variance_factor=[1.5])
    with pytest.raises(ReaderError, match='column rs_variance_factor: must be above 0'):
        list(PairsParquet(path))
    damaged = tmp_path / 'b.parquet'
    damaged.write_bytes(b'PAR1' + b'\0' * 100)
    with pytest.raises(ReaderError, match='is damaged, or no Parquet'):
        has_pairs(str(damaged))
    with pytest.raises(FileNotFoundError):
        read_parquet(str(tmp_path / 'absent'))


def test_columns_of_motion_tell_it(tmp_path):
    path = written(tmp_path, stamp_ns=[T0, T0 + S], heading_deg=[10.0, 11.0], lat=[54.0, None],
                   lon=[10.0, 10.0], cog=[90.0, 90.0], sog_m_s=[5.0, 90.0], rot_deg_s=[0.5, -0.5])
    found = read_parquet(path)
    motion = {what: next(iter(streams.values())) for what, streams in found.motion().items()}
    assert motion['fix'].latitude_deg.tolist() == [54.0]
    assert motion['velocity'].east_m_s == pytest.approx([5.0])
    assert motion['rate'].rate_deg_s.tolist() == [0.5, -0.5]
    assert found.not_taken['cog sog_m_s.out_of_range'] == 1


MOMENTS = [T0 + one * S for one in range(4)]


@pytest.mark.parametrize('unit_ns', [S, 10 ** 6, 10 ** 3, 1])
@pytest.mark.parametrize('kind', [int, float])
@pytest.mark.parametrize('name', ['time', 'epoch'])
def test_numbers_of_any_unit_are_times(tmp_path, name, kind, unit_ns):
    """Whole seconds, so that a float holds them in each unit; a null is a reading without one."""
    whole = [kind(one // S * S // unit_ns) for one in MOMENTS]
    path = written(tmp_path, **{name: pa.array([*whole, None])}, heading_deg=[1.0] * 5)
    stamps = [stamp for stamp, _ in lists(read_parquet(path))['heading_deg']]
    assert stamps == [*(one // S * S for one in MOMENTS), 0]


@pytest.mark.parametrize('name, numbers, problem', [
    ('stamp_s', [one // 10 ** 6 for one in MOMENTS], 'are no seconds since 1970'),
    ('t_ns', [one // S for one in MOMENTS], 'looks like seconds since 1970'),
    ('t_ns', [one // 10 ** 6 for one in MOMENTS], 'looks like milliseconds since 1970'),
    ('time', [2 ** 62, 2 ** 62 + 1], 'are no times since 1970')])
def test_numbers_of_another_unit_than_their_name_are_refused(tmp_path, name, numbers, problem):
    path = written(tmp_path, **{name: numbers}, heading_deg=[1.0] * len(numbers))
    with pytest.raises(ReaderError, match=problem):
        read_parquet(str(path))
