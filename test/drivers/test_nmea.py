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

"""The decoder: which sentence it chooses, how it stamps it, and that it counts everything else."""

from __future__ import annotations

from drivers.receiving import sentence
from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.records import Headings
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings

S = 1_000_000_000
NOON = 1772366400 * S   # 2026-03-01T12:00:00Z


def zda(seconds: float) -> bytes:
    return sentence(f'INZDA,1200{seconds:05.2f},01,03,2026,,')


def decode(*pieces: bytes, **settings) -> tuple[Headings, dict[str, int]]:
    """Decode pieces received at 0, 1, 2 ... seconds."""
    decoder = NmeaDecoder(DriverSettings(**settings))
    chunks = [decoder.feed(piece, i * S) for i, piece in enumerate(pieces)]
    chunks.append(decoder.flush())
    headings = Headings.concatenate(chunks)
    assert decoder.lines == len(headings) + sum(decoder.counts.values())
    return headings, decoder.counts


def test_a_live_sentence_is_stamped_with_its_receipt():
    headings, counts = decode(sentence('HEHDT,1.5,T'), sentence('HEHDT,2.5,T'), sentence='HDT')
    assert headings == Headings.as_sent([0, S], [1.5, 2.5])
    assert counts == {}


def test_nothing_gives_the_empty_chunk():
    headings, counts = decode(b'')
    assert len(headings) == 0 and headings.stamp_ns.dtype == np.int64 and counts == {}


@pytest.mark.parametrize('order, kinds', [
    ('THS', ('HDG', 'PUHAW,UVH', 'PSXN,23', 'PASHR', 'HDT', 'THS')),
    ('HDT', ('HDG', 'PUHAW,UVH', 'PSXN,23', 'PASHR', 'HDT')),
    ('PASHR', ('HDG', 'PUHAW,UVH', 'PSXN,23', 'PASHR')),
    ('PSXN,23', ('HDG', 'PUHAW,UVH', 'PSXN,23')),
    ('PUHAW,UVH', ('HDG', 'PUHAW,UVH')),
    ('HDG', ('HDG',))])
def test_auto_takes_the_first_kind_of_the_list_and_counts_the_others(order, kinds):
    text = {'THS': 'HETHS,1.0,A', 'HDT': 'HEHDT,2.0,T', 'PASHR': 'PASHR,,3.0,T',
            'PSXN,23': 'PSXN,23,0,0,4.0,0', 'PUHAW,UVH': 'PUHAW,UVH,0,0,5.0',
            'HDG': 'HCHDG,6.0,,,0.0,E'}
    data = b''.join(sentence(text[kind]) for kind in kinds)
    headings, counts = decode(data, data)
    assert headings.heading_deg.tolist() == [float(list(text).index(order) + 1)] * 2
    assert counts == {f'other_sentence.{kind}': 2 for kind in kinds if kind != order}


@pytest.mark.parametrize('talker, headings_deg, counts', [
    (None, [1.0], {'other_talker.GP': 1, 'other_talker.HE': 1, 'other_talker.23': 1}),
    ('any', [1.0, 2.0, 3.0, 4.0], {}),
    ('GN,GP', [1.0, 2.0], {'other_talker.HE': 1, 'other_talker.23': 1}),
    ('23', [4.0], {'other_talker.GN': 1, 'other_talker.GP': 1, 'other_talker.HE': 1})])
def test_several_talkers_are_read_as_one(talker, headings_deg, counts):
    sentences = [sentence(f'{name}HDT,{k}.0,T')
                 for k, name in enumerate(('GN', 'GP', 'HE', '23'), 1)]
    headings, counted = decode(*sentences, sentence='HDT', talker=talker)
    assert headings.heading_deg.tolist() == headings_deg and counted == counts


