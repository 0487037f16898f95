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

"""One file: every loss is noticed, and no excessive claim is believed."""

from __future__ import annotations

import dataclasses
from io import FileIO
from pathlib import Path
import re
import struct
from typing import Sequence
import zlib

from bags.mcap_bytes import (
    channel,
    entries_of,
    HEADER,
    indexed,
    MAGIC,
    message,
    record,
    schema,
    sent,
    write,
)
from mcap import records as mcap
from mcap.writer import CompressionType, IndexType, Writer
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.index_records import build_ending, build_record
from heading_intercompare.bags.mcap.message_blocks import Record
from heading_intercompare.bags.mcap.record_stream import RecordStream
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.messages.cdr import encode

STRING = 'std_msgs/msg/String'
DEFINED = schema(1) + channel(1, '/a')


def ten(begin: int) -> list[bytes]:
    """Return ten messages."""
    return [message(1, log, encode(STRING, {'data': str(log)}))
            for log in range(begin, begin + 10)]


def closed(path, **options):
    """Write a file of three chunks with `mcap`, and return it with its bytes."""
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=200, compression=CompressionType.NONE, **options)
        writer.start('ros2')
        number = writer.register_channel('/a', 'cdr', writer.register_schema(
            STRING, 'ros2msg', b'string data\n'))
        for log in range(12):
            writer.add_message(number, log, encode(STRING, {'data': 'x' * 20}), log)
        writer.finish()
    return path, path.read_bytes()


def records(data: bytes) -> list[tuple[int, int, int]]:
    """Return opcode, begin and end of the records of a file."""
    found, at = [], len(MAGIC)
    while at < len(data) - len(MAGIC):
        end = at + 9 + int.from_bytes(data[at + 1:at + 9], 'little')
        found.append((data[at], at, end))
        at = end
    return found


def without_a_chunk(data: bytes) -> bytes:
    """Return a file without its second chunk and the indexes after that."""
    begins = [begin for opcode, begin, _ in records(data) if opcode == 6]
    return data[:begins[1]] + data[begins[2]:]


# Where it ends


@pytest.mark.parametrize('options', [{}, {'enable_crcs': False}], ids=str)
def test_a_chunk_cut_out_whole_is_missed(tmp_path, options):
    path, data = closed(tmp_path / 'a.mcap', **options)
    path.write_bytes(without_a_chunk(data))
    reader = BagReader(path)
    kept = len(list(reader.messages()))
    assert 0 < kept < 12
    assert reader.incomplete == f'a.mcap has {kept} messages where its index says 12'
    assert check_bag(path).faults == [reader.incomplete]


@pytest.mark.parametrize('behind', [lambda data: data, lambda data: bytes(100),
                                    lambda data: data[len(MAGIC):]], ids=['file', 'zeros', 'rest'])
def test_what_follows_the_end_is_named(tmp_path, behind):
    path, data = closed(tmp_path / 'a.mcap')
    path.write_bytes(data + behind(data))
    reader = BagReader(path)
    assert len(list(reader.messages())) == 12
    assert reader.incomplete == (
        f'a.mcap continues after its end, at byte {len(data)} of {path.stat().st_size}; '
        'the rest is not read')


def test_data_behind_what_looks_like_the_end_of_the_data_is_named(tmp_path):
    """A message index becomes the end of the data if one bit of its type flips."""
    path = write(tmp_path / 'a.mcap', indexed(DEFINED, *ten(0)), indexed(*ten(10)))
    data = bytearray(path.read_bytes())
    (_, begin, end), *_ = [each for each in records(data + MAGIC) if each[0] == 7]
    data[begin] = 0x0F
    path.write_bytes(data)
    reader = BagReader(path)
    assert len(list(reader.messages())) == 10
    assert reader.incomplete.startswith(f'a.mcap continues after its end, at byte {end} of ')


def test_a_damaged_index_of_a_closed_file_is_named(tmp_path):
    path, data = closed(tmp_path / 'a.mcap')
    at = next(begin for opcode, begin, _ in records(data) if opcode == 8)
    path.write_bytes(data[:at] + b'\x08' + b'\xff' * 8 + data[at + 9:])
    reader = BagReader(path)
    assert len(list(reader.messages())) == 12
    assert reader.incomplete == (f'a.mcap has an index that is damaged at byte {at}; its messages '
                                 'are there')


# Chunks that are no chunks any more


@pytest.mark.parametrize('bit', range(8))
def test_a_chunk_of_an_unfinished_file_that_lost_its_type_is_where_it_breaks_off(tmp_path, bit):
    lost = bytearray(indexed(*ten(2**40)))
    lost[0] ^= 1 << bit
    path = write(tmp_path / 'a.mcap', indexed(DEFINED, *ten(0)), bytes(lost),
                 indexed(*ten(20)))
    reader = BagReader(path)
    assert [m.log_time_ns for m in reader.messages()] == list(range(10))
    assert reader.incomplete.startswith('a.mcap was not closed: ')


