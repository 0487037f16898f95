# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Damaged bags recovered: what is kept, what is said to be lost, who reads the result."""

from __future__ import annotations

from pathlib import Path
import shutil

from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer
import pytest

from heading_intercompare.bags.bag_yaml import Qos
from heading_intercompare.bags.cdr import encode
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.heading_messages import IMU
from heading_intercompare.bags.reader import BagReader
from heading_intercompare.bags.recovery import recover
from heading_intercompare.bags.salvage import Salvage
from heading_intercompare.bags.writer import BagWriter

STRING = 'std_msgs/msg/String'


def message_file(bag: Path) -> Path:
    return bag / f'{bag.name}_0.mcap'


def chunk_places(path: Path) -> list[tuple[int, int, int]]:
    """Return where each chunk of a whole file starts and ends, and how many messages it has."""
    with open(path, 'rb') as file:
        return [(item.record.start - 9, item.end, len(item.block.start))
                for item in Salvage(file).scan() if item.record.opcode == 6]


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
    with pytest.raises(BagError, match='exists already'):
        recover(path, path)


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
