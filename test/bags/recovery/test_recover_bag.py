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

"""The recovery of damaged bags: what is kept, what is reported lost, which readers accept it."""

from __future__ import annotations

from pathlib import Path
import shutil
import time
import tracemalloc
import zlib

from bags.mcap_bytes import (
    assert_exact,
    channel,
    chunk,
    entries_of,
    HEADER,
    indexed,
    MAGIC,
    message,
    message_index,
    record,
    schema,
    Sent,
    sent,
    write,
)
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Chunk, Metadata, Schema
from mcap.stream_reader import breakup_chunk, StreamReader
from mcap.writer import Writer
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.scanner import Salvage
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.cli import main
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import IMU

STRING = 'std_msgs/msg/String'


def message_file(bag: Path) -> Path:
    return bag / f'{bag.name}_0.mcap'


def chunk_places(path: Path) -> list[tuple[int, int, int]]:
    """Return where each chunk of a whole file starts and ends, and how many messages it has."""
    with open(path, 'rb') as file:
        return [(chunk.start, chunk.end, sum(count for _, count in chunk.counts))
                for item in Salvage(file).scan() if item.run for chunk in item.run.chunks]


def all_messages(path: Path) -> list:
    return list(BagReader(path).messages())


def spoil(path: Path, at: int, data: bytes = b'\x5a\xa5\x5a') -> None:
    content = path.read_bytes()
    path.write_bytes(content[:at] + data + content[at + len(data):])


def cut(path: Path, size: int) -> None:
    path.write_bytes(path.read_bytes()[:size])


