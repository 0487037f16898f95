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

"""A receiver of GPS that missed rollovers of the weeks, and stamps far from any trial."""

from __future__ import annotations

from datetime import datetime, timedelta, timezone

from checksums import with_checksum, with_long_checksum
import pytest

from heading_intercompare.cli.program import main
from heading_intercompare.drivers.log_lines.rollovers import describe_far
from heading_intercompare.drivers.logs import LogReader, read_log
from heading_intercompare.drivers.motion.motion_log import read_log_motion
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings

S = 10**9
#: The true times of the readings: over midnight, into 2026-03-01.
TRUE = [datetime(2026, 2, 28, 23, 59, 58, tzinfo=timezone.utc) + timedelta(seconds=k)
        for k in range(4)]
TRUE_NS = [int(true.timestamp()) * S for true in TRUE]
WEEKS = timedelta(weeks=1024)
HDT = with_checksum('HEHDT,12.5,T')


def zda(at: datetime) -> str:
    return with_checksum(f'GPZDA,{at:%H%M%S}.00,{at:%d,%m,%Y},,')


def rmc(at: datetime) -> str:
    return with_checksum(f'GPRMC,{at:%H%M%S}.00,A,5900.0,N,01000.0,E,9.5,218.5,{at:%d%m%y},,')


def receiver_log(at: datetime) -> str:
    """Return a log with the week of GPS and its second, 18 s ahead of UTC."""
    gps = at + timedelta(seconds=18) - datetime(1980, 1, 6, tzinfo=timezone.utc)
    second = gps.total_seconds() - gps.days // 7 * 604800
    return '#' + with_long_checksum(
        f'HEADINGA,COM1,0,39.5,FINESTEERING,{gps.days // 7},{second:.3f},0,f9bf,6521;'
        'SOL_COMPUTED,L1_INT,5.92,12.5,-1.3,0,0.2,0.3,"0",18')


def reading(telling, at: datetime) -> list[str]:
    """Return the sentences of a heading with its time."""
    return [telling(at)] if telling is receiver_log else [telling(at), HDT]


def write(path, telling, early, stamp='{:%Y-%m-%dT%H:%M:%SZ} ', shift=timedelta()):
    """Write a log whose receiver tells times too early, and whose logger has a clock."""
    lines = [stamp.format(at + shift) + sentence
             for at in TRUE for sentence in reading(telling, at - early)]
    path.write_text('\r\n'.join(lines) + '\r\n')
    return path


@pytest.mark.parametrize('telling', [zda, rmc, receiver_log])
@pytest.mark.parametrize('n', [0, 1, 2])
@pytest.mark.parametrize('shift', [timedelta(), timedelta(hours=12), timedelta(hours=-10)])
def test_the_stamps_of_the_lines_undo_it(telling, n, shift, tmp_path):
    """Their clock may be in any zone: the time is still that of the receiver."""
    log = write(tmp_path / 'a.log', telling, n * WEEKS, shift=shift)
    reader = LogReader(log, DriverSettings(time='validity'))
    assert [int(ns) for chunk in reader for ns in chunk.stamp_ns] == TRUE_NS
    assert [f'{1024 * n} weeks early' in words for words in reader.remarks] == [True] * (n > 0)


@pytest.mark.parametrize('telling', [zda, rmc, receiver_log])
@pytest.mark.parametrize('name, date', [
    ('a.log', '2026-02-28'), ('gyro_2026-02-28.log', None), ('20260228_gyro.log', None)])
def test_a_date_undoes_it_where_lines_have_no_stamps(telling, name, date, tmp_path):
    log = write(tmp_path / name, telling, WEEKS, stamp='')
    reader = LogReader(log, DriverSettings(time='validity', date=date))
    assert [int(ns) for chunk in reader for ns in chunk.stamp_ns] == TRUE_NS
    assert any('undone by the date' in words for words in reader.remarks)


def test_a_time_of_day_on_the_lines_falls_on_the_day_after_it_is_undone(tmp_path):
    """Before, ZDA moved such lines by 1024 weeks, whatever date was given."""
    log = write(tmp_path / 'a.log', zda, WEEKS, stamp='{:%H:%M:%S} ')
    headings, _ = read_log(log, DriverSettings(date='2026-02-28'))
    assert headings.stamp_ns.tolist() == TRUE_NS


