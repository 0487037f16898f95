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

"""Large logs: they take little memory beside their headings, and give what small ones give."""

from __future__ import annotations

import gc
import gzip
import tracemalloc

from checksums import with_checksum
from command_line import analyze_json
import numpy as np
import pytest

from heading_intercompare import Headings, Settings
from heading_intercompare.app.logs.log_import import import_log
from heading_intercompare.app.logs.log_motion import find_motion
from heading_intercompare.app.sources.input_comparison import InputComparison
from heading_intercompare.core.pairing import stream_pieces
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.raw_streams import sequence_match
from heading_intercompare.drivers.settings import DriverSettings

N = 900
SETTINGS = Settings.from_mapping({'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1})
MOTION = ('GPVTG,90.0,T,,M,10.0,N', 'GPGGA,120000.00,5400.0,N,01000.0,E,1,08,0.9,12,M,40,M,,',
          'HEROT,6.0,A')


def clock(second):
    return f'{12 + second // 3600:02d}:{second // 60 % 60:02d}:{second % 60:02d}'


def iso(second):
    return f'2014-08-01T{clock(second)}.000000Z'


def bodies(talker, seed, *others):
    """Return the sentences of each second, the heading first."""
    noise = np.random.default_rng(seed).standard_normal(N)
    heading = 100.0 + 5.0 * np.sin(np.arange(N) / 40.0) + 0.1 * noise
    return [(f'{talker}HDT,{value:.2f},T', *others) for value in heading]


def lines(talker, seed, *others, stamp=iso):
    return [f'{stamp(second)} {with_checksum(body)}\r\n'
            for second, told in enumerate(bodies(talker, seed, *others)) for body in told]


def zda(second):
    return with_checksum(f'GPZDA,{clock(second).replace(":", "")}.00,01,08,2014,,') + '\r\n'


def write_hours(folder, talker, seed):
    folder.mkdir()
    rows = lines(talker, seed, *MOTION)
    for part, lo in enumerate(range(0, len(rows), 1000)):
        (folder / f'{part}.log.gz').write_bytes(
            gzip.compress(''.join(rows[lo:lo + 1000]).encode()))


def hours_in_gz(folder):
    write_hours(folder / 'gyro', 'HE', 1)
    write_hours(folder / 'gnss', 'IN', 2)
    return folder / 'gyro', folder / 'gnss'


def date_told_late(folder):
    for name, talker, seed in (('gyro', 'HE', 1), ('gnss', 'IN', 2)):
        rows = lines(talker, seed, stamp=lambda second: f'[{clock(second)}.000]')
        (folder / name).write_text(''.join([*rows[:700], zda(700), *rows[700:]]))
    return folder / 'gyro', folder / 'gnss'


def times_of_validity(folder):
    for name, talker, seed in (('gyro', 'HE', 1), ('gnss', 'IN', 2)):
        rows = [zda(second) + with_checksum(told[0]) + '\r\n'
                for second, told in enumerate(bodies(talker, seed))]
        (folder / name).write_text(''.join(rows))
    return folder / 'gyro', folder / 'gnss', '--time', 'validity'


def both_in_one_log(folder):
    rows = zip(lines('HE', 1), lines('IN', 2))
    (folder / 'both').write_text(''.join(line for two in rows for line in two))
    return folder / 'both', '--ts-talker', 'HE', '--rs-talker', 'IN'


def clock_set_back(folder):
    for name, talker, seed in (('gyro', 'HE', 1), ('gnss', 'IN', 2)):
        (folder / name).write_text(''.join(lines(
            talker, seed, stamp=lambda second: iso(second if second < 500 else second - 300))))
    return folder / 'gyro', folder / 'gnss'


def a_stamp_in_the_future(folder):
    (folder / 'gyro').write_text(''.join(lines(
        'HE', 1, stamp=lambda second: iso(second + 7200 * (second == 400)))))
    (folder / 'gnss').write_text(''.join(lines('IN', 2, *MOTION)))
    return folder / 'gyro', folder / 'gnss'


@pytest.mark.parametrize('write', [hours_in_gz, date_told_late, times_of_validity, both_in_one_log,
                                   clock_set_back, a_stamp_in_the_future])
def test_logs_compared_piece_by_piece_give_the_verdict_of_whole_logs(
        write, tmp_path, capsys, monkeypatch):
    inputs = write(tmp_path)
    whole = analyze_json(capsys, *inputs)
    assert sum(run['n'] for run in whole[0]['runs']) > N // 2
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 100)
    assert analyze_json(capsys, *inputs) == whole


def test_the_share_of_each_log_that_is_read_is_told(tmp_path):
    gyro, gnss = map(str, hours_in_gz(tmp_path))
    texts = []
    import_log(gyro, DriverSettings(), texts.append)
    find_motion({'ts': gyro, 'rs': gnss}, dict.fromkeys(('ts', 'rs'), DriverSettings()),
                progress=texts.append)
    assert len(texts) > 2 * 3
    for path, what in ((gyro, ''), (gyro, 'the motion of the ship in '),
                       (gnss, 'the motion of the ship in ')):
        shares = [int(text.partition('%')[0]) for text in texts
                  if text.endswith(f'% of {what}{path} read')]
        assert shares == sorted(shares) and len(shares) > 2 and 90 < shares[-1] <= 100


@pytest.fixture
def traced():
    """Return a function that calls another one: bytes kept, most bytes meanwhile, its result."""
    def trace(function):
        tracemalloc.start()
        begin, _ = tracemalloc.get_traced_memory()
        result = function()
        gc.collect()
        end, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return end - begin, peak - begin, result
    yield trace
    tracemalloc.stop()


def test_lines_without_a_heading_keep_no_memory(tmp_path, traced):
    bytes_kept = []
    for n_others in (1, 20):
        path = tmp_path / f'{n_others}.log'
        path.write_text(''.join(lines('HE', 1, *['GPGSV,3,1,11,03,03,111,00'] * n_others)))
        import_log(str(path), DriverSettings())
        size, _, log = traced(lambda path=path: import_log(str(path), DriverSettings()))
        bytes_kept.append(size)
        assert log.not_taken['not_heading'] == n_others * N
    assert bytes_kept[1] < 1.1 * bytes_kept[0]


def test_motion_of_a_log_keeps_a_stamp_and_its_values_once(tmp_path, traced):
    path = tmp_path / 'gnss.log'
    path.write_text(''.join(lines('IN', 1, *MOTION * 5)))
    drivers = {'ts': DriverSettings()}
    find_motion({'ts': str(path)}, drivers)
    size, _, motion = traced(lambda: find_motion({'ts': str(path)}, drivers))
    values = sum(len(rows) * width for rows, width in zip(
        (motion.things[what] for what in ('fix', 'velocity', 'rate')), (24, 24, 16)))
    assert values == 5 * N * 64 and size < values + 60_000
    comparison = InputComparison(SETTINGS)
    size, _, _ = traced(lambda: [comparison.take_motion(rows) for rows in motion.things.values()])
    assert size < 0.2 * values


def long_streams(n):
    """Return two streams of 10 Hz."""
    rng, stamps = np.random.default_rng(1), 10 ** 18 + np.arange(n) * 10 ** 8
    return {name: Headings.of(stamps, np.round(90.0 + 0.1 * rng.standard_normal(n), 2))
            for name in ('ts', 'rs')}


def test_all_changes_of_value_of_long_logs_are_compared(monkeypatch):
    """Of whole logs only the last 400 000 readings were: of 12 h at 10 Hz, 11 h."""
    headings, counts = long_streams(5000), []
    for most_waiting in (400_000, 3000):
        monkeypatch.setattr(sequence_match, '_MOST_WAITING', most_waiting)
        monkeypatch.setattr(stream_pieces, '_AT_ONCE', 1000)
        comparison = InputComparison(SETTINGS)
        comparison.update(headings)
        comparison.finish()
        (pair,) = comparison.comparison.pairs.values()
        counts.append(pair.ledger.total.counts[LedgerKey.CHANGES_COMPARED])
    assert counts[0] == counts[1] > 0


def test_comparing_takes_little_memory_beside_what_the_runs_keep(traced, monkeypatch):
    """All at once took 816 bytes a pair; piece by piece it takes 104, with room to grow."""
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 5000)
    n = 100_000
    headings, comparison = long_streams(n), InputComparison(SETTINGS)
    _, peak, _ = traced(lambda: comparison.update(headings))
    assert peak < 200 * n