def test_a_whole_bag_comes_back_whole(write_bag, tmp_path):
    path = write_bag()
    total = recover(path, tmp_path / 'new')
    assert all_messages(tmp_path / 'new') == all_messages(path)
    assert (total.messages, total.messages_lost, total.messages_known) == (3000, 0, True)
    assert total.counts == {'/ts/heading': 2000, '/rs/heading': 1000}
    assert not total.damaged and total.bytes_lost == 0 and total.chunks_lost == 0
    assert BagReader(tmp_path / 'new').incomplete is None


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_a_damaged_chunk_is_left_out_and_counted(write_bag, tmp_path, compression):
    path = write_bag(compression=compression, chunk_bytes=50_000)
    before = all_messages(path)
    start, end, count = chunk_places(message_file(path))[5]
    spoil(message_file(path), (start + end) // 2)
    with pytest.raises(BagError, match='checksum|damaged'):
        all_messages(path)
    total = recover(path, tmp_path / 'new')
    after = all_messages(tmp_path / 'new')
    first = sum(n for _, _, n in chunk_places(message_file(write_bag(
        'again', compression=compression, chunk_bytes=50_000)))[:5])
    assert after == before[:first] + before[first + count:]
    assert (total.messages, total.messages_lost) == (3000 - count, count)
    assert total.messages_known and total.chunks_lost == 1
    assert total.bytes_lost == end - start
    assert total.notes == [f'trial_0.mcap: bytes {start} to {end}: {fault(total.notes[0])}']


def fault(note: str) -> str:
    assert 'damaged' in note
    return note.split(': ', 2)[2]


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
@pytest.mark.parametrize('share', [0.1, 0.5, 0.9, 0.999])
def test_of_a_cut_bag_all_before_the_cut_is_kept(write_bag, tmp_path, compression, share):
    path = write_bag(compression=compression, chunk_bytes=20_000)
    before = all_messages(path)
    places = chunk_places(message_file(path))
    size = int(share * message_file(path).stat().st_size)
    cut(message_file(path), size)
    total = recover(path, tmp_path / 'new')
    after = all_messages(tmp_path / 'new')
    assert after == before[:len(after)]
    assert len(after) == total.messages >= sum(n for _, end, n in places if end <= size)
    assert 'trial_0.mcap: was not closed' in total.notes
    assert total.chunks_lost == any(start + 61 < size < end for start, end, _ in places)


def test_of_a_cut_chunk_the_beginning_is_kept(write_bag, tmp_path):
    path = write_bag(compression='none', chunk_bytes=300_000)
    before = all_messages(path)
    (_, _, count), (start, end, _), *_ = chunk_places(message_file(path))
    cut(message_file(path), (start + end) // 2)
    total = recover(path, tmp_path / 'new')
    assert count + 350 < total.messages < 3000
    assert all_messages(tmp_path / 'new') == before[:total.messages]
    assert not total.messages_known


def test_a_summary_tells_what_is_lost_where_no_index_does(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    (start, _, one), (_, _, two), (third, _, _) = chunk_places(message_file(path))[4:7]
    content = message_file(path).read_bytes()
    message_file(path).write_bytes(content[:start] + bytes(third - start) + content[third:])
    total = recover(path, tmp_path / 'new')
    assert (total.messages_lost, total.messages_known) == (one + two, True)
    assert total.bytes_lost == third - start


def test_topics_defined_only_in_a_damaged_chunk_are_found_in_the_summary(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    start, end, count = chunk_places(message_file(path))[0]
    spoil(message_file(path), (start + end) // 2)
    total = recover(path, tmp_path / 'new')
    assert (total.messages, total.messages_lost) == (3000 - count, count)


def test_topics_defined_in_a_damaged_chunk_are_found_later_in_a_file_without_an_end(
        write_bag, tmp_path):
    path = write_bag(chunk_bytes=10_000)
    places = chunk_places(message_file(path))
    assert len(places) > 70
    spoil(message_file(path), (places[0][0] + places[0][1]) // 2)
    cut(message_file(path), places[40][1])
    total = recover(path, tmp_path / 'new')
    assert total.messages == sum(n for _, _, n in places[1:41])
    assert total.messages_lost == places[0][2]


def test_without_any_definition_the_messages_are_counted_as_lost(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    places = chunk_places(message_file(path))
    spoil(message_file(path), (places[0][0] + places[0][1]) // 2)
    cut(message_file(path), places[9][1])
    with pytest.raises(BagError, match='nothing in it is readable'):
        recover(path, tmp_path / 'new')
    assert not (tmp_path / 'new').exists()


def test_metadata_attachments_and_qos_come_along(tmp_path):
    with BagWriter(tmp_path / 'old') as bag:
        bag.add_topic('/remark', STRING, Qos(depth=7, durability='transient_local'))
        bag.metadata('heading_intercompare', {'version': '1.2'})
        bag.write('/remark', encode(STRING, {'data': 'x'}), 10, 9, 3)
        bag.attachment('runs.csv', 'text/csv', b'start,stop\n', 7)
    (tmp_path / 'old' / 'metadata.yaml').unlink()
    cut(message_file(bag.path), message_file(bag.path).stat().st_size - 20)
    recover(tmp_path / 'old', tmp_path / 'new')
    reader = BagReader(tmp_path / 'new')
    assert reader.topics['/remark'].qos == Qos(depth=7, durability='transient_local')
    assert reader.metadata()['heading_intercompare'] == {'version': '1.2'}
    assert reader.metadata()['recovery']['messages_lost'] == '0'
    attachment, = reader.attachments()
    assert (attachment.name, attachment.data, attachment.log_time_ns) == (
        'runs.csv', b'start,stop\n', 7)
    message, = reader.messages()
    assert (message.log_time_ns, message.publish_time_ns, message.sequence) == (10, 9, 3)


def test_all_files_of_a_bag_are_read_and_a_missing_one_is_named(write_bag, tmp_path):
    path = write_bag('bag', chunk_bytes=20_000)
    shutil.copy(write_bag('more') / 'more_0.mcap', path / 'bag_1.mcap')
    (path / 'bag_2.mcap').touch()
    text = (path / 'metadata.yaml').read_text()
    (path / 'metadata.yaml').write_text(
        text.replace('- bag_0.mcap', '- bag_0.mcap\n    - bag_9.mcap'))
    total = recover(path, tmp_path / 'new')
    assert (total.files, total.messages) == (3, 6000)
    assert total.notes == ['bag_2.mcap: is empty (0 bytes)', 'bag_9.mcap: is missing']
    assert not total.messages_known


@pytest.mark.parametrize('content, note', [
    (b'', 'rosbag2_bagfile_information is missing'), (bytes(3000), 'line 1: not YAML: '),
    (b'rosbag2_bagfile_information:\n  relative_file_paths: [a_0.mcap, \xff', 'line 2: not UTF-8'),
    (b'rosbag2_bagfile_information: &a\n  x: *a\n', 'line 2: the alias *a stands'),
    (b'[' * 10**6, 'line 1: nested deeper'), (b'#' * (2**24 + 1), 'longer than 16777216 bytes')])
def test_damaged_metadata_keep_no_file_from_being_recovered(write_bag, tmp_path, content, note):
    path = write_bag('bag', chunk_bytes=20_000)
    shutil.copy(write_bag('more') / 'more_0.mcap', path / 'bag_1.mcap')
    (path / 'metadata.yaml').unlink()
    plain = recover(path, tmp_path / 'plain')
    (path / 'metadata.yaml').write_bytes(content)
    total = recover(path, tmp_path / 'new')
    assert (total.counts, total.messages_known) == (plain.counts, plain.messages_known)
    assert (total.files, plain.notes) == (2, [])
    assert len(total.notes) == 1 and total.notes[0].startswith('metadata.yaml: ' + note)
    assert BagReader(tmp_path / 'new').incomplete is None


@pytest.mark.parametrize('content', [b'', bytes(3000), b'not a bag\n' * 30,
                                     b'\x89MCAP0\r\n', b'\x89MCAP0\r\n' + bytes(3000)])
def test_where_nothing_is_readable_no_bag_is_written(tmp_path, content):
    (tmp_path / 'x.mcap').write_bytes(content)
    with pytest.raises(BagError, match='x.mcap: nothing in it is readable') as caught:
        recover(tmp_path / 'x.mcap', tmp_path / 'new')
    assert '\n' not in str(caught.value)
    assert not (tmp_path / 'new').exists()


def test_a_folder_without_files_is_refused(tmp_path):
    with pytest.raises(BagError, match='holds no .mcap file'):
        recover(tmp_path, tmp_path / 'new')


def test_an_existing_bag_is_not_overwritten(write_bag, tmp_path):
    path = write_bag()
    with pytest.raises(BagError, match='already exists'):
        recover(path, path)


def test_a_bag_is_not_written_into_the_one_that_is_recovered(write_bag, tmp_path):
    path = write_bag()
    for target in (path / 'new.mcap', path / 'a' / 'b', tmp_path / 'x' / '..' / path.name / 'c'):
        with pytest.raises(BagError, match='lies inside the bag to recover; write it next to'):
            recover(path, target)
    assert sorted(p.name for p in path.iterdir()) == ['metadata.yaml', 'trial_0.mcap']
    recover(path / 'trial_0.mcap', path / 'of_the_file')


def test_an_empty_bag_that_was_closed_is_no_loss(tmp_path):
    with BagWriter(tmp_path / 'old') as bag:
        bag.metadata('heading_intercompare', {'version': '1'})
    total = recover(bag.path, tmp_path / 'new')
    assert not total.damaged
    assert BagReader(tmp_path / 'new').metadata()['heading_intercompare'] == {'version': '1'}


def test_one_topic_with_two_types_becomes_two_topics(tmp_path):
    with open(tmp_path / 'x.mcap', 'wb') as file:
        writer = Writer(file)
        writer.start('ros2')
        for i, kind in enumerate(('a/msg/A', 'b/msg/B')):
            schema = writer.register_schema(kind, 'ros2msg', b'int32 x\n')
            writer.add_message(writer.register_channel('/t', 'cdr', schema), i, bytes(8), i)
        writer.finish()
    total = recover(tmp_path / 'x.mcap', tmp_path / 'new')
    assert total.counts == {'/t': 1, '/t_b': 1}
    assert {n: t.type_name for n, t in BagReader(tmp_path / 'new').topics.items()} == {
        '/t': 'a/msg/A', '/t_b': 'b/msg/B'}


@pytest.mark.slow
def test_the_recovered_bag_is_read_by_rosbags_and_mcap(write_bag, tmp_path):
    rosbag2 = pytest.importorskip('rosbags.highlevel')
    decoder = pytest.importorskip('mcap_ros2.decoder')
    reader = pytest.importorskip('mcap.reader')
    path = write_bag(chunk_bytes=20_000)
    start, end, count = chunk_places(message_file(path))[7]
    spoil(message_file(path), (start + end) // 2)
    cut(message_file(path), message_file(path).stat().st_size - 9)
    recover(path, tmp_path / 'new')
    ours = [(m.topic, m.log_time_ns) for m in BagReader(tmp_path / 'new').messages()]
    with rosbag2.AnyReader([tmp_path / 'new']) as bag:
        theirs = [(c.topic, stamp) for c, stamp, data in bag.messages()
                  if bag.deserialize(data, c.msgtype).__msgtype__ == IMU]
    assert theirs == ours and len(ours) == 3000 - count
    with open(tmp_path / 'new' / 'new_0.mcap', 'rb') as file:
        decoded = list(reader.make_reader(
            file, validate_crcs=True,
            decoder_factories=[decoder.DecoderFactory()]).iter_decoded_messages())
    assert [(c.topic, m.log_time) for _, c, m, _ in decoded] == ours


def test_definitions_are_repeated_in_long_files(write_bag):
    path = write_bag(compression='none', chunk_bytes=10_000)
    with open(message_file(path), 'rb') as file:
        chunks = [r for r in StreamReader(file, emit_chunks=True, validate_crcs=True).records
                  if isinstance(r, Chunk)]
    assert len(chunks) > 70
    assert [b'/rs/heading' in c.data for c in chunks].count(True) >= 1 + len(chunks) // 32


def test_sound_chunks_go_over_byte_by_byte_with_their_indexes(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    rows = chunk_places(message_file(path))
    start, end, _ = rows[7]
    spoil(message_file(path), (start + end) // 2)
    before = message_file(path).read_bytes()
    recover(path, tmp_path / 'new')
    after = (tmp_path / 'new' / 'new_0.mcap').read_bytes()
    places = [chunk for i, chunk in enumerate(rows) if i != 7]
    found = chunk_places(tmp_path / 'new' / 'new_0.mcap')
    assert [after[lo:hi] for lo, hi, _ in found] == [before[lo:hi] for lo, hi, _ in places]
    behind = [lo for lo, _, _ in rows[1:]]
    assert all(before[hi:behind[i]] in after for i, (_, hi, _) in enumerate(rows[:-1]) if i != 7)
    assert_exact(tmp_path / 'new')


TWO = schema(1), channel(1, '/a'), channel(2, '/b')


def ten(numbers: tuple[int, ...] = (1, 2), begin: int = 1000, step: int = 10) -> list[bytes]:
    """Return ten messages of alternating channels."""
    return [message(numbers[i % len(numbers)], begin + step * i, text(str(begin + i)), sequence=i)
            for i in range(10)]


def text(words: str) -> bytes:
    return encode(STRING, {'data': words})


def as_sent(topics: tuple[str, ...] = ('/a', '/b'), begin: int = 1000, step: int = 10) -> list:
    """Return what `ten` has sent."""
    return [Sent(topics[i % len(topics)], begin + step * i, begin + step * i, i,
                 text(str(begin + i))) for i in range(10)]


def recovered(path: Path, settings: BagSettings | None = None) -> list:
    """Recover a bag and return its messages; check the result with `mcap` too."""
    target = path.with_suffix('.new')
    total = recover(path, target, settings)
    assert_exact(target)
    found = sent(target)
    assert len(found) == total.messages == sum(total.counts.values())
    try:
        import rosbags.highlevel as rosbags
    except ImportError:
        return found
    with rosbags.AnyReader([target]) as bag:
        theirs = sorted((c.topic, stamp, data) for c, stamp, data in bag.messages())
    assert theirs == sorted((m.topic, m.log_time_ns, m.data) for m in found)
    return found


def file_of(path: Path) -> bytes:
    """Return the only file of a recovered bag."""
    return next(path.with_suffix('.new').glob('*.mcap')).read_bytes()


def test_definitions_twice_in_a_chunk_do_no_harm(tmp_path):
    piece = indexed(*TWO, *ten(), *TWO, *ten(begin=2000))
    path = write(tmp_path / 'x.mcap', piece)
    assert recovered(path) == as_sent() + as_sent(begin=2000)
    assert piece in file_of(path)


def test_what_is_written_anew_is_compressed_as_most_chunks_are(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(schema(7), *TWO, *ten(), compression='zstd'), *(
        indexed(*ten(begin=1000 * i), compression='lz4') for i in (2, 3, 4)))
    assert recovered(path) == [m for i in range(1, 5) for m in as_sent(begin=1000 * i)]
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        assert {r.compression for r in StreamReader(file, emit_chunks=True).records
                if isinstance(r, Chunk)} == {'lz4'}


@pytest.mark.parametrize('again, left', [
    (channel(1, '/c'), ('', '/b')), (channel(1, '/c') + channel(2, '/d'), ('', '')),
    (schema(1, 'a/msg/A', b'int32 x\n'), ('', '')), (channel(1, '/a', encoding='x'), ('', '/b'))])
@pytest.mark.parametrize('place', ['own', 'first', 'middle', 'back'])
def test_messages_of_a_number_that_means_two_things_are_left_out(tmp_path, again, left, place):
    """In a chunk of its own, before the messages of a chunk, between them, and back again."""
    pieces = {'own': [indexed(*ten(begin=2000)), indexed(again), indexed(*ten(begin=3000))],
              'first': [indexed(*ten(begin=2000)), indexed(again, *ten(begin=3000))],
              'middle': [indexed(*ten(begin=2000), again, *ten(begin=3000))],
              'back': [indexed(*ten(begin=2000), again), indexed(*TWO, *ten(begin=3000))]}[place]
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), *pieces, indexed(*ten(begin=4000)))
    expected = [m for begin in (1000, 2000, 3000, 4000) for m in as_sent(left, begin) if m.topic]
    if not expected:
        with pytest.raises(BagError, match='(channel|schema) 1 is both'):
            recover(path, tmp_path / 'new')
        return
    assert recovered(path) == expected
    total = recover(path, tmp_path / 'again')
    assert total.messages_lost == 20 and total.messages == 20
    assert any('channel 1 is both /a and ' in note for note in total.notes)


def test_a_definition_that_says_the_same_in_other_words_contradicts_nothing(tmp_path):
    """Only topic, type and encoding decide to what messages belong."""
    again = record(Channel(id=1, topic='/a', message_encoding='cdr', metadata={'x': 'y'},
                           schema_id=1))
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), indexed(again, *ten(begin=2000)))
    assert recovered(path) == as_sent() + as_sent(begin=2000)


def test_a_number_that_a_definition_without_checksum_contradicts_keeps_its_meaning(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), channel(1, '/c'),
                 indexed(channel(2, '/d'), *ten(begin=2000), crc=0))
    assert recovered(path) == as_sent() + as_sent(begin=2000)


@pytest.mark.parametrize('pieces', [
    [indexed(*ten(), *TWO), indexed(*ten(begin=2000))],
    [indexed(*ten()), indexed(*ten(begin=2000), *TWO)],
    [indexed(*ten()), indexed(*ten(begin=2000)), *TWO]])
def test_definitions_behind_the_messages_come_before_them(tmp_path, pieces):
    path = write(tmp_path / 'x.mcap', *pieces)
    assert recovered(path) == as_sent() + as_sent(begin=2000)


@pytest.mark.parametrize('lost', [False, True])
def test_a_file_appended_to_another_has_its_own_definitions(tmp_path, lost):
    """Even if they are lost: nobody knows what its messages are then."""
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), MAGIC, HEADER,
                 b'' if lost else indexed(schema(1), channel(1, '/b'), channel(2, '/a')),
                 indexed(*ten(begin=2000)))
    assert recovered(path) == as_sent() + ([] if lost else as_sent(('/b', '/a'), 2000))


@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_a_chunk_without_checksum_gets_one(tmp_path, compression):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten(), crc=0, compression=compression),
                 indexed(*ten(begin=2000), crc=0, compression=compression))
    assert recovered(path) == as_sent() + as_sent(begin=2000)
    assert indexed(*TWO, *ten(), compression=compression) in file_of(path)


def wrong_indexes() -> dict[str, list[bytes]]:
    rows = entries_of(b''.join(ten()))
    shifted = {n: [(log, at + 1) for log, at in entries] for n, entries in rows.items()}
    late = {n: [(log + 1, at) for log, at in entries] for n, entries in rows.items()}
    return {
        'missing': [], 'of one channel only': [message_index(1, rows[1])],
        'incomplete': [message_index(1, rows[1][:-1]), message_index(2, rows[2])],
        'shifted': [message_index(*row) for row in shifted.items()],
        'late': [message_index(*row) for row in late.items()],
        'of other channels': [message_index(1, rows[2]), message_index(2, rows[1])],
        'huge places': [message_index(n, [(log, 2**63 + 5) for log, _ in entries])
                        for n, entries in rows.items()],
        'one too many': [message_index(1, [*rows[1], rows[1][0]]), message_index(2, rows[2])],
        'in two pieces': [message_index(1, rows[1][:2]), message_index(1, rows[1][2:]),
                          message_index(2, rows[2])],
        'not of whole entries': [message_index(1, rows[1])[:-3], message_index(2, rows[2])],
        'cut': [message_index(1, rows[1]), message_index(2, rows[2])[:-20]]}


@pytest.mark.parametrize('why', wrong_indexes())
@pytest.mark.parametrize('compression', ['', 'zstd'])
def test_wrong_message_indexes_are_mended(tmp_path, why, compression):
    definitions = indexed(*TWO, *ten(begin=500), compression=compression)
    path = write(tmp_path / 'x.mcap', definitions, chunk(*ten(), compression=compression),
                 *wrong_indexes()[why], indexed(*ten(begin=2000), compression=compression))
    assert recovered(path) == as_sent(begin=500) + as_sent() + as_sent(begin=2000)
    assert chunk(*ten(), compression=compression) in file_of(path)


def test_right_message_indexes_in_any_order_and_empty_ones_are_kept(tmp_path):
    rows = entries_of(b''.join(ten()))
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten(begin=500)), chunk(*ten()),
                 message_index(2, rows[2][::-1]), message_index(1, rows[1]), message_index(7, []))
    assert recovered(path) == as_sent(begin=500) + as_sent()


