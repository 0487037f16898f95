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

"""Many rows of a table at once are those that are read one by one, to the bit."""

from __future__ import annotations

import random

import numpy as np
import pytest

from heading_intercompare.bags.csv import csv_rows
from heading_intercompare.bags.csv.csv_rows import CsvRows
from heading_intercompare.bags.csv.pairs_csv import read_pairs_csv
from heading_intercompare.bags.csv.plain_rows import PlainRows
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import Pairs
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions
from heading_intercompare.readers.tables import read_table

START = np.datetime64('2024-02-28T23:58:00.000', 'ms')
STEP_MS = 700
MONTHS = 'Jan Feb Mar'.split()


def parts_of(moment):
    """Return the numbers of a moment: date, time of day, milliseconds."""
    text = str(moment)
    date, clock = text.split('T')
    return (*map(int, date.split('-')), clock[:8], int(clock[9:]))


def epoch_ms(moment):
    return int(moment.astype(np.int64))


ROLLOVER_S = 1024 * 7 * 86400
FORMS = {
    'iso': ('time', lambda at: f'{at}Z'),
    'zone': ('time', lambda at: f'{at}+02:00'),
    'seconds': ('time', lambda at: str(at)[:19]),
    'short decimals': ('time', lambda at: str(at).rstrip('0').rstrip('.')),
    'bracketed': ('time', lambda at: f'[{at}]'),
    'American': ('time', lambda at: '{1}/{2}/{0} {3}.{4:03}'.format(*parts_of(at))),
    'German': ('time', lambda at: '{2:02}.{1:02}.{0} {3}'.format(*parts_of(at))),
    'weekday': ('time', lambda at: 'Thu {2} {m} {0} {3}.{4:03}'.format(
        *parts_of(at), m=MONTHS[parts_of(at)[1] - 1])),
    'two columns': ('date,time', lambda at: f'{str(at)[:10]},{str(at)[11:]}'),
    'six digits': ('date,time', lambda at: (
        f'{str(at)[:10].replace("-", "")},{str(at)[11:].replace(":", "")}')),
    'clock': ('time', lambda at: str(at)[11:]),
    'epoch': ('time', lambda at: f'{epoch_ms(at) / 1e3:.3f}'),
    'milliseconds': ('time', lambda at: str(epoch_ms(at))),
    'nanoseconds': ('t_ns', lambda at: f'{epoch_ms(at)}000001'),
    'from zero': ('time_s', lambda at: f'{epoch_ms(at) / 1e3 - epoch_ms(START) / 1e3:.2f}'),
    'a rollover early': ('time', lambda at: f'{epoch_ms(at) / 1e3 - ROLLOVER_S:.3f}'),
    'two rollovers early': ('time', lambda at: f'{at - np.timedelta64(2 * ROLLOVER_S, "s")}Z'),
    'days': ('time', lambda at: f'{epoch_ms(at) / 86_400_000 + 25569:.9f}'),
}
ODD_CELLS = ['', ' ', 'nan', '1e1', '-0.0', '+5.5', '.5', '7.', '1.2.3', '--', 'x', '12,5',
             '"9.5"', '-1e-20', '123.45678901234567', '0.1234567890123456789',
             '99999999999999999999', ' 3.25 ', '\t4.5', '1_0', '٣', 'inf', '400', '"4\n5"', '0x10']
ODD_LINES = ['', '# a comment', ',,', ', ,', '"', 'x', '2024-13-01T00:00:00Z,1,2',
             '2024-02-28T23:58:60Z,1,2', '1,2']


def write(path, form, rng, n=700, odd=0.0, end='\n'):
    """Write a table of two headings and a speed; some rows are odd."""
    header, stamp = FORMS[form]
    lines = [f'{header},gyro_heading,ins_heading,rot_deg_min']
    at = START
    for row in range(n):
        at += np.timedelta64(STEP_MS + 50 * rng.randrange(-30, 3) * (rng.random() < 0.1), 'ms')
        cells = [f'{rng.uniform(0, 360):.{rng.choice((1, 3, 3, 3))}f}',
                 repr(rng.uniform(0, 360)) if row % 7 == 0 else f'{rng.uniform(0, 360):.2f}',
                 f'{rng.uniform(0, 20):.1f}']
        while rng.random() < odd:
            cells[rng.randrange(3)] = rng.choice(ODD_CELLS)
        lines.append(','.join([stamp(at), *cells]))
        if rng.random() < odd / 4:
            lines.append(rng.choice(ODD_LINES))
    text = end.join(lines) + rng.choice((end, ''))
    path.write_bytes(text.encode())


def read(path):
    """Return all that is read of a table, or how it is refused."""
    try:
        collected = read_table(str(path), StreamOptions(DriverSettings(date='2024-02-28')))
    except ReaderError as error:
        return str(error)
    streams = {name: (headings.stamp_ns.tolist(), headings.heading_deg.tobytes())
               for name, headings in collected.streams().items()}
    motion = {what: {name: (rows.stamp_ns.tolist(), rows.rate_deg_s.tobytes())
                     for name, rows in by_name.items()}
              for what, by_name in collected.motion().items()}
    return streams, motion, collected.not_taken, collected.oddities, collected.other_columns