def test_learning_holds_what_it_hears_and_loses_nothing():
    decoder = NmeaDecoder(DriverSettings(learn_s=2.0))
    assert len(decoder.feed(sentence('GPZDA,1'), 0)) == 0
    for second in (10, 11):
        assert len(decoder.feed(sentence(f'HEHDT,{second}.0,T'), second * S)) == 0
        assert len(decoder.feed(sentence(f'HETHS,{second}.5,A'), second * S)) == 0
    assert decoder.chosen is None
    assert len(decoder.feed(b'', 12 * S - 1)) == 0
    headings = decoder.feed(sentence('HETHS,12.5,A'), 12 * S)
    assert decoder.chosen == ('THS', 'HE')
    assert str(decoder.chosen) == 'HETHS'
    assert headings == Headings.as_sent([10 * S, 11 * S, 12 * S], [10.5, 11.5, 12.5])
    assert decoder.counts == {'not_heading': 1, 'other_sentence.HDT': 2}
    assert len(decoder.feed(sentence('HEHDT,13.0,T'), 13 * S)) == 0
    assert decoder.counts['other_sentence.HDT'] == 3


def test_time_passes_on_a_line_that_has_fallen_silent():
    decoder = NmeaDecoder(DriverSettings(learn_s=2.0))
    assert len(decoder.feed(sentence('HEHDT,1.0,T'), 0)) == 0
    assert decoder.feed(b'', 2 * S) == Headings.as_sent([0], [1.0])


def test_a_clock_set_back_does_not_prolong_learning():
    decoder = NmeaDecoder(DriverSettings(learn_s=2.0))
    decoder.feed(sentence('HEHDT,1.0,T'), 1000 * S)
    assert len(decoder.feed(sentence('HEHDT,2.0,T'), 10 * S)) == 0
    assert len(decoder.feed(sentence('HEHDT,3.0,T'), 12 * S)) == 3


def test_faults_of_the_kind_not_chosen_are_counted_as_other_sentences():
    headings, counts = decode(sentence('HEHDT,,T') + sentence('HETHS,1.0,A')
                              + sentence('HETHS,1.0,V'))
    assert headings.heading_deg.tolist() == [1.0]
    assert counts == {'invalid_mode.V': 1, 'other_sentence.HDT': 1}


def test_a_ths_that_calls_itself_invalid_is_not_replaced_by_hdt():
    headings, counts = decode(sentence('HEHDT,1.0,T') + sentence('HETHS,1.0,V'))
    assert len(headings) == 0
    assert counts == {'invalid_mode.V': 1, 'other_sentence.HDT': 1}


def test_two_talkers_are_never_mixed():
    data = sentence('HEHDT,1.0,T') + sentence('GPHDT,2.0,T')
    headings, counts = decode(data, data)
    assert headings.heading_deg.tolist() == [1.0, 1.0]
    assert counts == {'other_talker.GP': 2}
    headings, counts = decode(data, data, sentence='HDT', talker='GP')
    assert headings.heading_deg.tolist() == [2.0, 2.0]
    assert counts == {'other_talker.HE': 2}
    headings, counts = decode(data, talker='IN')
    assert len(headings) == 0 and counts == {'other_talker.HE': 1, 'other_talker.GP': 1}


def test_a_talker_that_is_set_does_not_shut_out_proprietary_sentences():
    headings, _ = decode(sentence('PSXN,23,0,0,4.0,0'), talker='HE')
    assert headings.heading_deg.tolist() == [4.0]


@pytest.mark.parametrize('checksum, n, counts', [
    ('required', 0, {'no_checksum': 2}), ('if_present', 1, {'not_heading': 1})])
def test_sentences_without_checksum(checksum, n, counts):
    headings, found = decode(b'$HEHDT,1.0,T\r\n$HEROT,1.0,A\r\n', checksum=checksum)
    assert (len(headings), found) == (n, counts)


def test_a_wrong_checksum_is_refused_even_where_none_is_needed():
    headings, counts = decode(b'$PUHAW,UVH,1,2,219.2\r\n$PUHAW,UVH,1,2,219.2*00\r\n')
    assert headings.heading_deg.tolist() == [219.2]
    assert counts == {'bad_checksum': 1}


