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

"""Readings of a stream that have no stamp of their own are found, and stamped only by validity."""

from __future__ import annotations

from drivers.receiving import sentence
import pytest

from heading_intercompare.drivers.nmea import BurstFinder, NmeaDecoder
from heading_intercompare.drivers.sentences import Name
from heading_intercompare.drivers.settings import DriverSettings

S = 10 ** 9
NOON = 1_772_366_400 * S
HDT = Name('HDT', 'HE')


def hdt(heading):
    return sentence(f'HEHDT,{heading},T')


def zda(second):
    return sentence(f'GPZDA,12{second // 60:02d}{second % 60:05.2f},01,03,2026,,')


def decode(reads, source='tcp://127.0.0.1:1', **settings):
    """Return stamps in seconds after noon, headings, and the counts of reads of a stream."""
    decoder = NmeaDecoder(DriverSettings(source=source, sentence='HDT', **settings))
    found = []
    for at_s, data, *late_s in reads:
        chunk = decoder.feed(data, NOON + round(at_s * S), *late_s)
        found += zip(((chunk.stamp_ns - NOON) / S).tolist(), chunk.heading_deg.tolist())
    return found, decoder.counts


def test_one_reading_in_each_read_keeps_its_time():
    assert decode([(k, hdt(k)) for k in range(5)]) == ([(k, k) for k in range(5)], {})


def test_two_readings_in_one_read_are_a_burst():
    found, counts = decode([(0, hdt(0)), (3, hdt(1) + hdt(2) + hdt(3)), (4, hdt(4))])
    assert found == [(0, 0), (4, 4)] and counts == {'burst': 3}


def test_two_kinds_in_one_read_are_none():
    found, counts = decode([(k, hdt(k) + sentence(f'HETHS,{k},A')) for k in range(4)])
    assert len(found) == 4 and counts == {'other_sentence.THS': 4}


def test_a_second_reading_that_began_in_the_read_of_the_first_is_a_burst():
    text = hdt(2)
    found, counts = decode([(1, hdt(1) + text[:5]), (1.2, text[5:]), (2, hdt(3))])
    assert found == [(1, 1), (2, 3)] and counts == {'burst': 1}


def test_a_read_more_than_two_steps_late_is_a_burst_once_the_step_is_known():
    steady = [(k, hdt(k), 1.0) for k in range(5)]
    assert decode([*steady, (8, hdt(9), 2.5)]) == ([(k, k) for k in range(5)], {'burst': 1})
    assert decode([*steady, (8, hdt(9), 1.9)])[1] == {}
    assert decode([(0, hdt(1), 9.0)])[1] == {}, 'no step is known yet'


def test_a_sensor_that_pauses_is_no_burst():
    """The program was reading all the while, so the reading after the pause was not late."""
    found, counts = decode([*((k, hdt(k), 1.0) for k in range(5)), (30, hdt(9), 0.2)])
    assert found[-1] == (30, 9) and counts == {}


def test_a_burst_with_times_of_validity_gets_those_plus_the_usual_latency():
    """Each heading is valid 0.3 s before it is read; three of them wait until second 13."""
    steady = [(k + 0.3, zda(k) + hdt(k)) for k in range(10)]
    late = b''.join(zda(k) + hdt(k) for k in (10, 11, 12))
    found, counts = decode([*steady, (13.05, late)])
    assert found == [(pytest.approx(k + 0.3), k) for k in range(13)]
    assert counts == {'not_heading': 13}


def test_without_a_known_latency_a_time_of_validity_is_no_time_of_receipt():
    found, counts = decode([(13.05, b''.join(zda(k) + hdt(k) for k in (10, 11, 12)))])
    assert found == [] and counts == {'burst': 3, 'not_heading': 3}


@pytest.mark.parametrize('source', ['udp://:1', 'file:no'])
def test_datagrams_and_logs_have_stamps_of_their_own(source, monkeypatch):
    monkeypatch.setattr('heading_intercompare.drivers.nmea.find_sentence', lambda *_: HDT)
    stamp = b'' if source.startswith('udp') else b'2026-03-01T12:00:01Z '
    _, counts = decode([(1, stamp + hdt(1)), (1, stamp + hdt(2))], source)
    assert 'burst' not in counts


def test_stamps_in_the_lines_of_a_stream_are_kept():
    lines = b''.join(b'2026-03-01T12:00:0%dZ ' % k + hdt(k) for k in range(3))
    found, counts = decode([(30, lines)], stamp_format='iso')
    assert found == [(k, k) for k in range(3)] and counts == {}


def test_with_stamps_of_validity_no_reading_is_a_burst():
    reads = [(13, b''.join(zda(k) + hdt(k) for k in (10, 11, 12)))]
    found, counts = decode(reads, time='validity')
    assert found == [(k, k) for k in (10, 11, 12)] and counts == {'not_heading': 3}


def test_bursts_are_accepted_on_request():
    found, counts = decode([(0, hdt(0)), (3, hdt(1) + hdt(2))], bursts='accept')
    assert found == [(0, 0), (3, 1), (3, 2)] and counts == {}


def test_readings_of_a_burst_do_not_change_the_usual_step():
    finder = BurstFinder()
    for k in range(5):
        assert not finder.find(HDT, k * S, 1, 0.0)
    for _ in range(50):
        assert finder.find(HDT, 5 * S, 2, 0.0)
    assert finder.find(HDT, 6 * S, 1, 2.1) and not finder.find(HDT, 7 * S, 1, 1.9)
