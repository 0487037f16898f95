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

"""Sentences are found in any stream, however it is split and whatever stands around them."""

from __future__ import annotations

from checksums import checksum_of
from hypothesis import example, given, strategies as st
import pytest

from heading_intercompare.drivers import framing
from heading_intercompare.drivers.framing import Framer, split

#: What serial noise, cut sentences and odd loggers are made of.
SCRAPS = [b'$', b'!', b'*', b'\r', b'\n', b'\r\n', b'\\', b',', b'0', b'7F', b'$HEHDT,21',
          b'HEHDT,1.0,T*00', b'$HEHDT,3.0,T', b'2014-08-01T00:00:00Z ', b'UdPbC\0', b'\xff\xfe']


def sentence(text: bytes, lower: bool = False) -> bytes:
    checksum = f'{checksum_of(text.decode()):02X}'
    return b'$' + text + b'*' + (checksum.lower() if lower else checksum).encode()


def texts(frames) -> list[bytes]:
    return [text for _, _, text, *_ in frames]


def cut(data: bytes, places) -> list[bytes]:
    """Return the data in pieces, cut at these places."""
    edges = [0, *sorted(place % (len(data) + 1) for place in places), len(data)]
    return [data[lo:hi] for lo, hi in zip(edges, edges[1:])]


def frames_of(chunks) -> tuple[list, dict]:
    framer = Framer()
    frames = [frame for i, chunk in enumerate(chunks) for frame in framer.feed(chunk, i)]
    frames += framer.flush()
    return frames, dict(framer.counts)


sound = st.builds(sentence, st.sampled_from([b'HEHDT,1.0,T', b'INHDT,359.99,T', b'', b'P']),
                  st.booleans())
garbage = st.lists(st.one_of(st.sampled_from(SCRAPS), st.binary(max_size=6)), max_size=6).map(
    b''.join)


@pytest.mark.slow
@given(st.lists(st.one_of(sound, garbage), max_size=12).map(b''.join),
       st.lists(st.integers(0, 10**6), max_size=12))
def test_splitting_the_stream_changes_nothing(data, places):
    whole, whole_counts = frames_of([data])
    parts, part_counts = frames_of(cut(data, places))
    assert [f[1:] for f in parts] == [f[1:] for f in whole]
    assert part_counts == whole_counts


@pytest.mark.slow
@given(st.lists(st.one_of(sound, garbage), max_size=30).map(b''.join),
       st.lists(st.integers(0, 10**6), max_size=30))
@example(sentence(b'HEHDT,1.0,T') * 4 + b'2014-08-01T00:00:00Z ', [19325])
def test_splitting_changes_nothing_when_lines_do_not_end(data, places):
    """With limits so small that an open line, and what follows its sentence, is shortened."""
    data = data.replace(b'\r', b'').replace(b'\n', b'') + b'\n'
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(framing, 'MAX_SENTENCE', 14)
        patch.setattr(framing, 'KEPT_PREFIX', 5)
        whole, whole_counts = frames_of([data])
        patch.setattr(framing, 'MAX_OPEN', 16)
        parts, part_counts = frames_of(cut(data, places))
    assert [f[2:4] for f in parts] == [f[2:4] for f in whole]
    assert all(part[4] == one[4] for part, one in zip(parts, whole) if len(one[4]) <= 5)
    assert part_counts == whole_counts
    if 'too_long' not in whole_counts:
        assert [f[1][-5:] for f in parts] == [f[1][-5:] for f in whole]


@pytest.mark.slow
@given(st.lists(st.tuples(garbage, st.floats(0, 359.9), st.booleans()), max_size=8), garbage,
       st.lists(st.integers(0, 10**6), max_size=8))
def test_no_sound_sentence_is_lost_in_garbage(pieces, end, places):
    bodies = [f'HEHDT,{heading:.1f},T'.encode() for _, heading, _ in pieces]
    data = b''.join(before + sentence(body, lower)
                    for body, (before, _, lower) in zip(bodies, pieces)) + end
    found = [text for _, _, text, checked, _ in frames_of(cut(data, places))[0]
             if checked and text.startswith(b'HEHDT') and text.endswith(b',T')]
    assert found == bodies


@given(st.integers(0, 18), st.integers(0, 255))
def test_a_damaged_byte_never_makes_another_heading(place, byte):
    good = b'$HEHDT,218.53,T*12\r\n'
    bad = good[:place] + bytes([byte]) + good[place + 1:]
    found = [text for _, _, text, checked, _ in frames_of([bad])[0] if checked]
    assert found in ([], [b'HEHDT,218.53,T'])


def test_every_line_is_a_frame_or_a_count():
    data = (b'# comment\r\n\r\n$A*41\r\n$A*42\r\n$A*4\r\n$A*\r\n$A\r\n$B$A*41\n!AIVDM*57\rrest')
    frames, counts = frames_of([data])
    assert [(text, checked) for _, _, text, checked, _ in frames] == [
        (b'A', True), (b'A', False), (b'A', True), (b'AIVDM', True)]
    assert counts == {'no_sentence': 2, 'bad_checksum': 3, 'cut': 1}


def test_a_last_sentence_without_checksum_or_line_end_is_cut():
    frames, counts = frames_of([b'$PUHAW,UVH,1,2,21'])
    assert (frames, counts) == ([], {'cut': 1})
    frames, counts = frames_of([b'$A*41'])
    assert (texts(frames), counts) == ([b'A'], {})