def test_psxn_20_tells_whether_psxn_23_is_valid():
    data = b''.join(sentence(f'PSXN,20,1,0,{quality},0') + sentence(f'PSXN,23,0,0,{quality},0')
                    for quality in (0, 1, 2, 0))
    headings, counts = decode(data)
    assert headings.heading_deg.tolist() == [0.0, 1.0, 0.0]
    assert counts == {'invalid_quality': 1, 'not_heading': 4}


def test_a_heading_takes_the_time_of_the_zda_before_it():
    headings, counts = decode(
        zda(0.17) + sentence('INHDT,1.0,T') + sentence('PSXN,23,0,0,1.0,0'),
        zda(1.17) + sentence('PSXN,23,0,0,2.0,0') + sentence('INHDT,2.0,T'),
        time='validity')
    assert headings == Headings.as_sent([NOON + 170_000_000, NOON + 1_170_000_000], [1.0, 2.0])
    assert counts == {'not_heading': 2, 'other_sentence.PSXN,23': 2}


def test_the_first_burst_is_whole_for_every_kind():
    """Each kind has the time of the burst to itself, whichever is chosen later."""
    data = zda(0.17) + sentence('INHDT,1.0,T') + sentence('PSXN,23,0,0,1.5,0')
    for kind, heading_deg in (('HDT', 1.0), ('PSXN,23', 1.5)):
        headings, _ = decode(data, time='validity', sentence=kind)
        assert headings == Headings.as_sent([NOON + 170_000_000], [heading_deg])


@pytest.mark.parametrize('data, n, reasons', [
    ([sentence('INHDT,1.0,T')], 0, {'no_validity_time': 1}),
    ([sentence('INHDT,1.0,T'), zda(1), sentence('INHDT,2.0,T')], 1,
     {'no_validity_time': 1, 'not_heading': 1}),
    ([zda(1), sentence('INHDT,1.0,T'), sentence('INHDT,2.0,T')], 1,
     {'no_validity_time': 1, 'not_heading': 1}),
    ([zda(1), sentence('INHDT,,T'), sentence('INHDT,2.0,T')], 0,
     {'no_validity_time': 1, 'empty_heading': 1, 'not_heading': 1}),
    ([zda(1), sentence('INZDA,120002.00,,,,,'), sentence('INHDT,2.0,T')], 0,
     {'no_validity_time': 1, 'bad_time': 1, 'not_heading': 1}),
    ([zda(1), sentence('INHDT,1.0,T'), zda(2).replace(b'*', b'0*'), sentence('INHDT,2.0,T')], 1,
     {'no_validity_time': 1, 'bad_checksum': 1, 'not_heading': 1}),
])
def test_without_a_zda_of_its_own_burst_a_heading_has_no_time_of_validity(data, n, reasons):
    headings, counts = decode(*data, time='validity')
    assert len(headings) == n and counts == reasons


def test_pashr_takes_its_own_time_on_the_nearest_day():
    data = (sentence('GPZDA,235959.90,28,02,2026,,')
            + sentence('PASHR,235959.950,1.0,T') + sentence('PASHR,000000.050,2.0,T')
            + sentence('PASHR,,3.0,T') + sentence('PASHR,9x,4.0,T'))
    headings, counts = decode(data, time='validity')
    midnight = NOON - 43_200 * S
    assert headings == Headings.as_sent([midnight - 50_000_000, midnight + 50_000_000], [1.0, 2.0])
    assert counts == {'no_validity_time': 2, 'not_heading': 1}


def test_pashr_without_zda_takes_the_day_from_its_receipt():
    decoder = NmeaDecoder(DriverSettings(time='validity', sentence='PASHR'))
    headings = decoder.feed(sentence('PASHR,115959.750,1.0,T'), NOON)
    assert headings == Headings.as_sent([NOON - 250_000_000], [1.0])
    assert len(decoder.feed(sentence('PASHR,ATT,100.0,1.0,0,0'), NOON)) == 0
    assert decoder.counts == {'no_validity_time': 1}


