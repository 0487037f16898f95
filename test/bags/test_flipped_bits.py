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

"""Single bits flipped in the fields of each kind of record: an error of ours, or the data."""

from __future__ import annotations

from contextlib import nullcontext, suppress
from functools import lru_cache
from pathlib import Path
import shutil
import struct
import tempfile
from typing import Iterator
import zlib

from bags.mcap_bytes import channel, HEADER, indexed, MAGIC, message, schema, write
from command_line import NORMS, refusal
from mcap.opcode import Opcode
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap import chunks
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.paced_replay import Replay
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.cli import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.schemas import shipped_schema

TOPICS = ('/ts/heading', '/rs/heading')
STAMPS = 10**18 + np.arange(3) * 10**8

#: Bytes of a record, with its opcode and length, that are no text and no payload.
FIELDS = {
    Opcode.HEADER: 13, Opcode.FOOTER: 29, Opcode.SCHEMA: 15, Opcode.CHANNEL: 17,
    Opcode.MESSAGE: 31, Opcode.CHUNK: 49, Opcode.MESSAGE_INDEX: 31, Opcode.CHUNK_INDEX: 93,
    Opcode.ATTACHMENT: 29, Opcode.ATTACHMENT_INDEX: 53, Opcode.STATISTICS: 65,
    Opcode.METADATA: 13, Opcode.METADATA_INDEX: 29, Opcode.SUMMARY_OFFSET: 26,
    Opcode.DATA_END: 13}


def walk(data: bytes, at: int, end: int) -> Iterator[tuple[int, int, int]]:
    """Yield opcode, first byte and end of each whole record, and of those in chunks."""
    while at + 9 <= end:
        opcode, length = struct.unpack_from('<BQ', data, at)
        behind = at + 9 + length
        if behind > end:
            return
        yield opcode, at, behind
        if opcode == Opcode.CHUNK and length > 40:
            yield from walk(data, at + 49, behind)
        at = behind


@lru_cache(maxsize=None)
def original() -> bytes:
    """Return a file with each kind of record, uncompressed."""
    with tempfile.TemporaryDirectory() as folder:
        with BagWriter(Path(folder, 'x'), BagSettings(compression='none')) as bag:
            bag.metadata('heading_intercompare', {'version': '1'})
            for topic in TOPICS:
                bag.add_topic(topic, IMU)
            rows = encode_imu(Headings.of(STAMPS, np.arange(3.0)), 'gyro')
            for row, stamp_ns in zip(rows, STAMPS.tolist()):
                for topic in TOPICS:
                    bag.write(topic, row.tobytes(), stamp_ns)
            bag.attachment('runs.csv', 'text/csv', b'start,stop\n')
        return Path(folder, 'x', 'x_0.mcap').read_bytes()


def mend(data: bytearray) -> bytes:
    """Return a file with its checksums computed again, as far as its records can be walked."""
    for opcode, at, end in walk(data, len(MAGIC), len(data) - len(MAGIC)):
        if opcode == Opcode.CHUNK and end - at > 49:
            struct.pack_into('<I', data, at + 33, zlib.crc32(data[at + 49:end]))
        elif opcode == Opcode.ATTACHMENT:
            struct.pack_into('<I', data, end - 4, zlib.crc32(data[at + 9:end - 4]))
        elif opcode == Opcode.FOOTER:
            start, = struct.unpack_from('<Q', data, at + 9)
            struct.pack_into('<I', data, end - 4, zlib.crc32(data[start:end - 4]))
    return bytes(data)


def read(path: Path) -> None:
    """Read, replay and check a bag; raise anything but the errors of this package."""
    with suppress(BagError, SettingsError):
        reader = BagReader(path)
        for topic in reader.topics:
            with suppress(BagError):
                list(reader.payloads(topic))
        with suppress(BagError):
            reader.attachments()
        list(reader.headings(dict.fromkeys(TOPICS, 'enu')))
        replay = Replay(reader, TOPICS, rate=0.0)
        while replay.take() is not None:
            pass
    check_bag(path)