def test_a_chunk_of_a_closed_file_that_lost_its_type_is_an_error_with_its_place(tmp_path):
    path, data = closed(tmp_path / 'a.mcap')
    begin, end = [each[1:] for each in records(data) if each[0] == 6][1]
    path.write_bytes(data[:begin] + b'\x86' + data[begin + 1:])
    with pytest.raises(BagError, match=rf'a message index follows no chunk \(at byte {end}\)'):
        list(BagReader(path).messages())


def test_without_message_indexes_it_is_missed_by_the_count(tmp_path):
    path, data = closed(tmp_path / 'a.mcap', index_types=IndexType.CHUNK)
    begin = [begin for opcode, begin, _ in records(data) if opcode == 6][1]
    path.write_bytes(data[:begin] + b'\x86' + data[begin + 1:])
    with pytest.raises(BagError, match=r'damaged: \d+ messages where its index says 12'):
        list(BagReader(path).messages())


# Metadata and attachments


def attachment(crc: int | None = None, size: int | None = None) -> bytes:
    """Return an attachment; its checksum and the size of its data are right unless given."""
    whole = bytearray(record(mcap.Attachment(create_time=1, log_time=2, name='a.txt',
                                             media_type='text/plain', data=b'calibration')))
    if size is not None:
        at = whole.index(b'calibration') - 8
        whole[at:at + 8] = struct.pack('<Q', size)
    if crc is not None:
        whole[-4:] = struct.pack('<I', crc)
    return bytes(whole)


def test_a_checksum_over_the_data_alone_is_accepted(tmp_path):
    """That is what pybag 0.13 writes."""
    path = write(tmp_path / 'a.mcap', attachment(crc=zlib.crc32(b'calibration')))
    assert [found.data for found in BagReader(path).attachments()] == [b'calibration']


def test_metadata_are_read_beside_a_damaged_attachment(tmp_path):
    remark = record(mcap.Metadata('remark', {'sea': 'calm'}))
    path = write(tmp_path / 'a.mcap', attachment(crc=1), remark)
    assert BagReader(path).metadata() == {'remark': {'sea': 'calm'}}
    with pytest.raises(BagError, match='attachment damaged: its checksum does not match'):
        BagReader(path).attachments()


@pytest.mark.parametrize('size', [2**64 - 1, 2**63, 2**62, 12])
def test_an_attachment_that_claims_more_than_it_has_is_an_error(tmp_path, size):
    path = write(tmp_path / 'a.mcap', attachment(crc=0, size=size))
    with pytest.raises(BagError, match='a record of type Attachment is damaged'):
        BagReader(path).attachments()
    (_, fault) = check_bag(path).faults
    assert fault.startswith('a.mcap: a record of type Attachment is damaged (at byte')


@pytest.mark.parametrize('offset', [2**63, 2**64 - 1, 10**6, 30, 8])
def test_what_the_index_has_in_the_wrong_place_is_found(tmp_path, offset):
    """The library @mcap/core writes such places where there are no chunks."""
    extras = record(mcap.Metadata('remark', {'sea': 'calm'})) + attachment()
    begun = MAGIC + HEADER + indexed(DEFINED, *ten(0)) + extras
    metadata = mcap.MetadataIndex(offset=offset, length=10, name='remark')
    attached = mcap.AttachmentIndex(offset=offset, length=10, log_time=2, create_time=1,
                                    data_size=11, name='a.txt', media_type='text/plain')
    path = tmp_path / 'a.mcap'
    path.write_bytes(begun + build_ending(len(begun), [mcap.Schema(
        data=b'string data\n', encoding='ros2msg', id=1, name=STRING)], [mcap.Channel(
            id=1, topic='/a', message_encoding='cdr', metadata={}, schema_id=1)], [],
        [build_record(attached)], [build_record(metadata)], {1: 10}, (0, 9)))
    reader = BagReader(path)
    assert reader.incomplete is None
    assert reader.metadata() == {'remark': {'sea': 'calm'}}
    assert [found.data for found in reader.attachments()] == [b'calibration']