def read_singly(path, monkeypatch):
    """Return the same, where each row is read by itself."""
    with monkeypatch.context() as patch:
        patch.setattr(CsvRows, 'parts', CsvRows.__iter__)
        return read(path)


@pytest.mark.parametrize('form', FORMS)
@pytest.mark.parametrize('odd', [0.0, 0.002, 0.2])
def test_many_rows_at_once_are_those_read_one_by_one(tmp_path, monkeypatch, form, odd):
    monkeypatch.setattr(csv_rows, '_BLOCK_BYTES', 9000)
    path = tmp_path / 'table.csv'
    for seed in range(4):
        write(path, form, random.Random(seed), odd=odd, end='\r\n' if seed % 2 else '\n')
        expected = read_singly(path, monkeypatch)
        assert read(path) == expected, seed
    if odd == 0.0:
        streams, motion, *_ = expected
        assert len(streams['gyro_heading'][0]) > 690 and motion['rate']


@pytest.mark.parametrize('form', sorted(
    {*FORMS} - {'days', 'short decimals', 'a rollover early', 'two rollovers early'}))
def test_rows_without_oddities_are_read_many_at_once(tmp_path, monkeypatch, form):
    """A table of a million rows takes a second, not six."""
    path = tmp_path / 'table.csv'
    write(path, form, random.Random(1))
    singly = []
    take = csv_rows.CsvRows.plain
    monkeypatch.setattr(CsvRows, 'plain', lambda rows, cell: (singly.append(cell),
                                                              take(rows, cell))[1])
    with CsvRows(path, '') as rows:
        sizes = [len(part) for part in rows.parts() if isinstance(part, PlainRows)]
    assert sum(sizes) > 690
    read(path)
    assert len(singly) < 100


PAIRS = [('stamp_ns', 'lag_ns', lambda rng: str(rng.randrange(-10 ** 8, 10 ** 8))),
         ('stamp_s', 'lag_s', lambda rng: f'{rng.uniform(-0.1, 0.1):.4f}'),
         ('stamp_utc', 'lag_s', lambda rng: '')]
STAMPS = {'stamp_ns': lambda at: f'{epoch_ms(at)}000001', 'stamp_utc': lambda at: f'{at}Z',
          'stamp_s': lambda at: f'{epoch_ms(at) / 1e3:.3f}'}


def read_pairs(path):
    """Return the columns of a csv of pairs to the bit, or how it is refused."""
    try:
        pairs = Pairs.concatenate([*read_pairs_csv(path)])
    except BagError as error:
        return str(error)
    return [getattr(pairs, name).tobytes() for name in (
        'stamp_ns', 'ts_deg', 'rs_deg', 'lag_ns', 'rs_variance_factor', 'ts_variance_factor')]


@pytest.mark.parametrize('stamp, lag, lag_of', PAIRS)
@pytest.mark.parametrize('odd, is_refused', [
    ([], False), (['"9.5"'], False), (['x'], True), (['7,5'], True),
    (['', ' 3.25 ', '-0.0', '-7.5', '123.45678901234567', 'nan', '+4.5', '1e2'], False)])
def test_many_pairs_at_once_are_those_read_one_by_one(
        tmp_path, monkeypatch, stamp, lag, lag_of, odd, is_refused):
    monkeypatch.setattr(csv_rows, '_BLOCK_BYTES', 9000)
    path, rng, at = tmp_path / 'pairs.csv', random.Random(3), START
    lines = [f'{stamp},ts_deg,rs_deg,{lag},rs_variance_factor']
    for row in range(600):
        at += np.timedelta64(STEP_MS, 'ms')
        cells = [STAMPS[stamp](at), f'{rng.uniform(-180, 360):.3f}', repr(rng.uniform(0, 360)),
                 lag_of(rng), rng.choice(('', '1', '0.75'))]
        if odd and rng.random() < 0.01:
            cells[rng.choice((1, 2))] = rng.choice(odd)
        lines.append(','.join(cells))
        if row == 300:
            lines += ['', ' , ,,,']
    path.write_text('\n'.join([*lines, '']))
    many = read_pairs(path)
    monkeypatch.setattr(CsvRows, 'parts', CsvRows.__iter__)
    assert many == read_pairs(path)
    assert isinstance(many, str) == is_refused


def test_a_row_with_more_cells_than_the_header_is_named(tmp_path):
    path = tmp_path / 'table.csv'
    rows = [f'{1_700_000_000 + i},{i / 10},' for i in range(100)]
    rows[70] = rows[70][:-1] + ',5'
    path.write_text('\n'.join(['time,heading,', *rows, '']))
    with pytest.raises(ReaderError, match='line 72 has 3 columns, more than the header'):
        read_table(str(path))
