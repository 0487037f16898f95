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

"""Each example of docs/howto/import_logs.md makes a bag of a file as its logger writes it."""

from __future__ import annotations

from datetime import datetime, timedelta
import json
import math
from pathlib import Path

from checksums import with_checksum
import pytest
from test_documented_commands import read_commands

from heading_intercompare.cli import main

PAGE = Path(__file__).resolve().parent.parent / 'docs' / 'howto' / 'import_logs.md'
BEGIN, N = datetime(2024, 5, 28, 20), 120
#: Seconds of 1 January 1970 to the beginning, and days from the beginning of the year.
EPOCH_S, DDAY = 1_716_926_400, 148 + 20 / 24


def comma(heading_deg):
    return f'{heading_deg:.2f}'.replace('.', ',')


def hdt(heading_deg, talker='HE'):
    return with_checksum(f'{talker}HDT,{heading_deg:.2f},T')


def raw(heading_deg, sep=''):
    return sep.join(f'{byte:02X}' for byte in round(math.radians(heading_deg) * 1e4).to_bytes(
        2, 'little'))


def both(line):
    """Return the lines of both sensors, by what makes that of one."""
    return lambda k, t, ts, rs: ''.join(line(k, t, n, x) for n, x in enumerate((ts, rs)))


def unixd(heading_deg, k):
    dday = DDAY + k / 86400
    return f'$UNIXD,{dday:.7f},{dday:.7f}\n{hdt(heading_deg)}\n'


#: The header and what makes the lines of a second, from its number, its time and both headings.
FILES = {
    'excel.csv': ('Datum;Uhrzeit;Kreisel;GNSS\n', lambda k, t, ts, rs: (
        f'{t:%d.%m.%Y;%H:%M:%S};{comma(ts)};{comma(rs)}\n')),
    'survey.csv': ('Date,Time,GYRO,POSMV\n', lambda k, t, ts, rs: (
        f'{t:%m/%d/%Y,%H:%M:%S}.000,{ts:.3f},{rs:.3f}\n')),
    'clock.csv': ('Time,GYRO,POSMV\n', lambda k, t, ts, rs: f'{t:%H:%M:%S},{ts:.3f},{rs:.3f}\n'),
    'pandas.csv': (',gyro,gnss\n', lambda k, t, ts, rs: (
        f'{t:%Y-%m-%d %H:%M:%S}+00:00,{ts},{rs}\n')),
    'opencpn_vdr.csv': ('timestamp,type,id,message\n', both(lambda k, t, n, x: (
        f'{t:%Y-%m-%dT%H:%M:%S}.063Z,NMEA0183,,"{hdt(x, ("HE", "GP")[n])}"\n'))),
    'opencpn_monitor.csv': (
        '# VDR\nreceived_at,protocol,source,msg_type,raw_data\n', both(lambda k, t, n, x: (
            f'{(EPOCH_S + k) * 1000},nmea0183,ttyUSB{n},HDT,{hdt(x, ("HE", "GP")[n])}\n'))),
    'plain.txt': ('', lambda k, t, ts, rs: '\n'.join((
        with_checksum(f'GPZDA,{t:%H%M%S}.00,28,05,2024,00,00'), hdt(ts), hdt(rs, 'GP'), ''))),
    'scs_gyro.raw': ('', lambda k, t, ts, rs: f'{t:%m/%d/%Y,%H:%M:%S}.063,{hdt(ts)}\n'),
    'scs_gnss.raw': ('', lambda k, t, ts, rs: f'{t:%m/%d/%Y,%H:%M:%S}.063,{hdt(rs, "GP")}\n'),
    'gyro2024_148_72000.hdg': ('', lambda k, t, ts, rs: unixd(ts, k)),
    'gnss2024_148_72000.hdg': ('', lambda k, t, ts, rs: unixd(rs, k)),
    'gyro.log': ('', lambda k, t, ts, rs: f'{t:%Y-%m-%dT%H:%M:%S}.000Z {hdt(ts)}\n'),
    'seapath.log': ('', lambda k, t, ts, rs: ''.join(
        f'{t:%Y-%m-%dT%H:%M:%S}.000Z {with_checksum(body)}\n'
        for body in ('PSXN,20,1,1,0,0', f'PSXN,23,0.1,0.2,{rs:.2f},0.01'))),
    'candump.log': ('', both(lambda k, t, n, x: (
        f'({EPOCH_S + k}.000000) can0 09F112{35 + n:02X}#01{raw(x)}FF7FFF7FFC\n'))),
    'actisense.log': ('', both(lambda k, t, n, x: (
        f'A{t:%H%M%S}.000 {35 + n:02X}FF2 1F112 01{raw(x)}FF7FFF7FFC\n'))),
    'yacht_devices.log': ('', both(lambda k, t, n, x: (
        f'{t:%H:%M:%S}.000 R 09F112{35 + n:02X} 01 {raw(x, " ")} FF 7F FF 7F FC\n'))),
    'canboat.json': ('', both(lambda k, t, n, x: json.dumps({
        'timestamp': f'{t:%Y-%m-%dT%H:%M:%S}.000Z', 'src': 35 + n, 'pgn': 127250,
        'fields': {'Heading': round(x, 4), 'Reference': 'True'}}) + '\n')),
    'gpsd.json': ('', both(lambda k, t, n, x: json.dumps({
        'class': 'ATT', 'device': f'/dev/ttyUSB{n}', 'time': f'{t:%Y-%m-%dT%H:%M:%S}.000Z',
        'heading': round(x, 2)}) + '\n')),
    'signalk.log': ('', both(lambda k, t, n, x: json.dumps({
        'context': 'vessels.self', 'updates': [{
            '$source': f'n2k.{35 + n}', 'timestamp': f'{t:%Y-%m-%dT%H:%M:%S}.000Z',
            'values': [{'path': 'navigation.headingTrue', 'value': math.radians(x)}]}]}) + '\n')),
}


