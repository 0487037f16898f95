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

"""What sentences say of the quality of their heading: flags and claims, as the manuals have it."""

from __future__ import annotations

from checksums import with_checksum
import numpy as np
import pytest

from heading_intercompare.core.records import NORMAL_QUALITY, Quality, QUALITY_FLAGS
from heading_intercompare.drivers.logs import LogReader
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.sentence_quality import quality_of, QualityListener
from heading_intercompare.drivers.sentences import FORMS, identify, PASHR_FORMS
from heading_intercompare.drivers.settings import DriverSettings

UNIHEADING = ('#UNIHEADINGA,81,GPS,FINE,2316,244818000,0,0,18,27;SOL_COMPUTED,{},1.2300,218.7400,'
              '-0.5000,0.0000,{},0.2000,"999",32,28,28,18,3,00,3,f3')
INSPVAX = ('#INSPVAXA,COM1,0,73.5,FINESTEERING,1695,309428.000,02000040,4e77,43562;{},INS_PSRSP,'
           '51.11637873403,-114.03825114994,1063.6093,-16.9000,-0.0845,-0.0464,-0.0127,0.1380,'
           '-0.0685,90.06,2.9,2.9,4.9,0.11,0.12,0.13,0.018,0.019,2.018,3,0')


@pytest.mark.parametrize('text, flag, stated_deg', [
    # Applanix, NovAtel, SBG, Trimble: 0 without GNSS; 1 is poor of one and sound of another.
    ('PASHR,183944.821,74.52,T,-1.63,1.51,0.14,0.020,0.020,0.012,2,1', 'normal', 0.012),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.059,1,1', 'unknown', 0.059),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,4.986,0,1', 'no GNSS aiding',
     4.986),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029, 0.059 , 6,3', 'inertial only',
     0.059),
    # An empty field, a zero and an impossible number are no claims, and no flags.
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,,,', 'unknown', None),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,0.000,2,1', 'normal', None),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31,+0.01,0.029,0.029,999.99,x,1', 'unknown', None),
    ('PASHR,163029.000,158.09,T,-0.30,+0.31', 'unknown', None),
    ('PASHR,ATT,385426.0,158.09,+000.76,+000.05,0.0014,0.0094,0', 'normal', None),
    ('PASHR,ATT,385426.0,158.09,+000.76,+000.05,0.0014,0.0094,1', 'rough attitude', None),
    ('PTNL,AVR,200000.00,+218.7400,Yaw,-0.3000,Tilt,,,12.575,3,1.4,16', 'normal', None),
    ('PTNL,AVR,200000.00,+218.7400,Yaw,-0.3000,Tilt,,,12.575,2,1.4,16', 'float solution', None),
    ('PTNL,AVR,200000.00,+218.7400,Yaw,-0.3000,Tilt,,,12.575,4,1.4,16', 'code solution', None),
    ('GNHPR,021004.00,178.12,-00.50,000.00,4,18,0.00,0999', 'normal', None),
    ('GNHPR,021004.00,178.12,-00.50,000.00,5,18,0.00,0999', 'float solution', None),
    ('GNHPR,021004.00,178.12,-00.50,000.00,1,18,0.00,0999', 'code solution', None),
    ('PSSN,HRP,142800.00,221103,12.33,,0.53,0.037,,0.073,12,2,2.30,E', 'normal', 0.037),
    ('PSSN,HRP,142800.00,221103,12.33,,0.53,0.037,,0.073,12,1,2.30,E', 'float solution', 0.037),
    (UNIHEADING.format('NARROW_INT', '0.1200'), 'normal', 0.12),
    (UNIHEADING.format('NARROW_FLOAT', '1.5000'), 'float solution', 1.5),
    (UNIHEADING.format('SINGLE', '5.0000'), 'code solution', 5.0),
    (UNIHEADING.format('ANOTHER', '0.1200'), 'unknown', 0.12),
    (INSPVAX.format('INS_SOLUTION_GOOD'), 'normal', 2.018),
    (INSPVAX.format('INS_SOLUTION_FREE'), 'inertial only', 2.018),
    ('PQTMTAR,1,165331.000,4,,1.001,-12.36,0.0,238.03,0.12,,0.15,26', 'normal', 0.15),
    ('PQTMTAR,1,165331.000,5,,1.001,-12.36,0.0,238.03,0.12,,0.85,26', 'float solution', 0.85),
    ('HEHDT,218.53,T', 'unknown', None),
])
def test_a_sentence_says_how_good_its_heading_is(text, flag, stated_deg):
    sentence = text.encode()
    stated, index = quality_of(identify(sentence), sentence)
    assert QUALITY_FLAGS[index] == flag
    assert stated == stated_deg if stated_deg is not None else np.isnan(stated)


@pytest.mark.parametrize('name, form', [*FORMS.items(), *PASHR_FORMS.items()])
def test_every_grade_has_a_word_of_the_flags(name, form):
    assert {words for _, words in form.grades} <= {*QUALITY_FLAGS[NORMAL_QUALITY:]}, name
    assert not form.grades or form.quality, name


def hear(*texts):
    """Return the flags of the headings of a stream, in words."""
    sentences = [text.encode() for text in texts]
    names = [identify(sentence) for sentence in sentences]
    listener = QualityListener(next(filter(None, names)))
    for at, (name, sentence) in enumerate(zip(names, sentences)):
        if name is None:
            listener.note(sentence)
        elif listener.listens:
            listener.hear(sentence, at)
    return [QUALITY_FLAGS[flag] for flag in listener.drain(end=True).flag.tolist()]