def test_a_metadata_record_that_lost_its_type_is_missed(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata('remark', {'sea': 'calm'})
    path = bag.path / 'bag_0.mcap'
    data = bytearray(path.read_bytes())
    data[next(at for opcode, at, _ in records(data) if opcode == 12)] |= 0x80
    path.write_bytes(data)
    with pytest.raises(BagError, match=r'damaged: \d records of type Metadata where its'):
        BagReader(bag.path).metadata()


# Sizes that are claimed


SPARSE = 3 * 2**30


def sparse(path, *begun: bytes, behind: bytes = b''):
    """Write a file whose last record claims 3 GB that take no room on disk."""
    write(path, *begun)
    with path.open('r+b') as file:
        file.seek(SPARSE, 2)
        file.write(behind or bytes(8))
    return path


def test_no_message_outside_chunks_is_believed_that_claims_gigabytes(tmp_path):
    claims = struct.pack('<BQHIQQ', 5, SPARSE, 1, 0, 5, 5)
    reader = BagReader(sparse(tmp_path / 'a.mcap', DEFINED, *ten(0), claims))
    assert 'was not closed: a record of ' in reader.incomplete
    assert 'does not fit into memory' in reader.incomplete
    assert len(list(reader.messages())) == 10


def test_no_attachment_is_read_that_claims_gigabytes(tmp_path):
    path = sparse(tmp_path / 'a.mcap', indexed(DEFINED, *ten(0)), struct.pack('<BQ', 9, SPARSE))
    with pytest.raises(BagError, match=r'a record of 32\d+ bytes does not fit into memory'):
        BagReader(path).attachments()
    assert len(list(BagReader(path).messages())) == 10


@pytest.mark.parametrize('ahead', [b'', struct.pack('<BQI', 15, 4, 0)], ids=['data', 'its end'])
def test_no_summary_is_believed_that_claims_gigabytes(tmp_path, monkeypatch, ahead):
    read, sizes = RecordStream.content, []

    def content(self, record):
        found = read(self, record)
        sizes.append(len(found))
        return found

    monkeypatch.setattr(RecordStream, 'content', content)
    begun = indexed(DEFINED, *ten(0)) + ahead
    footer = record(mcap.Footer(len(MAGIC + HEADER + begun), 0, 0))
    path = sparse(tmp_path / 'a.mcap', begun, struct.pack('<BQ', 0x80, SPARSE),
                  behind=record(mcap.DataEnd(0)) + footer + MAGIC)
    reader = BagReader(path)
    assert reader.topics['/a'].count == len(list(reader.messages())) == 10
    assert max(sizes) < 1000


def test_what_does_not_fit_into_memory_is_an_error_with_its_place(tmp_path):
    path, _ = closed(tmp_path / 'a.mcap')

    class Full(FileIO):
        def read(self, size=-1):
            raise MemoryError

    with Full(path) as file:
        stream = RecordStream(file)
        with pytest.raises(BagError, match=r'a record of 5 bytes does not fit.* \(at byte 17\)'):
            stream.content(Record(1, 17, 5))


def test_a_name_of_an_attachment_that_is_no_utf8_costs_only_its_letters(tmp_path):
    with BagWriter(tmp_path / 'bag') as bag:
        bag.attachment('nameX.csv', 'text/csv', b'data')
        bag.attachment('other', 'text/plain', b'more')
    path = tmp_path / 'bag' / 'bag_0.mcap'
    data = path.read_bytes()
    at = data.index(b'nameX.csv')
    # Two times and the length of the name come before it.
    begin = at - 20
    changed = bytearray(data)
    changed[at + 4] = 0xff
    end = data.index(b'data', at) + 4
    changed[end:end + 4] = zlib.crc32(changed[begin:end]).to_bytes(4, 'little')
    path.write_bytes(changed)
    assert [(one.name, one.data) for one in BagReader(tmp_path / 'bag').attachments()] == [
        ('name\ufffd.csv', b'data'), ('other', b'more')]


def test_a_channel_that_is_defined_in_two_ways_ends_the_reading_and_mixes_nothing(tmp_path):
    path = write(tmp_path / 'x.mcap',
                 indexed(schema(1), channel(1, '/a'), message(1, 1, b'x')),
                 indexed(channel(1, '/a'), message(1, 2, b'y')),
                 indexed(channel(1, '/b'), message(1, 3, b'z')))
    reader = BagReader(path)
    assert 'channel 1 is both /a and /b at byte' in reader.incomplete
    assert [(m.topic, m.data) for m in reader.messages()] == [('/a', b'x'), ('/a', b'y')]
    assert list(reader.topics) == ['/a'] and reader.topics['/a'].count == 2


def test_names_that_are_no_utf8_do_not_hide_sound_topics(tmp_path):
    """One such topic, type or record of metadata made the whole bag unreadable."""
    def spoil(piece):
        return piece.replace(b'@@', b'\xff\xfe')
    path = write(tmp_path / 'x.mcap', indexed(
        schema(1), spoil(schema(2, '@@')), channel(1, '/a'), spoil(channel(2, '/@@', 2)),
        message(1, 1, b'x'), message(2, 2, b'y'), message(1, 3, b'z')),
        spoil(record(mcap.Metadata(name='@@', metadata={'@@': '@@'}))))
    reader = BagReader(path)
    assert {name: one.type_name for name, one in reader.topics.items()} == {
        '/a': 'std_msgs/msg/String', r'/\xff\xfe': r'\xff\xfe'}
    assert [m.data for m in reader.messages(['/a'])] == [b'x', b'z']
    assert reader.metadata()[r'\xff\xfe'] == {r'\xff\xfe': r'\xff\xfe'}
    recover(path, tmp_path / 'new')
    assert sent(tmp_path / 'new') == sent(path)


def contradicting(path: Path, index: Sequence[mcap.Schema | mcap.Channel], *records: bytes,
                  ) -> Path:
    """Write a closed file of a chunk, whose index has other definitions."""
    rows = indexed(*records)
    counts = {number: len(entries) for number, entries in entries_of(b''.join(records)).items()}
    times = [log for entries in entries_of(b''.join(records)).values() for log, _ in entries]
    schemas = [item for item in index if isinstance(item, mcap.Schema)]
    channels = [item for item in index if isinstance(item, mcap.Channel)]
    begun = write(path, rows)
    path.write_bytes(begun.read_bytes() + build_ending(
        begun.stat().st_size, schemas, channels, [], [], [], counts, (min(times), max(times))))
    return path


TEXT = mcap.Schema(id=1, name='std_msgs/msg/String', encoding='ros2msg', data=b'string data\n')
SENT = [schema(1), channel(1, '/ts/heading'), channel(2, '/rs/heading'), message(1, 1, b'x'),
        message(2, 2, b'y')]


def in_index(number: int, topic: str, schema_id: int = 1, encoding: str = 'cdr') -> mcap.Channel:
    return mcap.Channel(id=number, topic=topic, message_encoding=encoding, metadata={},
                        schema_id=schema_id)


@pytest.mark.parametrize(('index', 'problem'), [
    ([TEXT, in_index(1, '/rs/heading'), in_index(2, '/ts/heading')],
     'channel 1 is both /rs/heading and /ts/heading'),
    ([TEXT, in_index(1, '/ts/heading'), in_index(2, '/rs/heading', encoding='json')],
     'channel 2 (/rs/heading) is defined in two ways'),
    ([TEXT, mcap.Schema(id=2, name='a/A', encoding='ros2msg', data=b'int32 x\n'),
      in_index(1, '/ts/heading', 2), in_index(2, '/rs/heading')],
     'channel 1 (/ts/heading) is defined in two ways'),
    ([dataclasses.replace(TEXT, name='a/msg/A'), in_index(1, '/ts/heading'),
      in_index(2, '/rs/heading')], 'schema 1 is both a/msg/A and std_msgs/msg/String'),
    ([dataclasses.replace(TEXT, data=b'int32 data\n'), in_index(1, '/ts/heading'),
      in_index(2, '/rs/heading')], 'schema 1 (std_msgs/msg/String) is defined in two ways')])
def test_an_index_that_contradicts_the_definitions_in_the_data_is_an_error(tmp_path, index,
                                                                           problem):
    """Swapped topics turn the sign of the mean. What `recover` writes has those of the data."""
    path = contradicting(tmp_path / 'x.mcap', index, *SENT)
    place = f'{problem}: the index of the file contradicts the data'
    reader = BagReader(path)
    assert reader.incomplete is None
    with pytest.raises(BagError, match=re.escape(place) + '.*at byte 29') as raised:
        list(reader.messages())
    assert str(path) in str(raised.value)
    assert any(place in fault for fault in check_bag(path).faults)
    recover(path, tmp_path / 'new')
    assert [(m.topic, m.data) for m in sent(tmp_path / 'new')] == [
        ('/ts/heading', b'x'), ('/rs/heading', b'y')]


def test_an_index_whose_definitions_say_the_same_in_other_words_contradicts_nothing(tmp_path):
    """The metadata of a channel decide nothing, nor does a channel without messages."""
    path = contradicting(tmp_path / 'x.mcap', [
        TEXT, in_index(1, '/ts/heading'), in_index(2, '/rs/heading')], *SENT, channel(3, '/more'))
    assert [(m.topic, m.data) for m in sent(path)] == [('/ts/heading', b'x'),
                                                       ('/rs/heading', b'y')]
    assert check_bag(path).faults == []


def test_a_schema_that_is_defined_in_two_ways_ends_the_reading(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(*SENT), indexed(schema(1, text=b'int32 data\n'),
                                                              message(1, 3, b'z')))
    reader = BagReader(path)
    assert 'schema 1 (std_msgs/msg/String) is defined in two ways at byte' in reader.incomplete
    assert [m.data for m in reader.messages()] == [b'x', b'y']