@pytest.mark.parametrize('settings, expected', [
    (None, ['', 'lz4', 'zstd', 'zstd']), (BagSettings(compression='lz4'), ['lz4'] * 3),
    (BagSettings(compression='none'), [''] * 2), (BagSettings(compression='zstd'), ['zstd'] * 3)])
def test_chunks_stay_compressed_as_they_are_unless_it_is_asked_for(tmp_path, settings, expected):
    kinds = ('', 'lz4', 'zstd', 'zstd')
    path = write(tmp_path / 'x.mcap', *(
        indexed(*TWO, *ten(begin=1000 * i), compression=kind) for i, kind in enumerate(kinds, 1)))
    assert recovered(path, settings) == [m for i in range(1, 5) for m in as_sent(begin=1000 * i)]
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        found = [r.compression for r in StreamReader(file, emit_chunks=True).records
                 if isinstance(r, Chunk)]
    assert found == expected


@pytest.mark.parametrize('times', [None, (0, 2**62), (1005, 1006), (2000, 2001)])
def test_log_times_in_any_order_and_wrong_ones_in_the_head(tmp_path, times):
    messages = ten(step=-10)
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten(begin=5000)),
                 indexed(*messages, times=times), indexed(*ten(begin=3000)))
    assert recovered(path) == as_sent(begin=5000) + as_sent(step=-10) + as_sent(begin=3000)
    assert indexed(*messages) in file_of(path)


