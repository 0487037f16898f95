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

"""A log played live: its pace, and that it gives the same headings as an import."""

from __future__ import annotations

from contextlib import closing
import gzip
from pathlib import Path

from checksums import with_checksum
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.playback import FileSource
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.drivers.sources import open_source

DATA = Path(__file__).resolve().parent.parent / 'data' / 'nmea'
S = 1_000_000_000
NOON = 1772366400 * S   # 2026-03-01T12:00:00Z


class Clock:
    """A clock that advances only when waited for."""

    def __init__(self):
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now

    def wait(self, seconds: float) -> None:
        assert seconds >= 0.0
        self.now += seconds


@pytest.fixture
def log(tmp_path):
    """Return the path of a log with one line per second, one of them without a stamp."""
    path = tmp_path / 'gyro.log'
    path.write_bytes(b'1772366400.0 $HEHDT,1.0,T*2E\n'
                     b'no stamp\n'
                     b'1772366401.0 $HEHDT,2.0,T*2D\n'
                     b'1772366402.0 $HEHDT,3.0,T*2C')
    return path


def play(path, clock, speed: float) -> FileSource:
    return FileSource(DriverSettings(source=f'file:{path}', speed=speed), clock=clock,
                      wait=clock.wait)


def test_lines_come_at_log_time_times_speed(log):
    clock = Clock()
    with closing(play(log, clock, 2.0)) as source:
        assert source.first_ns == source.origin_ns == NOON
        assert source.read(0.1) == [(b'1772366400.0 $HEHDT,1.0,T*2E\n', NOON, 0.0, str(log), ''),
                                    (b'no stamp\n', None, 0.0, None, '')]
        assert source.read(0.1) == [] and clock.now == pytest.approx(1000.1)
        assert [ns for _, ns, *_ in source.read(10.0)] == [NOON + S]
        assert clock.now == pytest.approx(1000.5) and not source.exhausted
        assert [ns for _, ns, *_ in source.read(10.0)] == [NOON + 2 * S]
        assert clock.now == pytest.approx(1001.0) and source.exhausted
        assert source.read(10.0) == [] and clock.now == pytest.approx(1001.0)
        assert source.status.endswith('end')


def test_the_clock_starts_with_the_first_read(log):
    clock = Clock()
    source = play(log, clock, 1.0)
    clock.now += 100.0
    assert len(source.read(0.0)) == 2
    source.close()
    assert source.exhausted and source.read(0.0) == []


def test_two_logs_with_the_same_origin_are_played_in_step(log):
    clock = Clock()
    with closing(play(log, clock, 1.0)) as source:
        source.origin_ns = NOON - 5 * S
        assert source.read(4.0) == []
        assert [ns for _, ns, *_ in source.read(4.0)] == [NOON, None]
        assert clock.now == pytest.approx(1005.0)


def test_at_speed_0_nothing_is_waited_for(log):
    clock = Clock()
    with closing(play(log, clock, 0.0)) as source:
        assert len(source.read(1.0)) == 4 and source.exhausted and clock.now == 1000.0


def test_a_log_without_stamps_is_not_paced(tmp_path):
    path = tmp_path / 'bare.log'
    path.write_bytes(b'$HEHDT,1.0,T*2E\n' * 1500)
    clock = Clock()
    with closing(play(path, clock, 1.0)) as source:
        assert source.first_ns is None
        assert [len(source.read(1.0)) for _ in range(3)] == [1000, 500, 0]
        assert clock.now == 1000.0


@pytest.mark.parametrize('name', ['damaged.log', 'tagged.log', 'burst_iso.log'])
@pytest.mark.parametrize('time', ['receipt', 'validity'])
def test_playing_a_log_gives_what_importing_it_gives(name, time):
    settings = DriverSettings(source=f'file:{DATA / name}', speed=0.0, time=time)
    decoder = NmeaDecoder(settings)
    chunks = []
    with closing(open_source(settings)) as source:
        while not source.exhausted:
            chunks += [decoder.feed(*came) for came in source.read(1.0)]
    chunks.append(decoder.flush())
    assert (Headings.concatenate(chunks), decoder.counts) == read_log(DATA / name, settings)


def test_ship_logs_played_give_what_importing_them_gives(shared_data):
    path = shared_data / 'nbp1700_replay' / 'NBP1700_s330-2017-11-04'
    settings = DriverSettings(source=f'file:{path}', speed=0.0)
    decoder = NmeaDecoder(settings)
    chunks = []
    with closing(open_source(settings)) as source:
        while not source.exhausted:
            chunks += [decoder.feed(*came) for came in source.read(1.0)]
    chunks.append(decoder.flush())
    assert (Headings.concatenate(chunks), decoder.counts) == read_log(path)


