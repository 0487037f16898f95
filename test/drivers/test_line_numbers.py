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

"""The numbers of lines in TAG blocks: repeats and old lines, restarts, gaps; a second sender."""

from __future__ import annotations

from contextlib import closing
import socket

from drivers.receiving import free_port, read_until, sentence
import pytest

from heading_intercompare.core.alarms.sentence_watch import SENDER_CHANGES, SentenceWatch
from heading_intercompare.drivers.alerts.alert_sentences import tag
from heading_intercompare.drivers.line_numbers import LineNumbers, SenderTurns
from heading_intercompare.drivers.logs import LogReader, read_log
from heading_intercompare.drivers.motion.motion_decoder import MotionDecoder
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.drivers.sources import open_source

T0_NS = 1_772_366_400_000_000_000
STEP_NS = 100_000_000
UDP = DriverSettings(source='udp://:1', sentence='HDT')


def number_of(place):
    """Return the number of a line by its place from 0: after 999 comes 1."""
    return place % 999 + 1


def line(number, heading_deg, source='HE0001', talker='HE', more=()):
    """Return a line of IEC 61162-450."""
    tags = tag([f's:{source}', f'n:{number}', *more])
    return b'UdPbC\0' + tags + sentence(f'{talker}HDT,{heading_deg % 360:.1f},T')


def lines_of(places, **kwargs):
    """Return a line for each place: each has a number and a heading of its own."""
    return [line(number_of(place), 0.1 * place, **kwargs) for place in places]


def read(lines, step_ns=STEP_NS, settings=UDP):
    """Return the headings in tenths of a degree that a live decoder takes, and the decoder."""
    decoder, tenths = NmeaDecoder(settings), []
    for at, data in enumerate(lines):
        tenths += decoder.feed(data, T0_NS + at * step_ns).heading_deg.tolist()
    tenths += decoder.flush().heading_deg.tolist()
    return [round(10 * heading_deg) for heading_deg in tenths], decoder


def tenths_of(places):
    return [place % 3600 for place in places]


def interleave(first, second):
    return [data for pair in zip(first, second) for data in pair]


def echo(lines, delay):
    """Return lines, each followed by the one that came some lines before."""
    return lines[:delay] + interleave(lines[delay:], lines)


@pytest.mark.parametrize('delay', [1, 3, 30, 300])
def test_each_datagram_sent_a_second_time_is_rejected(delay):
    """The first steps prove the numbering; from then on no copy is taken."""
    places = range(700)
    tenths, decoder = read(echo(lines_of(places), delay))
    taken = tenths[max(delay, 20):]
    assert [tenth for tenth, before in zip(taken[1:], taken) if tenth <= before] == []
    assert decoder.counts['repeated'] >= 700 - delay - 8
    assert set(tenths) == set(tenths_of(places)) and decoder.numbers.n_missing == 0


def test_two_network_paths_give_each_reading_once_and_none_late():
    places = range(2100)
    decoder, tenths = NmeaDecoder(UDP), []
    for at, data in enumerate(lines_of(places)):
        for path_ns in (0, 1_000_000):
            tenths += decoder.feed(data, T0_NS + at * STEP_NS + path_ns).heading_deg.tolist()
    decoder.flush()
    assert len(tenths) <= 2100 + 8 and decoder.counts['repeated'] >= 2100 - 8
    assert decoder.numbers.n_late == 0 and decoder.senders.n_changes == 0


def test_lines_of_a_forger_behind_the_newest_number_are_rejected():
    sound = lines_of(range(500))
    tenths, decoder = read(sound[:20] + interleave(sound[20:], [
        line(number_of(place), 200.0) for place in range(0, 480)]))
    assert tenths == tenths_of(range(500)) and decoder.counts == {'old_number': 480}


def test_a_forged_jump_ahead_does_not_make_the_sensor_deaf():
    """One number 400 ahead is taken; then the lines before it go on, and none is missing."""
    sound = lines_of(range(100))
    tenths, decoder = read([*sound[:50], line(number_of(450), 200.0), *sound[50:]])
    assert tenths == [*tenths_of(range(50)), 2000, *tenths_of(range(50, 100))]
    assert decoder.numbers.n_missing == 0


@pytest.mark.parametrize('first, n', [(0, 100), (400, 300), (990, 40), (0, 2500)])
def test_numbers_that_go_on_over_999_refuse_nothing(first, n):
    places = range(first, first + n)
    tenths, decoder = read(lines_of(places))
    assert tenths == tenths_of(places) and decoder.counts == {}
    assert decoder.numbers.n_missing == 0