@pytest.mark.parametrize('strange', [
    channel(9, '/x', schema_id=5), b''])
def test_messages_of_channels_that_are_not_defined_are_counted(tmp_path, strange):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, strange, *ten()),
                 indexed(*ten((1, 9, 2, 9), begin=2000)), indexed(*ten(begin=3000)))
    assert recovered(path) == [*as_sent(), *as_sent(('/a', '', '/b', ''), 2000)[::2],
                               *as_sent(begin=3000)]
    total = recover(path, tmp_path / 'again')
    assert total.messages_lost == 5 and '5 messages of topics that are not defined' in str(
        total.notes)


def test_of_a_chunk_with_wrong_records_the_first_are_kept_and_the_others_counted(tmp_path):
    """It has no checksum; the indexes after it tell how many messages it had."""
    records = b''.join(ten())
    at = entries_of(records)[1][3][1]
    wrong = records[:at + 8] + b'\x7f' + records[at + 9:]
    behind = b''.join(message_index(*row) for row in entries_of(records).items())
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten(begin=500)),
                 chunk(wrong, crc=0, times=(1000, 1090)) + behind, indexed(*ten(begin=2000)))
    assert recovered(path) == as_sent(begin=500) + as_sent()[:6] + as_sent(begin=2000)
    total = recover(path, tmp_path / 'again')
    assert (total.messages_lost, total.chunks_lost) == (4, 1)


