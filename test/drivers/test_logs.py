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

"""Whole logs: made for the tests (test/data/nmea), and real ones with known contents."""

from __future__ import annotations

import json
import math
from pathlib import Path

from checksums import with_checksum
from drivers.test_framing import LOG
import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.logs import is_log, LogReader, read_log
from heading_intercompare.drivers.sentence_choice import find_sentence
from heading_intercompare.drivers.settings import DriverError, DriverSettings

DATA = Path(__file__).resolve().parent.parent / 'data' / 'nmea'
S = 1_000_000_000
NOON = 1772366400 * S   # 2026-03-01T12:00:00Z
NBP, LMG, REPLAY = 'nbp1406/NBP1406_', 'lmg1903/LMG1903_', 'nbp1700_replay/NBP1700_'
FILES = {'gyr1': NBP + 'gyr1-2014-08-01', 's330': NBP + 's330-2014-08-01',
         'seap': NBP + 'seap-2014-08-01', 'adcp': NBP + 'adcp-2014-08-01',
         'gp02': NBP + 'gp02-2014-08-01', 'lgyr': LMG + 'lgyr.d085', 'lsep': LMG + 'lsep.d085'}

MAGNETIC = ('other_sentence.HDM', 'other_sentence.VHW')


def n_lines(path) -> int:
    return sum(bool(line.strip()) for line in path.read_bytes().splitlines())


def test_a_log_that_has_suffered_gives_what_is_sound_and_counts_the_rest():
    headings, counts = read_log(DATA / 'damaged.log')
    assert headings == Headings.of(
        [NOON, NOON + 700_000_000, NOON + 1_200_000_000, NOON + 1_400_000_000],
        [10.1, 10.7, 11.2, 11.4])
    assert counts == {
        'bad_checksum': 1, 'bad_field': 1, 'bad_stamp': 1, 'cut': 1, 'empty_heading': 1,
        'no_checksum': 1, 'no_sentence': 1, 'no_stamp': 1, 'not_heading': 1, 'not_true': 1,
        'other_sentence.PSXN,23': 1, 'other_talker.GP': 1, 'out_of_range': 1}


def test_tag_blocks_stamp_the_lines_of_a_log_without_other_stamps():
    headings, counts = read_log(DATA / 'tagged.log')
    assert headings == Headings.of([NOON, NOON + 250_000_000, NOON + S], [100.1, 100.2, 100.5])
    assert counts == {'invalid_mode.V': 1, 'no_stamp': 1}


@pytest.mark.parametrize('kind, time, first_ns', [
    ('HDT', 'receipt', 422_000_000), ('PSXN,23', 'receipt', 450_000_000),
    ('HDT', 'validity', 170_000_000), ('PSXN,23', 'validity', 170_000_000)])
def test_receipt_and_validity_of_the_same_bursts(kind, time, first_ns):
    headings, counts = read_log(DATA / 'burst_iso.log', DriverSettings(sentence=kind, time=time))
    assert headings == Headings.of([NOON + first_ns + i * S for i in range(4)],
                                   [12.34, 12.41, 359.98, 0.0])
    other = 'PSXN,23' if kind == 'HDT' else 'HDT'
    assert counts == {'not_heading': 8, f'other_sentence.{other}': 4}


def test_a_form_of_stamp_that_the_log_does_not_have_gives_no_stamp():
    headings, counts = read_log(DATA / 'burst_iso.log', DriverSettings(stamp_format='doy'))
    assert len(headings) == 0 and counts['no_stamp'] == 4


@pytest.mark.parametrize('name', ['damaged.log', 'tagged.log', 'burst_iso.log'])
@pytest.mark.parametrize('block_bytes', [1, 2, 7, 64, 1000])
def test_the_size_of_the_blocks_changes_nothing(name, block_bytes):
    reader = LogReader(DATA / name, block_bytes=block_bytes)
    chunks = list(reader)
    assert (Headings.concatenate(chunks), reader.counts) == read_log(DATA / name)
    assert reader.position == reader.size == (DATA / name).stat().st_size


def test_the_choice_looks_at_the_whole_log(tmp_path):
    log = tmp_path / 'late.log'
    log.write_bytes(b'1772366400 $HEHDT,1.0,T*2E\n' * 5 + b'1772366401 $HETHS,2.0,A*2F\n')
    headings, counts = read_log(log)
    assert headings == Headings.of([NOON + S], [2.0])
    assert counts == {'other_sentence.HDT': 5}


def test_a_damaged_sentence_does_not_decide_the_choice(tmp_path):
    log = tmp_path / 'damaged.log'
    log.write_bytes(b'1772366400 $HETHS,2.0,A*00\n1772366400 $HETHS,2.0,A\n'
                    b'1772366401 $HEHDT,1.0,T*2E\n')
    headings, counts = read_log(log)
    assert headings == Headings.of([NOON + S], [1.0])
    assert counts == {'bad_checksum': 1, 'no_checksum': 1}