@pytest.mark.parametrize('before', [20, 300, 700, 998])
def test_a_sender_that_restarts_at_1_loses_no_reading(before):
    """Also with the stamps that the readings had: they wait for the eighth one."""
    data = [*lines_of(range(before)),
            *[line(number, 100.0 + 0.1 * number) for number in range(1, 40)]]
    decoder = NmeaDecoder(UDP)
    chunks = [decoder.feed(datagram, T0_NS + at * STEP_NS)
              for at, datagram in enumerate(data)]
    stamps_ns = [ns for chunk in chunks for ns in chunk.stamp_ns.tolist()]
    assert stamps_ns == [T0_NS + at * STEP_NS for at in range(len(data))]
    assert decoder.counts == {} and decoder.lines == len(data)


def test_a_sender_that_restarts_alongside_a_quay_is_heard_within_64_lines():
    """Every line is word for word one that came before."""
    data = [line(number, 90.0) for number in range(1, 101)]
    tenths, decoder = read(data * 2)
    assert len(tenths) == 200 and decoder.counts == {}


@pytest.mark.parametrize('numbers', [
    [1], [1, 2, 3], [7, 7, 8, 8], [5, 3], [999], [1000, 1001], [0], [157036]])
def test_numbers_that_number_nothing_refuse_nothing(numbers):
    data = [line(number, 0.1 * at) for at, number in enumerate(numbers * 60)]
    tenths, decoder = read(data)
    assert tenths == tenths_of(range(len(data))) or numbers == [7, 7, 8, 8]
    assert len(tenths) == len(data) and decoder.counts == {}


def test_a_damaged_tag_block_numbers_nothing():
    data = [datagram.replace(b'n:', b'n;') for datagram in lines_of(range(60))]
    tenths, decoder = read(data + data)
    assert len(tenths) == 120 and decoder.counts == {}


def test_two_sources_and_two_talkers_number_for_themselves():
    places = range(200)
    data = interleave(lines_of(places), lines_of(range(500, 700), source='GP0001', talker='GP'))
    tenths, decoder = read(data)
    assert tenths == tenths_of(places) and decoder.counts == {'other_talker.GP': 200}


def test_one_source_that_numbers_for_each_destination_loses_nothing():
    """The log of two groups: headings and rates, each with numbers of their own."""
    rates = [tag(['s:HE0001', f'n:{number_of(place)}']) + sentence('HEROT,1.0,A')
             for place in range(600, 800)]
    tenths, decoder = read(interleave(lines_of(range(200)), rates))
    assert tenths == tenths_of(range(200)) and decoder.counts == {'not_heading': 200}


def test_sentences_under_one_tag_block_have_one_fate():
    data = [tag(['s:HE0001', f'n:{place + 1}']) + sentence(f'HEHDT,{place / 10:.1f},T').strip()
            + sentence('HEROT,1.0,A') for place in range(100)]
    tenths, decoder = read(data)
    assert tenths == tenths_of(range(100)) and decoder.counts == {'not_heading': 100}


@pytest.mark.parametrize('lost, n_missing', [
    ([50], 1), ([50, 51, 52], 3), ([30, 60, 61], 3), (range(998, 1003), 5), ([], 0)])
def test_lines_missing_by_their_numbers_are_counted(lost, n_missing):
    places = [place for place in range(1100) if place not in lost]
    tenths, decoder = read(lines_of(places))
    assert tenths == tenths_of(places) and decoder.numbers.n_missing == n_missing


@pytest.mark.parametrize('start', [0, 90, 980])
def test_lines_in_another_order_are_not_missing(start):
    """Before, a line that came behind later ones of its datagrams was lost at the source, too."""
    data = []
    for place in range(start, start + 800):
        text = sentence(f'HEHDT,{place / 10 % 360:.1f},T') if place % 4 == 0 else sentence(
            'HEROT,1.0,A')
        data.append(tag(['s:HE0001', f'n:{number_of(place)}']) + text)
    for at in range(101, 700, 48):
        data[at:at + 3] = data[at + 2], data[at], data[at + 1]
    tenths, decoder = read(data)
    headings = [place for place in range(start, start + 800) if place % 4 == 0]
    assert tenths == tenths_of(headings) and decoder.numbers.n_missing == 0


def test_a_heading_behind_a_later_one_is_rejected_and_not_missing_too():
    places = [*range(100), 101, 102, 100, *range(103, 200)]
    tenths, decoder = read(lines_of(places))
    assert tenths == tenths_of([place for place in range(200) if place != 100])
    assert decoder.counts == {'old_number': 1} and decoder.numbers.n_missing == 0


def test_other_sentences_of_the_source_fill_its_numbers():
    """Of three lines in turn one is a heading: no line is missing."""
    data = []
    for place in range(300):
        data.append(lines_of([place])[0] if place % 3 == 0 else tag(
            ['s:HE0001', f'n:{number_of(place)}']) + sentence('HEROT,1.0,A'))
    tenths, decoder = read(data)
    assert tenths == tenths_of(range(0, 300, 3)) and decoder.numbers.n_missing == 0


