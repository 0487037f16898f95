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

"""
Frames of NMEA 2000 in sentences of NMEA 0183, as gateways wrap them.

`PRINTED` is a sentence that others print: a MiniPlex at 33 degrees. Its bytes are in reverse.
"""

from __future__ import annotations

from base64 import b64encode
import math

from checksums import with_checksum
import pytest

from heading_intercompare.cli.program import main
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.nmea2000 import FRAME_FORMS, read_frames
from heading_intercompare.readers.registry import find_format
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions

SEASMART, MINIPLEX, IKONVERT = FRAME_FORMS[-3:]
NOON_NS = 1_772_366_400 * 10 ** 9   # 2026-03-01T12:00:00Z
DEG = math.degrees(1e-4)
PRINTED = '$MXPGN,01F112,2807,FC7FFF7FFF168012*11'


def payload(heading, sid=1, reference=0, variation=0x7FFF):
    """Return the bytes of a vessel heading; reserved bits are set."""
    return (bytes([sid]) + heading.to_bytes(2, 'little') + (0x7FFF).to_bytes(2, 'little')
            + variation.to_bytes(2, 'little', signed=True) + bytes([0xFC | reference]))


def wrap_seasmart(data, source=35, pgn=127250):
    return with_checksum(f'PCDIN,{pgn:06X},0B9CF01B,{source:02X},{data.hex().upper()}')


def wrap_miniplex(data, source=35, pgn=127250, order=-1):
    return with_checksum(f'MXPGN,{pgn:06X},2{len(data):X}{source:02X},'
                         f'{data[::order].hex().upper()}')


def wrap_actisense(data, source=35, pgn=127250):
    """Return the sentence of a program that leaves the bytes in their order."""
    return wrap_miniplex(data, source, pgn, order=1)


def wrap_ikonvert(data, source=35, pgn=127250):
    return f'!PDGY,{pgn},2,{source},255,0.563,{b64encode(data).decode()}'


WRAPS = [(SEASMART, wrap_seasmart), (MINIPLEX, wrap_miniplex), (MINIPLEX, wrap_actisense),
         (IKONVERT, wrap_ikonvert)]
EACH_WRAP = pytest.mark.parametrize('form, wrap', WRAPS,
                                    ids=['SeaSmart', 'MiniPlex', 'not reversed', 'iKonvert'])


def read(path, form, options=None):
    """Return the readings by stream as lists, and what was not taken."""
    collected = read_frames(form, str(path), options or StreamOptions())
    return ({name: list(zip(h.stamp_ns.tolist(), h.heading_deg.tolist()))
             for name, h in collected.streams().items()}, dict(collected.not_taken))


def write(path, sentences, stamp='2026-03-01T12:00:{:02d}Z '):
    path.write_text(''.join(f'{stamp.format(k)}{text}\r\n' for k, text in enumerate(sentences)))
    return path


@EACH_WRAP
@pytest.mark.parametrize('stamp', ['2026-03-01T12:00:{:02d}Z ', '01.03.2026 12:00:{:02d}; '])
def test_headings_are_those_of_the_frames_at_the_stamps_of_lines(form, wrap, stamp, tmp_path):
    log = write(tmp_path / 'a.log', [
        wrap(payload(10000)), wrap(payload(20000, 2), source=23), wrap(payload(10100, 3)),
        wrap(payload(65535, 4)), wrap(payload(30000, 5, reference=1, variation=-100)),
        wrap(b'\x00' * 8, pgn=127245)], stamp)
    assert find_format(log).name == f'NMEA 2000, {form.program}'
    assert [*filter(lambda other: other.is_in(log.read_bytes()), FRAME_FORMS)] == [form]
    assert read(log, form) == ({
        '35': [(NOON_NS, pytest.approx(10000 * DEG)),
               (NOON_NS + 2 * 10 ** 9, pytest.approx(10100 * DEG)),
               (NOON_NS + 4 * 10 ** 9, pytest.approx(29900 * DEG))],
        '23': [(NOON_NS + 10 ** 9, pytest.approx(20000 * DEG))]}, {'empty_heading': 1})


def test_the_sentence_of_a_miniplex_that_others_print(tmp_path):
    streams, _ = read(write(tmp_path / 'a.log', [PRINTED]), MINIPLEX)
    assert streams == {'7': [(NOON_NS, pytest.approx(5760 * DEG))]}


@EACH_WRAP
def test_a_position_of_several_frames_is_joined(form, wrap, tmp_path):
    """A MiniPlex wraps each frame of a fast packet; the others wrap the joined bytes."""
    def of(degrees):
        return int(degrees * 10 ** 16).to_bytes(8, 'little', signed=True)
    data = b'\x01' + bytes(6) + of(59.5) + of(-10.25) + bytes(8) + b'\x13\xfc' + bytes(10)
    parts = [data] if form is not MINIPLEX else [
        bytes([0x40, len(data)]) + data[:6],
        *(bytes([0x41 + k]) + data[6 + 7 * k:13 + 7 * k].ljust(7, b'\xff') for k in range(6))]
    log = write(tmp_path / 'a.log', [wrap(payload(10000)),
                                     *(wrap(part, pgn=129029) for part in parts)])
    rows = read_frames(form, str(log)).motion()['fix']['PGN 129029 of 35']
    assert (rows.latitude_deg.tolist(), rows.longitude_deg.tolist()) == (
        [pytest.approx(59.5)], [pytest.approx(-10.25)])


