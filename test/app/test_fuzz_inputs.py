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

"""Damaged lines and cells of each kind of text: refused in one line or counted, never invented."""

from __future__ import annotations

import json
import random

from checksums import with_checksum
import numpy as np
import pytest

from heading_intercompare.cli.program import main
from heading_intercompare.drivers.logs import is_log, LogReader
from heading_intercompare.readers.registry import open_recording

N_LINES, FILES_PER_KIND = 60, 50
T0_S = 1_700_000_000
JUNK = [b'\x00', b'\xff', b'\xc3\xa9', b'#', b'*', b'$', b'"', b',', b';', b' ', b'\t', b'\r',
        b'{', b'}', b'\\', b'-', b'Z', b'|']


def iso(row):
    return str(np.datetime64(T0_S + row, 's')) + 'Z'


def of_body(make_body):
    """Return a maker of lines with a stamp and a sentence with its checksum."""
    return lambda row, heading: f'{iso(row)} {with_checksum(make_body(row, heading))}'


def payload(heading):
    """Return the bytes of a vessel heading of NMEA 2000."""
    return (b'\x01' + round(np.radians(heading) * 1e4).to_bytes(2, 'little')
            + b'\xff\x7f\xff\x7f\xfc')


SENTENCES = {
    'HDT': of_body(lambda row, heading: f'HEHDT,{heading:.2f},T'),
    'THS': of_body(lambda row, heading: f'GPTHS,{heading:.2f},A'),
    'PASHR': of_body(lambda row, heading: (
        f'PASHR,{iso(row)[11:19].replace(":", "")}.00,{heading:.2f},T,1.0,0.5,0.0,0.1,0.1,0.1,'
        '1,1')),
    'VHW': of_body(lambda row, heading: f'VWVHW,{heading:.2f},T,,M,10.0,N,18.5,K')}
UNCHECKED = {
    'csv': lambda row, heading: f'{iso(row)},{heading:.2f},{heading + 0.1:.2f}',
    'csv with quotes': lambda row, heading: f'"{iso(row)}","{heading:.2f}","x, y"',
    'candump': lambda row, heading: (
        f'({T0_S + row}.000000) can0 09F11223#{payload(heading).hex().upper()}'),
    'gateway': lambda row, heading: (
        f'{iso(row)[11:19]}.000 R 09F11223 {payload(heading).hex(" ").upper()}'),
    'gpsd': lambda row, heading: json.dumps({
        'class': 'ATT', 'device': '/dev/gyro', 'time': iso(row), 'heading': round(heading, 2)}),
    'Signal K': lambda row, heading: json.dumps({'context': 'vessels.self', 'updates': [{
        'source': {'label': 'n2k', 'src': '35'}, 'timestamp': iso(row), 'values': [
            {'path': 'navigation.headingTrue', 'value': round(np.radians(heading), 5)}]}]})}
HEADERS = {'csv': ['time,gyro_heading,ins_heading'],
           'csv with quotes': ['"time","gyro_heading","remark"']}


def damage(lines, rng):
    """Return lines of which some are damaged, doubled, swapped or gone."""
    damaged = []
    for line in lines:
        kind = rng.random()
        at = rng.randrange(len(line))
        if kind < 0.02:
            line = line[:at]
        elif kind < 0.05:
            line = line[:at] + rng.choice(JUNK) + line[at + 1:]
        elif kind < 0.08:
            line = line[:at] + rng.choice(JUNK) + line[at:]
        elif kind < 0.10:
            line = line[:at] + line[at + 1:]
        elif kind < 0.11:
            line = rng.randbytes(rng.randrange(80)).replace(b'\n', b'')
        elif kind < 0.12:
            damaged.append(line)
        elif kind < 0.13:
            line = b''
        damaged.append(line)
    if rng.random() < 0.2:
        rng.shuffle(damaged)
    return damaged


def write(path, kind, rng):
    """Write a damaged file; return its headings before it was damaged."""
    headings = [round(rng.uniform(0.0, 359.0), 2) for _ in range(N_LINES)]
    make = {**SENTENCES, **UNCHECKED}[kind]
    lines = [line.encode() for line in HEADERS.get(kind, [])]
    body = [make(row, heading).encode() for row, heading in enumerate(headings)]
    end = rng.choice((b'\n', b'\r\n'))
    path.write_bytes(end.join([*lines, *damage(body, rng)]) + rng.choice((end, b'')))
    return headings


def read(path):
    """Return all headings that are read of a file; None if it is refused."""
    try:
        if is_log(path):
            chunks = [chunk.heading_deg for chunk in LogReader(path)]
        else:
            chunks = [headings.heading_deg
                      for headings in open_recording(str(path)).streams.values()]
    except ValueError as error:
        assert str(path) in str(error) and '\n' not in str(error)
        return None
    return np.concatenate([*chunks, np.empty(0)])


@pytest.mark.parametrize('kind', [*SENTENCES, *UNCHECKED])
def test_of_damaged_lines_no_heading_is_invented(tmp_path, capsys, kind):
    n_read = 0
    for seed in range(FILES_PER_KIND):
        # Times of a gateway have no date.
        path = tmp_path / f'2023-11-14_{seed}.log'
        headings = write(path, kind, random.Random(f'{kind} {seed}'))
        code = main(['info', str(path)])
        said = capsys.readouterr()
        assert code in (0, 2) and 'Traceback' not in said.err, seed
        assert code == 0 or len(said.err.splitlines()) == 1, said.err
        heading_deg = read(path)
        if heading_deg is None:
            continue
        n_read += len(heading_deg)
        assert ((heading_deg >= 0.0) & (heading_deg < 360.0)).all(), seed
        # A line may be doubled; a csv has two headings in each row.
        assert len(heading_deg) <= 2 * N_LINES + 20
        if kind in SENTENCES:
            assert {*heading_deg.round(2).tolist()} <= {*headings}, seed
    # A stray quotation mark may hide half a table, so such a table is refused.
    assert n_read > FILES_PER_KIND * N_LINES / (10 if kind == 'csv with quotes' else 4)