def test_records_do_not_reach_from_one_chunk_into_the_next(tmp_path):
    """Joined they would be valid; each on its own they are not."""
    records = b''.join(ten(begin=2000))
    at = entries_of(records)[1][2][1] + 20
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()),
                 chunk(records[:at], crc=0, times=(2000, 2090)),
                 chunk(records[at:], crc=0, times=(2000, 2090)), indexed(*ten(begin=3000)))
    assert recovered(path) == as_sent() + as_sent(begin=2000)[:4] + as_sent(begin=3000)
    assert recover(path, tmp_path / 'again').chunks_lost == 2


def test_records_that_do_not_belong_in_a_chunk_are_left_out(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), indexed(
        *ten(begin=2000), b'\x0c' + bytes([8]) + bytes(15), b'\x90' + bytes(8)))
    assert recovered(path) == as_sent() + as_sent(begin=2000)


def test_times_that_cannot_be(tmp_path):
    """A log time after 2262 cannot be kept; a publish time becomes the log time."""
    path = write(tmp_path / 'x.mcap', indexed(
        *TWO, *ten(), message(1, 2**63, b'', 5), message(1, 7, b'', 2**63 + 1)), indexed(
        message(2, 2**64 - 1, b'')))
    assert recovered(path) == [*as_sent(), Sent('/a', 7, 7, 0, b'')]
    total = recover(path, tmp_path / 'again')
    assert total.messages_lost == 2 and 'x.mcap: 2 messages with impossible log times' in (
        total.notes)


def test_messages_between_chunks_are_kept_in_their_place(tmp_path):
    path = write(tmp_path / 'x.mcap', *TWO, *ten(), indexed(*ten(begin=2000)), *ten(begin=3000),
                 indexed(*TWO, *ten(begin=4000)), *ten(begin=5000))
    assert recovered(path) == [m for i in range(1, 6) for m in as_sent(begin=1000 * i)]


@pytest.mark.parametrize('whole', [True, False])
def test_what_is_left_of_a_chunk_without_its_head_is_left_out(tmp_path, whole):
    """It looks like messages outside chunks, but a checksum that nobody knows belongs to it."""
    torn = indexed(*TWO, *ten(), compression='')
    path = write(tmp_path / 'x.mcap', torn if whole else torn[10:],
                 indexed(*TWO, *ten(begin=2000), compression=''))
    assert recovered(path) == (as_sent() if whole else []) + as_sent(begin=2000)
    total = recover(path, tmp_path / 'again')
    assert ('messages without their chunk' in str(total.notes)) is not whole


@pytest.mark.parametrize('rest', [b'\xee' * 50, bytes(50)])
def test_messages_in_a_damaged_chunk_are_not_taken_for_messages_outside_chunks(tmp_path, rest):
    """No chunk of the file is sound, but the head of one proves that there are chunks."""
    path = write(tmp_path / 'x.mcap', chunk(*TWO, *ten(), compression='', crc=7), rest)
    with pytest.raises(BagError, match='nothing in it is readable'):
        recover(path, tmp_path / 'new')


def test_without_any_chunk_the_messages_behind_damage_are_kept(tmp_path):
    path = write(tmp_path / 'x.mcap', *TWO, *ten(), bytes(50), *ten(begin=2000))
    assert recovered(path) == as_sent()[:-1] + as_sent(begin=2000)


@pytest.mark.parametrize('cut', [1, 5, 9, 20, 30])
def test_messages_outside_chunks_are_kept_up_to_the_one_in_which_the_file_ends(tmp_path, cut):
    path = write(tmp_path / 'x.mcap', *TWO, *ten(), message(1, 5, text('cut'))[:cut])
    assert recovered(path) == as_sent()


@pytest.mark.parametrize('first', [(1, 2), (300, 258)])
@pytest.mark.parametrize('second', [(3, 1), (1000, 300)])
def test_files_whose_numbers_differ_are_joined(tmp_path, first, second):
    (tmp_path / 'bag').mkdir()
    write(tmp_path / 'bag' / 'bag_0.mcap',
          indexed(schema(1), channel(first[0], '/a'), channel(first[1], '/b'), *ten(first)),
          indexed(*ten(first, 2000)))
    write(tmp_path / 'bag' / 'bag_1.mcap', indexed(
        schema(4), channel(second[1], '/c', 4), channel(second[0], '/a', 4), *ten(second, 3000)),
        indexed(*ten(second, 4000)))
    assert recovered(tmp_path / 'bag') == [*as_sent(), *as_sent(begin=2000),
                                           *as_sent(('/a', '/c'), 3000),
                                           *as_sent(('/a', '/c'), 4000)]