@pytest.mark.parametrize('telling, early, stamp, date', [
    (zda, WEEKS, '', None), (zda, WEEKS + timedelta(days=3), '{:%Y-%m-%dT%H:%M:%SZ} ', None),
    (rmc, timedelta(weeks=1020), '{:%Y-%m-%dT%H:%M:%SZ} ', None),
    (zda, WEEKS, '', '2026-02-20'), (zda, -WEEKS, '{:%Y-%m-%dT%H:%M:%SZ} ', None)])
def test_a_time_stays_as_told_unless_a_clock_says_otherwise(telling, early, stamp, date, tmp_path):
    log = write(tmp_path / 'a.log', telling, early, stamp)
    headings, _ = read_log(log, DriverSettings(time='validity', date=date))
    assert headings.stamp_ns.tolist() == [ns - int(early.total_seconds()) * S for ns in TRUE_NS]


def test_a_date_holds_for_a_log_of_weeks_and_until_the_receiver_is_right(tmp_path):
    days = [TRUE[0] + timedelta(days=5 * k) for k in range(4)]
    log = tmp_path / 'a.log'
    log.write_text(''.join(f'{zda(at - WEEKS * (k < 3))}\n{HDT}\n' for k, at in enumerate(days)))
    headings, _ = read_log(log, DriverSettings(time='validity', date='2026-02-28'))
    assert headings.stamp_ns.tolist() == [int(at.timestamp()) * S for at in days]


@pytest.mark.parametrize('telling', [zda, rmc, receiver_log])
def test_the_time_of_receipt_undoes_it_live(telling):
    decoder = NmeaDecoder(DriverSettings(source='udp://:1', time='validity', learn_s=0.0))
    chunks = [decoder.feed('\r\n'.join([*reading(telling, at - WEEKS), '']).encode(), ns + S // 2)
              for at, ns in zip(TRUE, TRUE_NS)]
    assert [int(ns) for chunk in chunks for ns in chunk.stamp_ns] == TRUE_NS
    assert "undone by the logger's clock" in decoder.undone


def test_the_motion_of_the_ship_has_the_same_times(tmp_path):
    log = write(tmp_path / 'a.log', rmc, WEEKS)
    motion = read_log_motion(log, DriverSettings(time='validity'))
    assert motion.rows['fix'].stamp_ns.tolist() == TRUE_NS


@pytest.mark.parametrize('first, last, says', [
    ('2026-03-01', '2026-03-02', ''), ('2090-05-01', '2090-05-02', '2090-05-02'),
    ('2026-03-01', '2026-11-30', 'in the future'), ('2026-03-01', '2026-11-27', ''),
    ('1980-01-06', '2026-03-01', '1980-01-06 00:00:00.000 is before 2000'),
    ('1999-08-22', '1999-08-22', 'before 2000'), ('1970-01-02', '1970-05-01', '')])
def test_a_stamp_far_from_any_trial_is_said(first, last, says):
    """One that counts from a start, within a year of 1970, is none."""
    first_ns, last_ns, now_ns = (int(datetime.fromisoformat(f'{day}T00:00:00+00:00').timestamp())
                                 * S for day in (first, last, '2026-11-27'))
    words = describe_far(first_ns, last_ns, now_ns)
    assert says in words and bool(words) == bool(says)


def test_the_command_says_it_with_what_to_do(tmp_path, capsys):
    far, rolled = tmp_path / 'far.log', tmp_path / 'rolled.log'
    write(far, zda, timedelta(days=-365 * 11), stamp='')
    write(rolled, zda, WEEKS)
    assert main(['import-nmea', '--ts', str(far), '--rs', str(rolled), '--time', 'validity',
                 '-o', str(tmp_path / 'bag')]) == 0
    said = ''.join(capsys.readouterr())
    assert 'the stamp 2037-02-26 00:00:01.000 is in the future' in said
    assert 'another one with --time, or shift the stamps' in said
    assert '1024 weeks early, such as 2006-07-15 23:59:58.000: undone' in said