def try_recovery(path: Path) -> None:
    """Recover a bag; raise anything but the errors of this package."""
    with suppress(BagError):
        recover(path, path.parent / 'recovered')
    shutil.rmtree(path.parent / 'recovered', ignore_errors=True)


def without_end() -> bytes:
    """Return the file as a recorder leaves it that was killed."""
    data = original()
    return data[:next(at for opcode, at, _ in walk_all(data) if opcode == Opcode.DATA_END)]


def without_chunks() -> bytes:
    """Return the same with its messages outside chunks."""
    data = without_end()
    return MAGIC + b''.join(data[at:end] for opcode, at, end in walk_all(data)
                            if opcode not in (Opcode.CHUNK, Opcode.MESSAGE_INDEX))


def walk_all(data: bytes) -> Iterator[tuple[int, int, int]]:
    return walk(data, len(MAGIC), len(data))


FORMS = {'closed': original, 'without end': without_end, 'without chunks': without_chunks}


def test_each_kind_of_record_is_in_the_file():
    assert {opcode for opcode, _, _ in walk_all(original())} >= {*FIELDS}


@pytest.mark.slow
@pytest.mark.parametrize(('form', 'opcode'), [
    *(('closed', opcode) for opcode in FIELDS), ('without end', Opcode.CHUNK),
    ('without end', Opcode.MESSAGE), ('without end', Opcode.MESSAGE_INDEX),
    ('without chunks', Opcode.MESSAGE)])