@pytest.mark.slow
def test_the_choice_finds_a_rare_talker_behind_many_lines_of_another(tmp_path):
    log = tmp_path / 'long.log'
    log.write_bytes(b'1772366400 $HEHDT,1.0,T*2E\n' * 200_000 + b'1772366401 $GPHDT,2.0,T*37\n')
    files = LogFiles(str(log))
    name = find_sentence(files.bare_blocks(), DriverSettings(talker='GP'))
    assert name == ('HDT', 'GP')
    assert find_sentence(files.bare_blocks(), DriverSettings(talker='IN')) is None
    assert find_sentence(files.bare_blocks(), DriverSettings(sentence='THS')) is None


@pytest.mark.parametrize('end', [b'\n', b'\r\n', b'\r'])
def test_any_line_end_will_do(tmp_path, end):
    log = tmp_path / 'ends.log'
    log.write_bytes(end.join([b'# HDT, of a ship', b'1772366400 $HEHDT,1.0,T*2E',
                              b'1772366401 $HEHDT,2.0,T*2D']))
    headings, counts = read_log(log)
    assert headings == Headings.of([NOON, NOON + S], [1.0, 2.0]) and counts == {'no_sentence': 1}


def test_a_log_without_headings_gives_none_and_its_counts(tmp_path):
    log = tmp_path / 'rot.log'
    log.write_bytes(b'$HEROT,0.5,A*2E\n')
    headings, counts = read_log(log)
    assert headings == Headings.empty() and counts == {'not_heading': 1}


def test_an_empty_log_is_an_error_that_names_it(tmp_path):
    log = tmp_path / 'empty.log'
    log.touch()
    with pytest.raises(DriverError, match=r'empty\.log: no lines'):
        read_log(log)