@pytest.mark.parametrize('numbers', [(0, 1), (65535, 300)])
def test_any_channel_numbers_and_names_without_slash_will_do(tmp_path, numbers):
    path = write(tmp_path / 'x.mcap', indexed(
        schema(65535), channel(numbers[0], 'a', 65535), channel(numbers[1], '/b', 65535),
        *ten(numbers)), indexed(*ten(numbers, 2000)))
    assert recovered(path) == as_sent() + as_sent(begin=2000)


def test_one_name_with_and_without_slash_and_of_two_types_becomes_two_topics(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(
        schema(1), schema(2, 'b/msg/B', b'int32 x\n'), channel(1, 'a', 1), channel(2, '/a', 2),
        *ten()))
    assert recovered(path) == as_sent(('/a', '/a_b'))
    assert 'x.mcap: /a is also b/msg/B: kept as /a_b' in recover(path, tmp_path / 'again').notes


def test_two_schemas_of_one_name_stay_two(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(
        schema(1), schema(2, text=b'string data # of 2024\n'), channel(1, '/a', 1),
        channel(2, '/b', 2), *ten()))
    assert recovered(path) == as_sent()
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        found = [r for r in StreamReader(file).records if isinstance(r, Schema)]
    assert {s.id: s.data for s in found} == {1: b'string data\n',
                                             2: b'string data # of 2024\n'}


def test_definitions_are_repeated_where_the_source_has_them_once(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten(begin=0)),
                 *(indexed(*ten(begin=100 * i)) for i in range(1, 100)))
    assert recovered(path) == [m for i in range(100) for m in as_sent(begin=100 * i)]
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        holds = [any(isinstance(r, Channel) for r in breakup_chunk(c)) for c in StreamReader(
            file, emit_chunks=True).records if isinstance(c, Chunk)]
    assert len(holds) == 100 and [i for i, each in enumerate(holds) if each] == [0, 32, 64, 96]


@pytest.mark.parametrize('split', [{'split_bytes': 10_000}, {'split_duration_s': 30.0}])
def test_the_new_bag_is_split_as_the_settings_say(write_bag, tmp_path, split):
    path = write_bag(chunk_bytes=5_000)
    before = sent(path)
    recover(path, tmp_path / 'new', BagSettings(**split))
    assert_exact(tmp_path / 'new')
    assert sent(tmp_path / 'new') == before
    files = sorted((tmp_path / 'new').glob('*.mcap'))
    assert len(files) > 3
    for each in files[:-1]:
        if 'split_bytes' in split:
            assert 10_000 <= each.stat().st_size < 22_000
        else:
            alone = BagReader(each)
            assert 30.0 <= (alone.end_ns - alone.start_ns) / 1e9 < 32.0