def seconds():
    """Yield the number, the time and the headings of each second."""
    for k in range(N):
        heading_deg = 100.0 + 20.0 * math.sin(k / 20.0)
        yield k, BEGIN + timedelta(seconds=k), heading_deg + 0.1, heading_deg


def write_parquet(path):
    pyarrow = pytest.importorskip('pyarrow', reason='pyarrow is not installed')
    parquet = pytest.importorskip('pyarrow.parquet')
    _, times, ts, rs = zip(*seconds())
    parquet.write_table(pyarrow.table({'time': pyarrow.array(times, pyarrow.timestamp('ns')),
                                       'gyro': ts, 'gnss': rs}), path)


def examples():
    """Return the commands of the section with the examples."""
    section = PAGE.read_text('utf-8').partition('## Examples by logger\n')[2]
    return read_commands(section.partition('\n## ')[0])


@pytest.mark.parametrize('words', examples(), ids=lambda words: words[1])
def test_an_example_makes_a_bag_of_both_sensors(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    for name in words:
        if name.endswith('.parquet'):
            write_parquet(name)
        elif name in FILES:
            head, line = FILES[name]
            Path(name).write_text(head + ''.join(line(*second) for second in seconds()))
    assert main(words) == 0
    out = capsys.readouterr().out
    assert f': {N} headings on ts/heading' in out and f': {N} headings on rs/heading' in out
    assert main(['analyze', 'trial', '--set', 'norms.sigma_max_deg=0.3', '--set',
                 'norms.sigma_ref_max_deg=0.1', '--json', 'v.json', '--quiet']) == 0
    run, = json.loads(Path('v.json').read_text())['runs']
    # A heading of 1e-4 rad is 0.006 degrees off at most.
    assert run['n'] >= N - 12 and run['mean_deg'] == pytest.approx(0.1, abs=0.006)
    hours = 2 if 'clock.csv' in words else 0
    begin_ns = (EPOCH_S - 3600 * hours) * 10 ** 9
    # The days of UNIXD have seven decimals, which are 9 ms.
    assert -10 ** 7 < run['start_ns'] - begin_ns < 20 * 10 ** 9


def test_every_file_of_the_examples_is_written_here():
    named = {word for words in examples() for word in words
             if Path(word).suffix and not word.startswith(('-', '/dev'))}
    assert named == {*FILES, 'pandas.parquet'}