@EACH_WRAP
def test_times_of_day_need_a_date(form, wrap, tmp_path):
    log = write(tmp_path / 'a.log', [wrap(payload(10000)), wrap(payload(10100))],
                '12:00:{:02d}.000 ')
    with pytest.raises(ReaderError, match='--date'):
        read(log, form)
    streams, _ = read(log, form, StreamOptions(DriverSettings(date='2026-03-01')))
    assert [ns for ns, _ in streams['35']] == [NOON_NS, NOON_NS + 10 ** 9]


@EACH_WRAP
def test_a_line_without_a_stamp_is_counted(form, wrap, tmp_path):
    log = write(tmp_path / 'a.log', [wrap(payload(10000))])
    log.write_text(log.read_text() + wrap(payload(10100)) + '\r\n')
    streams, not_taken = read(log, form)
    assert (len(streams['35']), not_taken) == (1, {'no_stamp': 1})


@pytest.mark.parametrize('form, damage, reason', [
    (SEASMART, lambda text: text[:-2] + '00', 'bad_checksum'),
    (SEASMART, lambda text: text[:-3], 'no_checksum'),
    (SEASMART, lambda _: with_checksum('PCDIN,01F112,00000000,0F,FF1'), 'bad_field'),
    (SEASMART, lambda _: with_checksum('PCDIN,01F112,00000000,0F'), 'bad_field'),
    (MINIPLEX, lambda text: text[:-2] + '00', 'bad_checksum'),
    # Sent to the gateway: the address is that of the receiver.
    (MINIPLEX, lambda _: with_checksum('MXPGN,01F112,A807,FC7FFF7FFF168012'), 'bad_field'),
    (MINIPLEX, lambda _: with_checksum('MXPGN,01F112,2807,FC7FFF7FFF1680'), 'too_few_fields'),
    (IKONVERT, lambda text: text[:-2], 'too_few_fields'),
    (IKONVERT, lambda text: text.replace(',255,', ',255'), 'bad_field')])
def test_a_damaged_sentence_is_counted_and_gives_nothing(form, damage, reason, tmp_path):
    wrap = dict(WRAPS)[form] if form is not MINIPLEX else wrap_miniplex
    good = wrap(payload(10000))
    log = write(tmp_path / 'a.log', [good, damage(good), good])
    streams, not_taken = read(log, form)
    assert len(streams['35']) == 2 and not_taken == {reason: 1}


@pytest.mark.parametrize('payloads', [
    # Both ends look like the last byte of a heading; or neither; or now this, now that.
    [payload(10000, 0xFC)] * 3, [payload(10000)[:7] + b'\x00'] * 3,
    [payload(10000), payload(10000)[::-1]]])
def test_an_order_of_bytes_that_cannot_be_told_is_refused(payloads, tmp_path):
    log = write(tmp_path / 'a.log', map(wrap_miniplex, payloads))
    with pytest.raises(ReaderError, match='in reverse, and its headings do not tell which'):
        read(log, MINIPLEX)


@pytest.mark.parametrize('wrap', [wrap_miniplex, wrap_actisense])
def test_the_order_of_bytes_is_told_by_sentences_without_a_checksum_too(wrap, tmp_path):
    log = write(tmp_path / 'a.log', [wrap(payload(10000 + k, k))[:-3] for k in range(3)])
    streams, _ = read(log, MINIPLEX, StreamOptions(DriverSettings(checksum='if_present')))
    assert [deg for _, deg in streams['35']] == [pytest.approx((10000 + k) * DEG)
                                                 for k in range(3)]
    with pytest.raises(ReaderError, match='do not tell'):
        read(log, MINIPLEX)


@EACH_WRAP
def test_a_log_with_heading_sentences_is_read_by_these_as_before(form, wrap, tmp_path):
    log = write(tmp_path / 'a.log', [wrap(payload(10000)), with_checksum('IIHDT,1.5,T')])
    assert find_format(log).name == 'log of one sensor'


def test_a_stated_sentence_is_looked_for_as_sentences_are(tmp_path):
    log = write(tmp_path / 'a.log', [wrap_seasmart(payload(10000))])
    options = StreamOptions(DriverSettings(sentence='HDT'))
    assert find_format(log, options).name == 'log of one sensor'


@EACH_WRAP
def test_two_sources_of_one_log_are_imported(form, wrap, tmp_path, capsys):
    log = write(tmp_path / 'a.log', [
        wrap(payload(10000 + k, k), source=source) for k in range(20) for source in (35, 7)],
        '2026-03-01T12:00:{:02d}Z ')
    assert main(['import-nmea', '--ts', str(log), '--rs', str(log), '-o', str(tmp_path / 'bag'),
                 '--ts-talker', '35', '--rs-talker', '7']) == 0
    assert capsys.readouterr().out.count('20 headings') == 2


def test_a_log_without_stamps_says_what_to_do(tmp_path, capsys):
    log = write(tmp_path / 'a.log', [wrap_seasmart(payload(10000))] * 3, '')
    assert main(['import-nmea', '--ts', str(log), '--rs', str(log),
                 '-o', str(tmp_path / 'bag')]) == 2
    err = capsys.readouterr().err
    assert err.count('\n') == 1 and 'record them with one before each sentence' in err