def test_a_datagram_is_complete_in_itself():
    framer = Framer(datagrams=True)
    assert texts(framer.feed(b'$PUHAW,UVH,1,2,219.2', 1)) == [b'PUHAW,UVH,1,2,219.2']
    assert texts(framer.feed(b'$HEHDT,1', 2) + framer.feed(b'.0,T*2A', 3)) == [b'HEHDT,1']
    assert framer.counts == {'no_sentence': 1}


def test_a_sentence_is_stamped_with_its_first_byte():
    framer = Framer()
    assert framer.feed(b'noise $', 1) == []
    assert framer.feed(b'A*41', 2) == []
    assert framer.feed(b'$A*4', 3) == []
    frames = framer.feed(b'1\r\n$A*41\r\n', 4)
    assert [frame[0] for frame in frames] == [1, 3, 4]


def test_a_sentence_that_is_too_long_is_counted():
    frames, counts = frames_of([sentence(b'A' * 1025) + b'\r\n' + sentence(b'B' * 1024)])
    assert (texts(frames), counts) == ([b'B' * 1024], {'too_long': 1})


def test_an_endless_line_does_not_fill_the_memory():
    framer = Framer()
    for _ in range(1000):
        assert framer.feed(b'\x00' * 1000, 1) == []
        assert framer.feed(b'$' + b'\x00' * 1000, 1) == []
    assert len(framer._open) < 20_000
    assert texts(framer.feed(sentence(b'A') + b'\r\n', 2)) == [b'A']
    assert framer.counts == {'too_long': 999, 'cut': 1}


LOG = (b'#UNIHEADINGA,97,GPS,FINE,2190,365174000,0,0,18,12;SOL_COMPUTED,NARROW_INT,1.0000,90.0000,'
       b'10.0000,0.0000,0.1000,0.2000,"0",20,16,18,12,0,00,0,0*5cdb44d1')
SHORT_LOG = (b'%INSATTSA,2209,490065.000;2209,490065.000000000,-0.316596979,0.329117050,'
             b'158.038475648,INS_SOLUTION_GOOD*85ec8455')
CRC_SENTENCE = (b'$KSXT,20201222075720.00,119.17084152,32.07387900,83.5770,269.94,1.19,207.28,'
                b'0.001,,3,3,25,25,-3.617,-4.468,-7.860,-0.000,-0.001,-0.022,1.0,56,*33736701')


@pytest.mark.parametrize('log', [LOG, SHORT_LOG, LOG.replace(b'5cdb44d1', b'5CDB44D1')])
def test_a_log_of_a_receiver_is_a_sentence_of_a_line_without_one(log):
    data = b'2024-05-28T20:00:00Z ' + log + b' GYRO\r\n$A*41\r\n# comment; none\r\n'
    frames, counts = frames_of(cut(data, [5, 50, 90]))
    assert [frame[1:] for frame in frames] == [
        (b'2024-05-28T20:00:00Z ', log[:-9], True, b'GYRO'), (b'', b'A', True, b'')]
    assert frames[0][0] == 0 and counts == {'no_sentence': 1}
    assert split(data.splitlines()[0]) == (b'2024-05-28T20:00:00Z ', log[:-9], b'GYRO')
    assert texts(frames_of([log])[0]) == texts(Framer(datagrams=True).feed(log, 1)) == [log[:-9]]


@pytest.mark.parametrize('line, suffix', [
    (b'$A6*77', b''), (b'$A6q*6', b''), (b'$A6q*6 GYRO', b'GYRO'),
    (b'$A6q*6,1406851200', b',1406851200'), (b'$A6q*7', None), (b'$A6*7', None),
    (b'$A6q*6f', None), (b'$A6q*', None)])
def test_a_checksum_may_lack_its_leading_zero(line, suffix):
    frames, counts = frames_of([line + b'\r\n'])
    assert [frame[4] for frame in frames] == ([] if suffix is None else [suffix])
    assert counts == ({'bad_checksum': 1} if suffix is None else {})


@pytest.mark.parametrize('line, reason', [
    (LOG.replace(b'90.0000', b'91.0000'), 'bad_checksum'), (LOG[:-1], 'no_sentence'),
    (LOG + b'0', 'no_sentence'), (LOG[:-9], 'no_sentence'),
    (CRC_SENTENCE.replace(b'269.94', b'269.95'), 'bad_checksum'),
    (CRC_SENTENCE[:-1], 'bad_checksum'), (LOG.replace(b'"0"', b'0' * 1024), 'too_long')])
def test_a_damaged_long_checksum_gives_no_sentence(line, reason):
    assert frames_of([line + b'\r\n']) == ([], {reason: 1})


def test_a_sentence_may_have_a_long_checksum():
    frames, counts = frames_of([CRC_SENTENCE + b',1608623840\r\n'])
    assert [frame[2:] for frame in frames] == [(CRC_SENTENCE[1:-9], True, b',1608623840')]
    assert counts == {}


def test_the_stamp_of_a_line_holds_for_a_sentence_that_follows_a_cut_one():
    frames, counts = frames_of([b'stamp $HEHDT,21$A*41\r\n$A*41\r\n'])
    assert [(frame[1], frame[2]) for frame in frames] == [(b'stamp ', b'A'), (b'', b'A')]
    assert counts == {'cut': 1}


@pytest.mark.parametrize('line, parts', [
    (b'stamp $A*41\r\n', (b'stamp ', b'A', b'')), (b'$A', (b'', b'A', b'')),
    (b'$A*41,1406851200\r\n', (b'', b'A', b',1406851200')), (b'no sentence\n', None),
    (b'', None), (b'\n', None)])
def test_the_first_sentence_of_a_line(line, parts):
    assert split(line) == parts