def test_a_log_that_cannot_be_played_says_why(tmp_path):
    empty, csv = tmp_path / 'empty.log', tmp_path / 'headings.csv'
    empty.touch()
    csv.write_text('t_ns,heading_deg\n1,2\n')
    with pytest.raises(DriverError, match=r'empty\.log: no lines'):
        open_source(DriverSettings(source=f'file:{empty}'))
    with pytest.raises(DriverError, match=r'headings\.csv: a csv cannot be played, only imported'):
        open_source(DriverSettings(source=f'file:{csv}'))
    with pytest.raises(FileNotFoundError):
        open_source(DriverSettings(source=f'file:{tmp_path / "none.log"}'))


FORMS = {
    'burst': '1772366400\n$HEHDT,1.0,T*2E\n$HEHDT,2.0,T*2D\n1772366401 $HEHDT,3.0,T*2C\n',
    'behind': '$HEHDT,1.0,T*2E,1772366400.5\n$HEHDT,2.0,T*2D,1772366401.5\n',
    'words': 'NAV 2026/03/01 12:00:00.5 GYRO $HEHDT,1.0,T*2E\n',
    'dates': '05/02/2024 12:00:00 $HEHDT,1.0,T*2E\n05/13/2024 12:00:00 $HEHDT,2.0,T*2D\n'}


@pytest.mark.parametrize('form', FORMS)
@pytest.mark.parametrize('encode', [bytes, gzip.compress, lambda text: text.decode().encode(
    'utf-16')])
def test_a_log_of_any_form_plays_as_it_is_imported(form, encode, tmp_path):
    path = tmp_path / 'a.log'
    path.write_bytes(encode(FORMS[form].encode()))
    check_playing(path)


def check_playing(path, **given):
    """Compare a log as it is played with the log as it is imported."""
    settings = DriverSettings(source=f'file:{path}', speed=0.0, **given)
    decoder, chunks = NmeaDecoder(settings), []
    with closing(open_source(settings)) as source:
        while not source.exhausted:
            chunks += [decoder.feed(*came) for came in source.read(1.0)]
    chunks.append(decoder.flush())
    found = Headings.concatenate(chunks)
    assert len(found) and (found, decoder.counts) == read_log(path, settings)


def test_a_folder_plays_as_it_is_imported(tmp_path):
    for day in ('20260301', '20260303'):
        (tmp_path / f'gyro_{day}.log').write_text('23:59:59 $HEHDT,1.0,T*2E\n'
                                                  '00:00:01 $HEHDT,2.0,T*2D')
    check_playing(tmp_path)


def test_a_log_without_stamps_is_paced_by_the_times_that_it_tells(tmp_path):
    path, clock = tmp_path / 'bare.log', Clock()
    told = [f'GPZDA,12000{k}.00,01,03,2026,,' for k in range(3)]
    path.write_text(''.join(f'{with_checksum(text)}\n$HEHDT,1.0,T*2E\n'
                            for text in told))
    settings = DriverSettings(source=f'file:{path}', time='validity')
    with closing(FileSource(settings, clock=clock, wait=clock.wait)) as source:
        assert source.first_ns == NOON
        assert [len(source.read(1.0)) for _ in range(3)] == [2, 2, 2]
        assert clock.now == pytest.approx(1002.0)
    check_playing(path, time='validity')


def test_two_instruments_of_one_talker_are_refused_until_one_is_chosen(tmp_path):
    """Played, their headings would be mixed into one stream; an import refuses them, too."""
    def sentence(body):
        return with_checksum(body)
    path = tmp_path / 'ship.log'
    path.write_text(''.join(
        f'2026-03-01T12:00:{at:02d}.000000Z {name} {sentence(f"HEHDT,{heading + at}.0,T")}\n'
        for at in range(20) for name, heading in (('GYRO1', 10), ('GYRO2', 40))))
    with pytest.raises(DriverError) as error:
        FileSource(DriverSettings(source=f'file:{path}'))
    assert 'HEHDT comes from several instruments: GYRO1 (20 headings), GYRO2' in str(error.value)
    for chosen in ('GYRO2', 'any'):
        settings = DriverSettings(source=f'file:{path}', instrument=chosen)
        assert FileSource(settings).first_ns == NOON