def test_a_stamp_on_a_live_line_is_used_only_if_asked_for():
    line = b'2014-08-01T00:00:00.183Z ' + sentence('HEHDT,1.0,T')
    assert decode(line)[0] == Headings.as_sent([0], [1.0])
    headings, counts = decode(line + sentence('HEHDT,2.0,T'), stamp_format='iso')
    assert headings == Headings.as_sent([1406851200183000000], [1.0])
    assert counts == {'no_stamp': 1}


def test_a_datagram_with_header_and_tag_block_gives_its_heading():
    data = b'UdPbC\0\\s:GY0001,n:1,c:1772366400*6E\\' + sentence('HETHS,100.1,A').strip()
    for settings in ({}, {'stamp_format': 'tag'}):
        headings, counts = decode(data, source='udp://239.192.0.3:60003', **settings)
        assert headings == Headings.as_sent([NOON if settings else 0], [100.1]) and counts == {}


def test_datagrams_are_not_joined():
    headings, counts = decode(b'$HEHDT,1', b'0.0,T*26', sentence('HEHDT,3.0,T'),
                              source='udp://:10110')
    assert headings.heading_deg.tolist() == [3.0]
    assert counts == {'no_checksum': 1, 'no_sentence': 1}


def test_stamps_that_do_not_increase_are_left_to_the_pairing():
    headings, counts = decode(sentence('HEHDT,1.0,T') * 3, sentence='HDT')
    assert headings.stamp_ns.tolist() == [0, 0, 0] and counts == {}


@given(st.lists(st.sampled_from([
    sentence('HEHDT,1.0,T'), sentence('GPHDT,2.0,T'), sentence('HETHS,3.0,A'), zda(1.0),
    sentence('HETHS,3.0,V'), sentence('PSXN,23,0,0,4.0,0'), b'$PUHAW,UVH,1,2,5.0\r\n',
    b'$HEHDT,1.0,T\r\n', b'$HEHDT,1.0', b'\xff\xfe\r\n', b'# text\n']), max_size=15),
    st.lists(st.integers(0, 400), max_size=10),
    st.sampled_from(['auto', 'HDT', 'PSXN,23']), st.sampled_from(['receipt', 'validity']))
def test_any_splitting_gives_the_same_headings_and_everything_is_counted(
        pieces, places, kind, time):
    data = b''.join(pieces)
    edges = [0, *sorted(min(place, len(data)) for place in places), len(data)]
    results = []
    for cuts in ([0, len(data)], edges):
        decoder = NmeaDecoder(DriverSettings(sentence=kind, time=time))
        chunks = [decoder.feed(data[lo:hi], 7) for lo, hi in zip(cuts, cuts[1:])]
        headings = Headings.concatenate([*chunks, decoder.flush()])
        assert decoder.lines == len(headings) + sum(decoder.counts.values())
        results.append((headings, decoder.counts))
    assert results[0] == results[1]


def test_a_sentence_that_came_nobody_knows_when_has_no_stamp():
    decoder = NmeaDecoder(DriverSettings())
    assert len(decoder.feed(sentence('HEHDT,1.0,T'), None)) == 0
    assert len(decoder.flush()) == 0 and decoder.counts == {'no_stamp': 1}


def test_a_file_told_to_have_no_stamps_does_not_take_the_time_at_which_it_is_read(tmp_path):
    log = tmp_path / 'gyro.log'
    log.write_bytes(b'1772366400 ' + sentence('HEHDT,1.0,T'))
    decoder = NmeaDecoder(DriverSettings(source=f'file:{log}', stamp_format='none'))
    assert len(decoder.feed(log.read_bytes(), NOON)) == 0
    assert decoder.counts == {'no_stamp': 1}


def test_a_decoder_of_a_file_that_is_still_empty_is_still_choosing(tmp_path):
    log = tmp_path / 'empty.log'
    log.touch()
    assert NmeaDecoder(DriverSettings(source=f'file:{log}')).chosen is None