def test_a_missing_log_is_the_error_of_the_system_and_an_empty_folder_says_so(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_log(tmp_path / 'none.log')
    with pytest.raises(DriverError, match='no file with anything in it'):
        read_log(tmp_path)


def check_stream(headings: Headings, stream: dict) -> None:
    assert len(headings) == stream['n']
    assert (headings.stamp_ns[0], headings.stamp_ns[-1]) == (
        stream['first_ns'], stream['last_ns'])
    assert (headings.heading_deg[0], headings.heading_deg[-1]) == (
        stream['h_first'], stream['h_last'])
    assert math.fsum(headings.heading_deg) == pytest.approx(stream['h_sum'], rel=1e-12)


@pytest.mark.parametrize('data_set, name, kind, counts', [
    ('NBP1406', 'gyr1', 'auto', {}),
    ('NBP1406', 's330', 'auto', {'not_heading': 3750, 'other_sentence.PSXN,23': 625}),
    ('NBP1406', 'seap', 'HDT', {'not_heading': 3572, 'other_sentence.PSXN,23': 714}),
    ('NBP1406', 'adcp', 'auto', {}),
    ('LMG1903', 'lgyr', 'auto', {}),
    ('LMG1903', 'lsep', 'auto', {'not_heading': 8000}),
    ('NBP1406_zda', 's330', 'auto', {'not_heading': 3750, 'other_sentence.PSXN,23': 625}),
    ('NBP1406_zda', 'seap', 'auto', {'not_heading': 3572, 'other_sentence.PSXN,23': 714}),
])
def test_ship_logs_give_what_independent_programs_found(shared_data, data_set, name, kind, counts):
    golden = json.loads((shared_data / 'golden_nbp1406_lmg1903.json').read_text('utf-8'))
    time = 'validity' if data_set.endswith('_zda') else 'receipt'
    headings, found = read_log(shared_data / FILES[name],
                               DriverSettings(sentence=kind, time=time))
    check_stream(headings, golden['sets'][data_set]['streams'][name])
    assert found == counts
    assert len(headings) + sum(found.values()) == n_lines(shared_data / FILES[name])


@pytest.mark.parametrize('name, time, n, counts', [
    (REPLAY + 's330-2017-11-04', 'receipt', 1245,
     {'bad_checksum': 2490, 'not_heading': 4982, 'other_sentence.PSXN,23': 1245}),
    (REPLAY + 's330-2017-11-04', 'validity', 1245,
     {'bad_checksum': 2490, 'not_heading': 4982, 'other_sentence.PSXN,23': 1245}),
    (REPLAY + 'seap-2017-11-04', 'validity', 1628,
     {'not_heading': 8144, 'other_sentence.PSXN,23': 1629}),
    (REPLAY + 'gyr1-2017-11-04', 'receipt', 15668, {}),
    (REPLAY + 'adcp-2017-11-04', 'receipt', 12465, {}),
    (FILES['gp02'], 'receipt', 0, {'no_checksum': 5000}),
    ('gpsd/hemi.log', 'receipt', 0,
     {'empty_heading': 211, 'no_sentence': 2, 'no_stamp': 4, 'not_heading': 538}),
    ('gpsd/hemi.log', 'validity', 2,
     {'empty_heading': 211, 'no_sentence': 2, 'no_validity_time': 2, 'not_heading': 538}),
    ('gpsd/bundg_zeus_9.log', 'receipt', 0,
     {'no_sentence': 10, 'no_stamp': 1457, 'not_heading': 3392, 'other_sentence.VHW': 150}),
    ('gpsd/bundg_zeus_9.log', 'validity', 147,
     {'no_sentence': 10, 'no_validity_time': 1310, 'not_heading': 3392,
      'other_sentence.VHW': 150}),
    ('signalk/plaka_first4000.log', 'receipt', 0,
     {'empty_heading': 500, 'not_heading': 3000, **dict.fromkeys(MAGNETIC, 250)}),
    ('signalk/plaka_first4000.log', 'validity', 0,
     {'bad_time': 250, 'empty_heading': 500, 'not_heading': 2750, **dict.fromkeys(MAGNETIC, 250)}),
])
def test_the_lines_of_ship_logs_are_all_accounted_for(shared_data, name, time, n, counts):
    headings, found = read_log(shared_data / name, DriverSettings(time=time))
    assert (len(headings), found) == (n, counts)
    assert n + sum(found.values()) == n_lines(shared_data / name)


def test_replayed_data_have_their_true_time_in_zda(shared_data):
    """Replayed at one line per 0.255 s; the sensor's own time advances by whole seconds."""
    headings, _ = read_log(shared_data / (REPLAY + 's330-2017-11-04'),
                           DriverSettings(time='validity'))
    steps_ns, n = np.unique(np.diff(headings.stamp_ns), return_counts=True)
    assert headings.stamp_ns[0] == 1407369600170000000
    assert steps_ns[np.argmax(n)] == S and steps_ns[0] > 0


def test_a_magnetic_compass_is_turned_by_its_variation(shared_data):
    headings, _ = read_log(shared_data / 'gpsd/bundg_zeus_9.log', DriverSettings(time='validity'))
    assert headings.heading_deg[0] == pytest.approx(231.6 + 1.3, abs=1e-9)
    assert headings.stamp_ns[0] == 1534758457 * S   # 2018-08-20 09:47:37


#: The talkers of a log, one line a second, and the talkers that take turns with the first.
TURNS = [(['GN'] * 9 + ['GP'] * 9 + ['GN'] * 9, 'GN,GP'), (['GP'] * 9 + ['GN'] * 3, 'GP,GN'),
         (['GN'] * 9 + ['GP'] * 4 + ['GL'] * 4, 'GN,GP,GL'), (['GN', 'GP'] * 9, None),
         ((['GP'] * 10 + ['GN']) * 3, None), (['GN'] * 9 + ['GP'], None),
         (['HE'] * 9 + ['GP'] * 9, None)]


@pytest.mark.parametrize('talkers, together', TURNS)
def test_a_log_says_which_talkers_of_gnss_send_in_turns(talkers, together, tmp_path):
    (tmp_path / 'a.log').write_text(''.join(
        f'2026-03-01T12:00:{second:02d}Z {with_checksum(f"{talker}HDT,{second}.0,T")}\n'
        for second, talker in enumerate(talkers)))
    reader = LogReader(tmp_path / 'a.log')
    n = sum(map(len, reader))
    assert n == talkers.count(talkers[0])
    assert [remark.rpartition(' ')[2] for remark in reader.remarks] == (
        [together] if together else [])
    if together:
        headings, _ = read_log(tmp_path / 'a.log', DriverSettings(talker=together))
        assert len(headings) == len(talkers)


@pytest.mark.parametrize('line', ['$23HDT,1.0,T*2F', '$F3HDT,1.0,T*5F', LOG.decode()])
def test_a_file_of_unusual_sentences_is_a_log(line, tmp_path):
    (tmp_path / 'a.log').write_text(line + '\n')
    assert is_log(tmp_path / 'a.log')


def test_only_a_file_that_begins_with_sentences_or_headings_is_a_log(tmp_path):
    for name, content, expected in (
            ('gyro', b'x\n2014 $HEHDT,218.53,T*12\n', True),
            ('a.csv', b't_ns,heading_deg\n', True),
            ('pairs.csv', b'stamp_ns,ts_deg,rs_deg\n', False), ('empty', b'', False),
            ('other', b'\x89MCAP0\r\n $HEHDT,1,T*12', False), ('b.mcap', b'$HEHDT,1,T', False)):
        (tmp_path / name).write_bytes(content)
        assert is_log(tmp_path / name) is expected, name
    assert not is_log(tmp_path) and not is_log(tmp_path / 'nowhere.log')
