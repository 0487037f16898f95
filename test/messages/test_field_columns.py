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

"""A field of messages of any type: against the encoder, in either byte order, and cut short."""

from __future__ import annotations

from functools import partial
import struct

import numpy as np
import pytest

from heading_intercompare.messages.byte_columns import FieldColumn, join_messages, read_sound
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.field_columns import decode_field, find_field
from heading_intercompare.messages.fields import definitions_in, leaves, short_name
from heading_intercompare.messages.heading_fields import find_heading_field
from heading_intercompare.messages.heading_places import HeadingPlace
from heading_intercompare.messages.schemas import definitions_of
from heading_intercompare.messages.sentence_messages import find_sentences, SENTENCE

S = 10 ** 9
STAMPED = ('geometry_msgs/msg/PoseWithCovarianceStamped', 'geometry_msgs/msg/QuaternionStamped',
           'geometry_msgs/msg/TwistStamped', 'nav_msgs/msg/Odometry', 'sensor_msgs/msg/Imu',
           'sensor_msgs/msg/NavSatFix', 'compass_msgs/msg/Azimuth')
#: Every kind of thing that can lie before a field, and a field of each width.
MIXED = """
std_msgs/Header header
uint8 flag
string name
int16[] counts
uint8[3] code
string[2] words
float64[<=4] gains
Inner[2] pair
float32 narrow
Inner inner
bool last
================================================================================
MSG: x/Inner
int32 small
string text
float64 wide
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def nested(path, value, stamp_s, frame):
    """Return a message with one field set."""
    for word in reversed(path.split('.')):
        value = {word: value}
    return {**value, 'header': {'stamp': {'sec': stamp_s}, 'frame_id': frame}}


@pytest.mark.parametrize('type_name', STAMPED)
def test_every_number_of_a_known_type_is_that_of_the_encoder(type_name):
    definitions = definitions_of(type_name)
    paths = [(path, code) for path, code, size in leaves(short_name(type_name), definitions)
             if size is None and code != 's' and not path.startswith('header')]
    assert paths
    for path, code in paths:
        values = [3, 200 if code in 'BHId' else 100, 0, 1]
        messages = [encode(type_name, nested(path, value, at, 'f' * at * 3))
                    for at, value in enumerate(values)]
        column = decode_field(find_field(type_name, definitions, path), *join_messages(messages))
        assert column.values.tolist() == values, path
        assert column.stamp_ns.tolist() == [at * S for at in range(4)]


class Writer:
    """Writes CDR by hand, as a check of the walk."""

    def __init__(self, sign):
        self.sign, self.data = sign, b''

    def put(self, code, *values):
        """Append values of one width, each aligned."""
        for value in values:
            size = struct.calcsize(code)
            self.data += bytes(-len(self.data) % size) + struct.pack(self.sign + code, value)

    def text(self, text):
        """Append a text."""
        self.put('I', len(text) + 1)
        self.data += text + b'\0'

    def message(self):
        """Return the message."""
        return (b'\0\1\0\0' if self.sign == '<' else b'\0\0\0\0') + self.data


def mixed(sign, at):
    """Return a message of the type `MIXED` whose lengths depend on `at`."""
    writer = Writer(sign)
    writer.put('i', 7)
    writer.put('I', at)
    writer.text(b'f' * (at % 5))
    writer.put('B', 1)
    writer.text(b'n' * (at % 3))
    writer.put('I', at % 4)
    writer.put('h', *range(at % 4))
    writer.put('B', 1, 2, 3)
    writer.text(b'a' * (at % 7))
    writer.text(b'')
    writer.put('I', at % 3)
    writer.put('d', *[0.5] * (at % 3))
    for _ in range(2):
        writer.put('i', 5)
        writer.text(b'p' * (at % 2))
        writer.put('d', 1.5)
    writer.put('f', 0.25 * at)
    writer.put('i', -at)
    writer.text(b't' * at)
    writer.put('d', 10.0 + at)
    writer.put('?', bool(at % 2))
    return writer.message()


def test_what_lies_before_a_field_may_have_any_length_and_byte_order():
    definitions = definitions_in('x/msg/Mixed', MIXED)
    messages = [mixed('<>'[at % 3 == 0], at) for at in range(24)]
    for path, expected in (('narrow', [0.25 * at for at in range(24)]),
                           ('inner.small', [-at for at in range(24)]),
                           ('inner.text', [b't' * at for at in range(24)]),
                           ('inner.wide', [10.0 + at for at in range(24)]),
                           ('last', [at % 2 for at in range(24)]),
                           ('code[0]', [1] * 24), ('code[2]', [3] * 24)):
        column = decode_field(find_field('x/msg/Mixed', definitions, path),
                              *join_messages(messages))
        assert column.values.tolist() == expected, path
        assert column.stamp_ns.tolist() == [7 * S + at for at in range(24)]


@pytest.mark.parametrize('length', [0xffffffff, 0x7fffffff, 400])
def test_a_message_that_is_cut_or_has_a_wrong_length_is_refused(length):
    place = find_field('x/msg/Mixed', definitions_in('x/msg/Mixed', MIXED), 'last')
    whole = mixed('<', 6)
    decode_field(place, *join_messages([whole]))
    for end in range(len(whole)):
        with pytest.raises(MessageError):
            decode_field(place, *join_messages([whole[:end]]))
    for at in range(12, len(whole) - 4, 4):
        spoiled = whole[:at] + struct.pack('<I', length) + whole[at + 4:]
        try:
            decode_field(place, *join_messages([spoiled]))
        except MessageError:
            pass


@pytest.mark.parametrize('path, wrong', [
    ('many', 'many is a list'), ('gone.x', "x/Far has no field 'gone'; it has header, "),
    ('inner', 'inner is a message; choose one of its fields'),
    ('header.stamp.sec', 'lies in the header'), ('inner.small[0]', 'small is no array of numbers'),
    ('words[0]', 'words is no array of numbers'), ('counts[0]', 'has no element 0 in every'),
    ('code[3]', 'code has no element 3'),
    ('code[x]', r"'code\[x\]' is no field; an element is code\[0\]"),
    ('code', r'code is a list; .* such as code\[0\]'),
    ('inner.yaw', r'a yaw may turn either way: write inner\.yaw@ned if it turns from north'),
    ('inner.small', 'is an integer of 32 bits, whose unit nobody states: write inner.small@deg'),
    ('inner.small.x', 'small is not a message; it has no fields'),
    ('inner.text', 'is a text; name a sentence in it, as in inner.text.HDT')])
def test_a_field_that_cannot_be_read_says_why(path, wrong):
    text = MIXED.replace('bool last', 'Inner[] many\nfloat64 after').replace(
        'float64 wide', 'float64 wide\nfloat64 yaw')
    with pytest.raises(MessageError, match=wrong):
        find_heading_field('x/msg/Far', definitions_in('x/msg/Far', text),
                           HeadingPlace('gps', path), 'enu')


def test_a_type_that_needs_too_much_is_refused_at_once():
    """Twenty lines of types within types mean more values than any memory holds."""
    endless = MIXED.replace('uint8 flag', 'Inner[0] none')
    with pytest.raises(MessageError, match='none is an empty list'):
        find_field('x/msg/Mixed', definitions_in('x/msg/Mixed', endless), 'last')
    text = 'std_msgs/Header header\nT0[1000] many\nfloat64 after\n' + ''.join(
        f'{"=" * 80}\nMSG: x/T{n}\n' + (f'T{n + 1}[1000] a\n' if n < 19 else 'float64 a\n')
        for n in range(20)) + MIXED[MIXED.index('=' * 80):]
    with pytest.raises(MessageError, match='too much lies within many of x/msg/Deep'):
        find_field('x/msg/Deep', definitions_in('x/msg/Deep', text), 'after')
    text = text.replace('[1000]', '[]')
    find_field('x/msg/Deep', definitions_in('x/msg/Deep', text), 'after')
    with pytest.raises(MessageError, match='message type x/T19 lies too deep'):
        find_field('x/msg/Deep', definitions_in('x/msg/Deep', text.replace(
            'T19\nfloat64 a', 'T19\nT19[] a')), 'after')


LISTS = MIXED.replace('bool last', 'Inner[] many\nstring[] names\nInner[<=3] few\nfloat64 after')


def test_lists_of_texts_and_messages_may_lie_before_a_field():
    """Messages of one chunk have lists of different lengths, and texts of different lengths."""
    messages = []
    for at in range(24):
        writer = Writer('<>'[at % 2])
        writer.data = mixed(writer.sign, at)[4:-1]
        for count, is_text in ((at % 4, False), (at % 3, True), (at % 2, False)):
            writer.put('I', count)
            for number in range(count):
                if not is_text:
                    writer.put('i', 5)
                writer.text(b't' * (at % 5 + number))
                if not is_text:
                    writer.put('d', 1.5)
        writer.put('d', 100.0 + at)
        messages.append(writer.message())
    place = find_field('x/msg/Far', definitions_in('x/msg/Far', LISTS), 'after')
    assert decode_field(place, *join_messages(messages)).values.tolist() == [
        100.0 + at for at in range(24)]
    for end in range(len(messages[7])):
        with pytest.raises(MessageError):
            decode_field(place, *join_messages([messages[7][:end]]))


@pytest.mark.parametrize('count', [10_001, 0xffffffff])
def test_a_list_of_too_many_elements_makes_its_message_unreadable(count):
    text = ('std_msgs/Header header\nstring[] names\nfloat64 after\n'
            + MIXED[MIXED.index('=' * 80):])
    place = find_field('x/msg/Far', definitions_in('x/msg/Far', text), 'after')
    messages = []
    for length in (count, 1):
        writer = Writer('<')
        writer.put('i', 7)
        writer.put('I', 0)
        writer.text(b'')
        writer.put('I', length)
        writer.data += struct.pack('<I', 0) * min(length, 10_001)
        writer.put('d', 5.0)
        messages.append(writer.message())
    with pytest.raises(MessageError) as raised:
        decode_field(place, *join_messages(messages))
    assert raised.value.offsets == [0]
    assert decode_field(place, *join_messages(messages[1:])).values.tolist() == [5.0]


def test_angles_are_headings_within_a_turn():
    type_name = 'geometry_msgs/msg/TwistStamped'
    path = 'twist.angular.z'
    turns = [0.0, 0.25, -0.25, 1.0, -0.5, 1.2, -0.6, float('inf'), float('nan')]
    for unit, turn in (('deg', 360.0), ('rad', 2.0 * np.pi), ('rev', 1.0)):
        messages = [encode(type_name, nested(path, turn * share, 1, ''))
                    for share in turns]
        for axes, expected in (('', [0.0, 90.0, 270.0, 0.0, 180.0]),
                               ('ned', [0.0, 90.0, 270.0, 0.0, 180.0]),
                               ('enu', [90.0, 0.0, 180.0, 90.0, 270.0, np.nan, 306.0])):
            field = find_heading_field(type_name, definitions_of(type_name),
                                       HeadingPlace('gps', path, unit, axes), 'enu')
            headings = field.decode(*join_messages(messages))
            expected += [np.nan] * (len(turns) - len(expected))
            assert headings.heading_deg == pytest.approx(expected, nan_ok=True)


def test_sentences_are_texts_with_their_stamps():
    messages = [encode(SENTENCE, {'header': {'stamp': {'sec': at}, 'frame_id': 'x' * at},
                                  'sentence': 'a' * at}) for at in range(9)]
    place, _ = find_sentences(SENTENCE, {}, '')
    read = partial(read_sound, partial(decode_field, place), kind=FieldColumn)
    column, refused = read([*messages, b'', messages[3][:21]])
    assert column.values.tolist() == [b'a' * at for at in range(9)]
    assert column.stamp_ns.tolist() == [at * S for at in range(9)]
    assert refused == ['nmea_msgs/msg/Sentence message of 0 bytes is too short',
                       'nmea_msgs/msg/Sentence message of 21 bytes is too short']
    assert len(read([])[0]) == 0