def test_no_bit_of_a_field_ends_in_a_traceback(form, opcode, tmp_path):
    """Each bit of the first and the last record of a kind, with checksums wrong and right."""
    data, path = FORMS[form](), tmp_path / 'flipped.mcap'
    places = [(at, end) for kind, at, end in walk_all(data) if kind == opcode]
    assert places
    for at, end in {*places[:1], *places[-1:]}:
        for bit in range(8 * at, 8 * min(at + FIELDS[opcode], end)):
            flipped = bytearray(data)
            flipped[bit // 8] ^= 1 << bit % 8
            for content in {bytes(flipped), mend(flipped)}:
                path.write_bytes(content)
                read(path)
                if bit % 8 == 7:
                    try_recovery(path)


IMPOSSIBLE_NS = (1 << 63, 1 << 63 | int(STAMPS[1]), 2**64 - 1)


def definitions() -> bytes:
    return (schema(1, IMU, shipped_schema(IMU).text.encode())
            + b''.join(channel(n, topic) for n, topic in enumerate(TOPICS)))


def messages_at(log_ns: int, publish_ns: int | None = None) -> list[bytes]:
    """Return messages of both sensors, the second of TS at a log time."""
    rows = encode_imu(Headings.of(STAMPS, np.arange(3.0)), 'gyro')
    return [message(number, log_ns if (number, at) == (0, 1) else stamp_ns, rows[at].tobytes(),
                    publish_ns)
            for at, stamp_ns in enumerate(STAMPS.tolist()) for number in range(2)]


CLOSED = b'\x0f' + struct.pack('<QI', 4, 0) + b'\x02' + struct.pack('<QQQI', 20, 0, 0, 0) + MAGIC


@pytest.mark.parametrize('log_ns', IMPOSSIBLE_NS)
@pytest.mark.parametrize('ending', [b'', CLOSED], ids=['never closed', 'closed'])
def test_analysis_names_an_impossible_log_time_and_its_chunk(ending, log_ns, tmp_path, capsys):
    """One bit in a message of a bag without an index."""
    head = definitions() + indexed(*messages_at(int(STAMPS[1])))
    path = write(tmp_path / 'x.mcap', head, indexed(*messages_at(log_ns)), ending)
    place = len(MAGIC) + len(HEADER) + len(head)
    with pytest.raises(BagError) if ending else nullcontext() as raised:
        reader = BagReader(path)
    problem = str(raised.value) if ending else reader.incomplete
    assert 'x.mcap' in problem and f'at byte {place}' in problem
    assert 'a message that `recover` leaves out has an impossible log time' in problem
    assert any('has an impossible log time' in fault for fault in check_bag(path).faults)
    if ending:
        line = refusal(capsys, 'analyze', path, *NORMS)
        assert 'has an impossible log time' in line and f'at byte {place}' in line
        assert recover(path, tmp_path / 'recovered').messages_lost == 1


@pytest.mark.parametrize('log_ns', IMPOSSIBLE_NS)
def test_messages_outside_chunks_are_read_up_to_an_impossible_log_time(log_ns, tmp_path):
    """The message itself is named: three of six messages come before it."""
    rows = messages_at(log_ns)
    path = write(tmp_path / 'x.mcap', definitions(), *rows)
    reader = BagReader(path)
    assert [sent.log_time_ns for sent in reader.messages()] == STAMPS[[0, 0]].tolist()
    assert f'at byte {path.stat().st_size - sum(map(len, rows[2:]))} of' in reader.incomplete


@pytest.mark.parametrize('log_ns', IMPOSSIBLE_NS)
def test_index_with_possible_times_hides_no_impossible_one(log_ns, tmp_path):
    """The heads and the index of the file say what the message should have said."""
    data = bytearray(original())
    at = [at for opcode, at, _ in walk_all(data) if opcode == Opcode.MESSAGE][2]
    struct.pack_into('<Q', data, at + 15, log_ns)
    path = tmp_path / 'x.mcap'
    path.write_bytes(mend(data))
    chunk_at = next(at for opcode, at, _ in walk_all(data) if opcode == Opcode.CHUNK)
    reader = BagReader(path)
    for use in (lambda: list(reader.headings(dict.fromkeys(TOPICS, 'enu'))),
                lambda: list(reader.payloads(TOPICS[0])),
                lambda: Replay(reader, TOPICS, rate=0.0)):
        with pytest.raises(BagError, match=f'impossible log time .at byte {chunk_at}.'):
            use()


def test_one_impossible_log_time_in_a_large_chunk_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(chunks, 'LARGE_BYTES', 100)
    path = write(tmp_path / 'x.mcap', definitions(), indexed(*messages_at(1 << 63)), CLOSED)
    with pytest.raises(BagError, match='impossible log time'):
        BagReader(path)


@pytest.mark.parametrize('publish_ns', [*IMPOSSIBLE_NS, 2**63 - 1])
def test_publish_times_and_last_log_time_change_no_heading(publish_ns, tmp_path):
    """The latest possible log time is in 2262; a publish time is no time of a heading."""
    path = write(tmp_path / 'x.mcap', definitions(),
                 indexed(*messages_at(2**63 - 1, publish_ns)), CLOSED)
    reader = BagReader(path)
    headings = [chunk['/ts/heading'] for chunk in reader.headings({'/ts/heading': 'enu'})]
    assert reader.end_ns == 2**63 - 1
    assert np.sort(np.concatenate([h.stamp_ns for h in headings])).tolist() == STAMPS.tolist()


@pytest.mark.parametrize('field', [35, 43], ids=['first', 'last'])
def test_impossible_time_in_statistics_is_not_believed(field, tmp_path, capsys):
    """The messages say when the bag begins and ends."""
    data = bytearray(original())
    at = next(at for opcode, at, _ in walk_all(data) if opcode == Opcode.STATISTICS)
    data[at + field + 7] |= 128
    path = tmp_path / 'x.mcap'
    path.write_bytes(mend(data))
    reader = BagReader(path)
    assert (reader.start_ns, reader.end_ns) == (STAMPS[0], STAMPS[-1])
    assert main(['info', str(path)]) == 0
    assert 'span: 2001-09-09 01:46:40.000 to 2001-09-09 01:46:40.200' in capsys.readouterr().out


def test_times_of_an_attachment_are_no_reason_to_refuse_it(tmp_path, capsys):
    data = bytearray(original())
    at = next(at for opcode, at, _ in walk_all(data) if opcode == Opcode.ATTACHMENT)
    data[at + 9:at + 25] = b'\xff' * 16
    path = tmp_path / 'x.mcap'
    path.write_bytes(mend(data))
    assert main(['info', str(path)]) == 0
    assert 'runs.csv' in capsys.readouterr().out