def test_recovering_what_was_recovered_changes_no_message_and_no_chunk(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    cut(message_file(path), message_file(path).stat().st_size * 2 // 3)
    recover(path, tmp_path / 'one')
    recover(tmp_path / 'one', tmp_path / 'two')
    one, two = ((tmp_path / n / f'{n}_0.mcap') for n in ('one', 'two'))
    assert sent(tmp_path / 'one') == sent(tmp_path / 'two')
    assert [(e - s, n) for s, e, n in chunk_places(one)] == [
        (e - s, n) for s, e, n in chunk_places(two)]


@pytest.mark.parametrize('left', [0.5, 0.99])
@pytest.mark.parametrize('compression', ['none', 'zstd'])
def test_a_file_that_changes_while_it_is_read_is_one_clear_error(write_bag, tmp_path, left,
                                                                 compression):
    path = write_bag(compression='none', chunk_bytes=100_000)
    size = message_file(path).stat().st_size

    def shorten(done: str) -> None:
        if 'copied' in done:
            cut(message_file(path), int(left * size))
    with pytest.raises(BagError, match='trial_0.mcap: has changed while it was read'):
        recover(path, tmp_path / 'new', BagSettings(compression=compression), shorten)
    assert [place.name for place in tmp_path.iterdir()] == [path.name]


def without_chunk(path: Path, number: int) -> int:
    """Take a chunk with its indexes out of a file; return how many messages it had."""
    places = chunk_places(path)
    content = path.read_bytes()
    path.write_bytes(content[:places[number][0]] + content[places[number + 1][0]:])
    return places[number][2]


def test_a_chunk_that_is_missing_without_a_trace_is_noted_by_the_summary(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    count = without_chunk(message_file(path), 5)
    total = recover(path, tmp_path / 'new')
    assert total.damaged and (total.messages_lost, total.messages_known) == (count, True)
    assert total.notes == [f'trial_0.mcap: {count} messages are missing, according to its summary']
    assert BagReader(tmp_path / 'new').recovered.startswith(
        f'recovered from a damaged bag: {count} messages')


def statistics_at(content: bytes) -> int:
    return content.index(b'\x0b' + (66).to_bytes(8, 'little'))


def test_statistics_that_contradict_themselves_are_not_believed(write_bag, tmp_path):
    path = write_bag()
    at = statistics_at(message_file(path).read_bytes())
    spoil(message_file(path), at + 9 + 6, b'\x40')
    total = recover(path, tmp_path / 'new')
    assert (total.messages, total.messages_lost, total.bytes_lost) == (3000, 0, 75)
    assert total.damaged and not total.messages_known


@pytest.mark.parametrize('first', [True, False])
def test_each_of_two_files_in_a_row_has_its_own_summary(write_bag, tmp_path, first):
    path = write_bag(chunk_bytes=20_000)
    whole = message_file(path).read_bytes()
    count = without_chunk(message_file(path), 5)
    torn = message_file(path).read_bytes()
    (tmp_path / 'x.mcap').write_bytes(torn + whole if first else whole + torn)
    total = recover(tmp_path / 'x.mcap', tmp_path / 'new')
    assert (total.messages, total.messages_lost) == (6000 - count, count)


@pytest.mark.parametrize('indexes', [True, False])
def test_a_chunk_that_is_there_twice_does_not_hide_that_another_is_missing(write_bag, tmp_path,
                                                                           indexes):
    path = write_bag(chunk_bytes=20_000)
    rows = chunk_places(message_file(path))
    (start, end, _), (behind, _, _), *_ = rows[5:]
    content = message_file(path).read_bytes()
    spoiled = bytes([content[start + 200] ^ 1])
    message_file(path).write_bytes(
        content[:start + 200] + spoiled + content[start + 201:behind if indexes else end]
        + content[behind:rows[7][0]] + content[behind:])
    total = recover(path, tmp_path / 'new')
    assert total.damaged and not total.messages_known


def test_message_indexes_without_their_chunk_tell_that_it_is_missing(tmp_path):
    behind = b''.join(message_index(*row) for row in entries_of(b''.join(ten())).items())
    note = record(Metadata(name='note', metadata={}))
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), note, behind,
                 indexed(*ten(begin=2000)))
    assert recovered(path) == as_sent() + as_sent(begin=2000)
    total = recover(path, tmp_path / 'again')
    assert (total.messages_lost, total.chunks_lost) == (10, 1)


@pytest.mark.parametrize('again', [False, True])
def test_what_was_lost_is_not_forgotten_when_a_bag_is_recovered_again(write_bag, tmp_path, again):
    path = write_bag(chunk_bytes=20_000)
    spoil(message_file(path), chunk_places(message_file(path))[5][0] + 200)
    first = recover(path, tmp_path / 'one')
    more = without_chunk(message_file(tmp_path / 'one'), 7) if again else 0
    lost = first.messages_lost + more
    assert recover(tmp_path / 'one', tmp_path / 'two').messages_lost == more
    reader = BagReader(tmp_path / 'two')
    assert reader.recovered == (f'recovered from a damaged bag: {lost} messages and '
                                f'{first.bytes_lost} bytes were lost')
    assert reader.metadata()['recovery']['note.1'] == first.notes[0]


def test_a_recovery_that_does_not_come_to_its_end_leaves_nothing_in_the_way(write_bag, tmp_path):
    path = write_bag(chunk_bytes=2_000)

    def interrupt(done: str) -> None:
        if 'copied' in done and float(done.split('%')[0]) > 50:
            raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        recover(path, tmp_path / 'new', progress=interrupt)
    assert [place.name for place in tmp_path.iterdir()] == [path.name]
    recover(path, tmp_path / 'new')
    assert sent(tmp_path / 'new') == sent(path)


def test_a_bag_without_messages_is_recovered_for_what_else_is_in_it(tmp_path):
    path = write(tmp_path / 'x.mcap', record(Metadata(name='note.1', metadata={'text': 'port'})))
    assert recovered(path) == []
    assert BagReader(path.with_suffix('.new')).metadata()['note.1'] == {'text': 'port'}


@pytest.mark.slow
@pytest.mark.parametrize('bit', range(8))
@pytest.mark.parametrize('compression', ['', 'zstd'])
def test_a_chunk_whose_opcode_is_wrong_is_known_by_its_checksum(tmp_path, bit, compression):
    for place in range(3):
        pieces = [indexed(*TWO, *ten(begin=1000 * i), compression=compression)
                  for i in range(1, 4)]
        right = pieces[place]
        pieces[place] = bytes([6 ^ 1 << bit]) + right[1:]
        path = write(tmp_path / f'{place}.mcap', *pieces)
        assert recovered(path) == [m for i in range(1, 4) for m in as_sent(begin=1000 * i)]
        assert right in file_of(path)


def test_a_torn_chunk_does_not_swallow_those_behind_it(tmp_path):
    """It claims to reach past the end of the file; reading it ends at the next."""
    long = indexed(*(message(1, 2000 + i, text('x' * 200)) for i in range(60)), compression='')
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), long[:5000],
                 indexed(*ten(begin=5000), compression=''))
    found = recovered(path)
    assert found[:10] == as_sent() and found[-10:] == as_sent(begin=5000)
    assert found[10:-10] == [Sent('/a', 2000 + i, 2000 + i, 0, text('x' * 200))
                             for i in range(20)]
    total = recover(path, tmp_path / 'again')
    assert total.notes[0].endswith(': a chunk ends early') and 0 < total.bytes_lost < 250


@pytest.mark.parametrize('times', [(2**63 + 2000, 2090), (2**64 - 1, 0)])
def test_a_chunk_is_kept_whatever_times_its_head_has(tmp_path, times):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()),
                 indexed(*ten(begin=2000), times=times), indexed(*ten(begin=3000)))
    assert recovered(path) == [m for i in range(1, 4) for m in as_sent(begin=1000 * i)]


@pytest.mark.parametrize('last', [True, False])
def test_one_message_between_chunks_is_kept(tmp_path, last):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), message(1, 1500, text('alone')),
                 b'' if last else indexed(*ten(begin=2000)))
    assert recovered(path) == [*as_sent(), Sent('/a', 1500, 1500, 0, text('alone')),
                               *([] if last else as_sent(begin=2000))]


def attached(data: bytes) -> bytes:
    return record(Attachment(create_time=5, log_time=6, name='cal.mcap', media_type='',
                             data=data))


@pytest.mark.parametrize('last', [True, False])
def test_messages_of_a_damaged_file_that_is_attached_are_not_of_the_bag(tmp_path, last):
    inner = write(tmp_path / 'y.mcap', indexed(schema(1), channel(1, '/c'), *ten((1,))))
    piece = attached(inner.read_bytes() + bytes(100))
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), piece[:-40] + b'\1' + piece[-39:],
                 b'' if last else indexed(*ten(begin=2000)))
    assert recovered(path) == as_sent() + ([] if last else as_sent(begin=2000))


@pytest.mark.parametrize('short', range(1, 12))
def test_an_attachment_that_lost_bytes_does_not_swallow_the_chunk_behind_it(tmp_path, short):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), attached(bytes(20))[:-short],
                 indexed(*ten(begin=2000)), indexed(*ten(begin=3000)))
    assert recovered(path) == [m for i in range(1, 4) for m in as_sent(begin=1000 * i)]


def test_a_checksum_of_the_data_alone_is_right_for_an_attachment(tmp_path):
    piece = attached(b'start,stop\n')
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()),
                 piece[:-4] + zlib.crc32(b'start,stop\n').to_bytes(4, 'little'))
    assert recovered(path) == as_sent()
    found, = BagReader(path.with_suffix('.new')).attachments()
    assert (found.data, found.log_time_ns) == (b'start,stop\n', 6)