def test_a_log_gives_the_headings_and_counts_of_the_live_line(tmp_path):
    """With gaps, a second copy of each line, and a restart; stamps are those of the lines."""
    data = []
    for at, place in enumerate([*range(100), *range(110, 200)]):
        more = [f'c:{T0_NS // 10 ** 9 + at}']
        data += lines_of([place], more=more) * 2
    data += [line(number, 50.0 + 0.1 * number, more=[f'c:{T0_NS // 10 ** 9 + 300 + number}'])
             for number in range(1, 50)]
    log = tmp_path / 'ship.nmea'
    log.write_bytes(b''.join(datagram[6:] for datagram in data))
    settings = DriverSettings(sentence='HDT')
    headings, counts = read_log(str(log), settings)
    tenths, decoder = read(data)
    assert [round(10 * heading) for heading in headings.heading_deg.tolist()] == tenths
    assert counts == decoder.counts and counts['repeated'] > 170
    assert len(headings) + sum(counts.values()) == len(data)
    reader = LogReader(str(log), settings)
    assert sum(map(len, reader)) == len(headings)
    assert any('10 lines missing by the numbers' in words for words in reader.remarks)


def test_the_next_file_of_a_log_numbers_for_itself(tmp_path):
    for name, first in (('a', 0), ('b', 300), ('c', 50)):
        (tmp_path / f'{name}.nmea').write_bytes(b''.join(lines_of(
            range(first, first + 20), more=[f'c:{T0_NS // 10 ** 9 + 100 * ord(name)}'])))
    headings, counts = read_log(str(tmp_path), DriverSettings(sentence='HDT', bursts='accept'))
    assert len(headings) == 60 and counts == {}


def test_the_motion_of_the_ship_is_read_once():
    decoder, n = MotionDecoder(DriverSettings(source='udp://:1', learn_s=0.0)), 0
    for place in range(100):
        rate = tag(['s:HE0001', f'n:{place + 1}']) + sentence(f'HEROT,{place / 10:.1f},A')
        for _ in range(2):
            n += len(decoder.feed(rate, T0_NS + place * STEP_NS).rate_deg_s)
    assert n <= 108 and decoder.counts['repeated'] == 200 - n


def test_names_without_end_take_no_memory():
    numbers = LineNumbers()
    for source in range(10_000):
        numbers.refuse(tag([f's:{source}', 'n:1']), b'HEHDT,1.0,T', None)
    assert len(numbers._by_kind) <= 64 and len(numbers._by_source) <= 64


@pytest.mark.parametrize('names, n_changes', [
    ('AAAA', 0), ('AAABBB', 1), ('ABABAB', 5), ('AABAAAB', 3)])
def test_changes_of_the_sender_are_counted(names, n_changes):
    turns = SenderTurns()
    for name in names:
        turns.hear(name)
    assert turns.n_changes == n_changes and len(turns.names) == len(set(names))


@pytest.mark.parametrize('numbered, host, delay, changes', [
    (False, '127.0.0.2', 3, True), (True, '127.0.0.2', 3, False), (False, '127.0.0.1', 0, False)])
def test_a_second_sender_over_the_loopback(numbered, host, delay, changes):
    """Without numbers the addresses take turns; with numbers no copy is taken."""
    settings = DriverSettings(
        source=f'udp://127.0.0.1:{free_port(socket.SOCK_DGRAM)}', sentence='HDT')
    data = lines_of(range(60)) if numbered else [
        sentence(f'HEHDT,{place / 10:.1f},T') for place in range(60)]
    decoder, tenths = NmeaDecoder(settings), []
    with closing(open_source(settings)) as source, socket.socket(
            socket.AF_INET, socket.SOCK_DGRAM) as sensor, socket.socket(
            socket.AF_INET, socket.SOCK_DGRAM) as second:
        second.bind((host, 0))
        for place, line_of_place in enumerate(data):
            copies = [(sensor, line_of_place)]
            if delay and place >= 20:
                copies.append((second, data[place - delay]))
            for sender, datagram in copies:
                sender.sendto(datagram, ('127.0.0.1', settings.address.port))
                for came in read_until(source, len):
                    tenths += decoder.feed(*came).heading_deg.tolist()
    assert len(tenths) == (60 if numbered or not delay else 100)
    assert (decoder.senders.n_changes > 0) is changes
    signs = SentenceWatch(None).look({SENDER_CHANGES: decoder.senders.n_changes}, 60, 0.0,
                                     decoder.senders.names)
    assert signs['second_sender'].active is changes
    if changes:
        assert '127.0.0.1' in signs['second_sender'].words and host in signs['second_sender'].words