GGA = '{}GGA,172814.0,3723.46587704,N,12202.26957864,W,{},6,1.2,18.893,M,-25.669,M,2.0,0031'


@pytest.mark.parametrize('said, flag', [
    ('PSXN,20,1,0,0,0', 'normal'), ('PSXN,20,0,0,1,0', 'reduced performance'),
    (GGA.format('GP', 4), 'normal'), (GGA.format('GP', 0), 'no position'),
    (GGA.format('GP', 6), 'estimated position'), (GGA.format('GP', 8), 'simulated position')])
def test_another_sentence_of_a_gnss_compass_says_it(said, flag):
    assert hear(said, 'GPHDT,10.0,T') == [flag]
    assert hear('GPHDT,10.0,T', said, 'GPHDT,10.1,T') == [flag]


@pytest.mark.parametrize('said', ['PSXN,20,0,0,1,0', GGA.format('GP', 0), GGA.format('GP', ''),
                                  'GPGGA,172814.0', 'PSXN,20'])
def test_what_a_receiver_says_is_not_said_of_a_gyrocompass(said):
    assert hear(said, 'HEHDT,10.0,T') == []


def test_rows_stand_where_the_sensor_says_something_else(tmp_path):
    """Of seven readings the second and the fifth change nothing; the last row is the end."""
    flags = [2, 2, 2, 0, 0, 0, 2]
    path = tmp_path / 'ins.log'
    path.write_text(''.join(
        f'2026-03-01T12:00:0{second}.000Z ' + with_checksum(
            f'PASHR,12000{second}.00,74.52,T,-1.63,1.51,0.14,0.020,0.020,0.012,{flag},1') + '\n'
        for second, flag in enumerate(flags)))
    reader = LogReader(path, DriverSettings(), block_bytes=64)
    chunks = []
    n = 0
    for headings in reader:
        n += len(headings)
        chunks.append(reader.drain_quality())
    chunks.append(reader.drain_quality(end=True))
    rows = [(stamp_ns % 10 ** 10 // 10 ** 9, QUALITY_FLAGS[flag]) for chunk in chunks
            for stamp_ns, flag in zip(chunk.stamp_ns.tolist(), chunk.flag.tolist())]
    assert n == len(flags)
    assert rows == [(0, 'normal'), (2, 'normal'), (3, 'no GNSS aiding'), (5, 'no GNSS aiding'),
                    (6, 'normal')]


def feed_line(texts, **settings):
    """Return what a live line says, reading by reading half a second apart."""
    decoder = NmeaDecoder(DriverSettings(**{'source': 'udp://:1', 'learn_s': 1.0, **settings}))
    chunks = []
    for at, text in enumerate(texts):
        decoder.feed(f'{with_checksum(text)}\r\n'.encode(), 10 ** 18 + at * 10 ** 9 // 2)
        chunks.append(decoder.drain_quality(end=True))
    decoder.flush()
    return Quality.concatenate([*chunks, decoder.drain_quality(end=True)])


PASHR_TEXT = 'PASHR,12000{}.00,90.00,T,0.1,0.2,0.0,0.01,0.01,{:.3f},2,1'


@pytest.mark.parametrize('talker', ['GP', 'HE'])
def test_a_live_line_says_what_a_file_of_it_says(talker):
    """Also of the readings that are held while the driver chooses; nothing of those left out."""
    texts = ['GPHDT,90.0,T', 'GPGGA,120000,,,,,2,08,1.0,,,,,,', 'GPHDT,90.1,T', 'HEHDT,70.0,T',
             'GPGGA,120001,,,,,6,08,1.0,,,,,,', 'GPHDT,90.2,T', 'GPHDT,90.3,T']
    rows = feed_line(texts, sentence='HDT', talker=talker)
    stamps = 10 ** 18 + np.array([0, 2, 5, 6]) * 10 ** 9 // 2
    flag, _ = rows.match(stamps)
    assert [QUALITY_FLAGS[word] for word in flag] == (
        ['unknown', 'normal', 'estimated position', 'estimated position'] if talker == 'GP'
        else ['unknown'] * 4)
    assert set(rows.stamp_ns.tolist()) <= set(stamps.tolist())


@pytest.mark.parametrize('said,word', [
    ('GPGGA,120000,,,,,6,08,1.0,,,,,,', 'estimated position'),
    ('PSXN,20,0,0,1,0', 'reduced performance')])
def test_what_comes_before_the_first_heading_is_said_of_it(said, word):
    """Live, where no file tells beforehand which sentence has the headings."""
    rows = feed_line([said, 'GPHDT,90.0,T', 'GPHDT,90.1,T'], sentence='HDT', talker='GP')
    flag, _ = rows.match(10 ** 18 + np.array([1, 2]) * 10 ** 9 // 2)
    assert [QUALITY_FLAGS[at] for at in flag] == [word] * 2


def test_readings_of_a_live_line_that_were_held_have_their_quality():
    texts = [PASHR_TEXT.format(at, claim) for at, claim in enumerate((0.02, 0.02, 0.4, 0.02))]
    rows = feed_line(texts)
    _, stated_deg = rows.match(10 ** 18 + np.arange(4) * 10 ** 9 // 2)
    assert stated_deg.tolist() == [0.02, 0.02, 0.4, 0.02]


def test_nothing_is_kept_of_sentences_in_messages():
    """Nobody takes it there, so it would grow for months."""
    rows = feed_line([PASHR_TEXT.format(at, 0.02) for at in range(4)], source=None)
    assert len(rows) == 0