def test_an_attachment_keeps_both_of_its_times(tmp_path):
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), attached(b'start,stop\n'))
    assert recovered(path) == as_sent()
    assert attached(b'start,stop\n') in file_of(path)
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        found, = make_reader(file, validate_crcs=True).iter_attachments()
    assert (found.create_time, found.log_time) == (5, 6)


def test_a_chunk_of_a_large_message_takes_little_more_memory_than_the_message(tmp_path):
    size = 2**25
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), chunk(
        message(1, 2000, bytes(size)), crc=0))
    tracemalloc.start()
    try:
        assert recover(path, tmp_path / 'new').messages == 11
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak < 1.5 * size


def test_a_thousand_topics_take_no_longer_than_their_messages(tmp_path, monkeypatch):
    """metadata.yaml is written when the bag begins and ends, not for each of them."""
    written = []
    describe = BagWriter._description
    monkeypatch.setattr(BagWriter, '_description', lambda bag: written.append(1) or describe(bag))
    numbers = range(1, 1001)
    path = write(tmp_path / 'x.mcap', indexed(
        schema(1), *(channel(n, f'/topic_{n}') for n in numbers),
        *(message(n, n, text('x')) for n in numbers)))
    assert recover(path, tmp_path / 'new').messages == 1000
    assert len(written) <= 3


def test_a_message_index_that_is_taken_for_a_chunk_is_no_loss_by_the_summary(write_bag, tmp_path):
    path = write_bag(chunk_bytes=20_000)
    _, end, _ = chunk_places(message_file(path))[5]
    spoil(message_file(path), end, b'\x06')
    total = recover(path, tmp_path / 'new')
    assert (total.messages, total.messages_lost, total.damaged) == (3000, 0, True)


@pytest.mark.parametrize('command', [recover, lambda source, target: BagReader(source)])
def test_a_loop_of_links_is_one_clear_error(tmp_path, command):
    (tmp_path / 'a').symlink_to(tmp_path / 'b')
    (tmp_path / 'b').symlink_to(tmp_path / 'a')
    with pytest.raises(OSError, match='symbolic links'):
        command(tmp_path / 'a', tmp_path / 'new')


@pytest.mark.parametrize('size', [500, 16_000])
def test_recovery_of_channels_that_are_defined_again_and_again_is_linear(tmp_path, size):
    """In small chunks, and in one; eight times the records take about eight times the time."""
    def seconds(count: int) -> float:
        records = [schema(1) + channel(1, f'/t{n % 50}') + message(1, 10**18 + n, b'\0\1\0\0')
                   + channel(2, '/a') + message(2, 10**18 + n, b'\0\1\0\0')
                   for n in range(count)]
        path = write(tmp_path / 'x.mcap', *(chunk(*records[at:at + size])
                                            for at in range(0, count, size)))
        began_s = time.process_time()
        assert recover(path, tmp_path / f'new_{count}').messages == count
        return time.process_time() - began_s
    seconds(500)
    assert seconds(16_000) < 25.0 * seconds(2_000)


@pytest.mark.parametrize('compression', ['', 'lz4', 'zstd'])
def test_what_nothing_proves_is_kept_only_if_asked_for_and_marked(tmp_path, compression):
    """The first chunk has a wrong checksum and, after half of its messages, a wrong log time."""
    rows = [message(1, n, text('x')) for n in range(1000, 1010)]
    rows[5] = message(1, 5, text('x'))
    path = write(tmp_path / 'x.mcap', indexed(
        *TWO, *rows, crc=7, times=(1000, 1009), compression=compression), indexed(*TWO, *ten()))
    assert recover(path, tmp_path / 'plain').messages == 10
    assert 'messages_unproven' not in BagReader(tmp_path / 'plain').metadata()['recovery']
    total = recover(path, tmp_path / 'new', unproven=True)
    assert (total.messages, total.messages_unproven, total.chunks_lost) == (15, 5, 1)
    assert 'kept without proof' in total.notes[0]
    assert_exact(tmp_path / 'new')
    reader = BagReader(tmp_path / 'new')
    assert reader.metadata()['recovery']['messages_unproven'] == '5'
    assert '5 messages are in it though their checksum is wrong' in reader.recovered
    recover(tmp_path / 'new', tmp_path / 'again')
    assert BagReader(tmp_path / 'again').recovered == reader.recovered


def test_a_sound_bag_is_recovered_alike_with_and_without_proof(write_bag, tmp_path):
    path = write_bag()
    assert recover(path, tmp_path / 'a') == recover(path, tmp_path / 'b', unproven=True)


def test_a_name_of_an_attachment_that_is_no_utf8_does_not_end_a_recovery(tmp_path):
    spoiled = bytearray(attached(b'start,stop\n').replace(b'cal.mcap', b'\xffal.mcap'))
    spoiled[-4:] = zlib.crc32(spoiled[9:-4]).to_bytes(4, 'little')
    path = write(tmp_path / 'x.mcap', indexed(*TWO, *ten()), bytes(spoiled))
    assert recovered(path) == as_sent()
    with open(next(path.with_suffix('.new').glob('*.mcap')), 'rb') as file:
        kept, = make_reader(file, validate_crcs=True).iter_attachments()
    assert (kept.name, kept.data) == ('\ufffdal.mcap', b'start,stop\n')


def test_a_link_that_leads_nowhere_in_a_bag_is_named(write_bag, tmp_path, capsys):
    path = write_bag()
    (path / 'trial_7.mcap').symlink_to(path / 'trial_7.mcap')
    (path / 'trial_8.mcap').symlink_to(tmp_path / 'gone')
    missing = 'trial_7.mcap is missing; trial_8.mcap is missing'
    reader = BagReader(path)
    assert reader.incomplete == missing and len(list(reader.messages())) == 3000
    assert recover(path, tmp_path / 'new').messages == 3000
    assert main(['info', str(path)]) == 0
    assert missing in capsys.readouterr().out
