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

"""Bags whose chunks are out of order give their readings in order, each once."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

from mcap.writer import CompressionType, Writer
import numpy as np
import pytest

from heading_intercompare.bags.mcap.mcap_file import Part
from heading_intercompare.bags.parallel import reading_order
from heading_intercompare.bags.parallel.reading_order import cut_pieces, is_in_order
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.schemas import shipped_schema

TOPICS = ('/ts/heading', '/rs/heading')
COUNT = 2000
STAMPS = 10**18 + np.arange(COUNT) * 10**8


def write(path: Path, order: Sequence[int], log_ns: np.ndarray = STAMPS,
          chunk_bytes: int = 20_000, topics: Sequence[str] = TOPICS) -> Path:
    """Write readings of both topics in an order, which may differ from that of their stamps."""
    rows = encode_imu(Headings.of(STAMPS, np.arange(COUNT) % 360.0), 'gyro')
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=chunk_bytes, compression=CompressionType.ZSTD)
        writer.start('ros2')
        schema = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        channels = [writer.register_channel(topic, 'cdr', schema) for topic in topics]
        for at in order:
            for channel in channels:
                log = int(log_ns[at])
                writer.add_message(channel, log, rows[at].tobytes(), log, int(at))
        writer.finish()
    return path


def stamps(path: Path) -> list[list[int]]:
    """Return the stamps of both topics as they are read."""
    chunks = list(BagReader(path).headings(dict.fromkeys(TOPICS, 'enu')))
    return [Headings.concatenate([chunk[topic] for chunk in chunks]).stamp_ns.tolist()
            for topic in TOPICS]


NUMBERS = np.arange(COUNT)
HALVES = np.r_[NUMBERS[COUNT // 2:], NUMBERS[:COUNT // 2]]
EVEN_ODD = np.r_[NUMBERS[::2], NUMBERS[1::2]]
BACKWARDS = NUMBERS.reshape(20, -1)[::-1].ravel()


@pytest.mark.parametrize('chunk_bytes', [20_000, 10**9])
@pytest.mark.parametrize('order', [NUMBERS, HALVES, EVEN_ODD, BACKWARDS])
def test_readings_come_in_order_however_their_chunks_lie(tmp_path, order, chunk_bytes):
    path = write(tmp_path / 'x.mcap', order, chunk_bytes=chunk_bytes)
    assert stamps(path) == [STAMPS.tolist()] * 2


@pytest.mark.parametrize('order', [HALVES, EVEN_ODD])
def test_an_order_other_than_that_of_the_file_is_said(tmp_path, order):
    reader = BagReader(write(tmp_path / 'x.mcap', order))
    list(reader.headings(dict.fromkeys(TOPICS, 'enu')))
    assert ['not in the order of time' in text for text in reader.oddities] == [True]
    sound = BagReader(write(tmp_path / 'y.mcap', NUMBERS))
    list(sound.headings(dict.fromkeys(TOPICS, 'enu')))
    assert sound.oddities == []


def test_files_whose_names_are_not_in_the_order_of_time_are_read_in_order(tmp_path):
    (tmp_path / 'bag').mkdir()
    write(tmp_path / 'bag' / 'b_0.mcap', NUMBERS[1200:])
    write(tmp_path / 'bag' / 'b_1.mcap', NUMBERS[:700])
    write(tmp_path / 'bag' / 'b_2.mcap', NUMBERS[700:1200])
    assert stamps(tmp_path / 'bag') == [STAMPS.tolist()] * 2


def test_a_clock_of_the_recorder_that_went_back_disorders_nothing(tmp_path):
    log = STAMPS - np.where(NUMBERS >= COUNT // 2, 70 * 10**9, 0)
    assert stamps(write(tmp_path / 'x.mcap', NUMBERS, log)) == [STAMPS.tolist()] * 2
    assert stamps(write(tmp_path / 'y.mcap', NUMBERS, log, 10**9)) == [STAMPS.tolist()] * 2


def test_the_order_is_that_of_the_log_times_where_a_sensor_was_set_back(tmp_path):
    """Its stamps do not rise in any order; those of the log times tell when it was set back."""
    rows = STAMPS.copy()
    log = STAMPS + 5
    path = write(tmp_path / 'x.mcap', HALVES, log)
    assert stamps(path) == [rows.tolist()] * 2


def test_messages_are_merged_in_the_same_order_if_asked(tmp_path):
    reader = BagReader(write(tmp_path / 'x.mcap', EVEN_ODD))
    files = [message.log_time_ns for message in reader.messages(TOPICS[:1])]
    assert files == STAMPS[EVEN_ODD].tolist()
    merged = [message.log_time_ns for message in reader.messages(TOPICS[:1], in_order=True)]
    assert merged == STAMPS.tolist()
    part = list(reader.messages(TOPICS, int(STAMPS[500]), int(STAMPS[510]), in_order=True))
    assert [message.log_time_ns for message in part] == np.repeat(STAMPS[500:510], 2).tolist()


def test_the_readings_that_wait_are_bounded(tmp_path, monkeypatch):
    """Then some come late, but none is lost."""
    monkeypatch.setattr(reading_order, '_MOST_WAITING', 100)
    path = write(tmp_path / 'x.mcap', EVEN_ODD)
    reader = BagReader(path)
    sizes = [max(map(len, chunk.values())) for chunk in
             reader.headings(dict.fromkeys(TOPICS, 'enu'))]
    assert sum(sizes) == COUNT and sorted(stamps(path)[0]) == STAMPS.tolist()
    merged = [message.log_time_ns for message in reader.messages(TOPICS[:1], in_order=True)]
    assert sorted(merged) == STAMPS.tolist()


def test_topics_one_after_the_other_are_in_order(tmp_path):
    """Each topic counts on its own, if the index says which chunk holds which."""
    path = tmp_path / 'x.mcap'
    rows = encode_imu(Headings.of(STAMPS, np.zeros(COUNT)), 'gyro')
    with open(path, 'wb') as file:
        writer = Writer(file, chunk_size=20_000)
        writer.start('ros2')
        schema = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        for topic in TOPICS:
            channel = writer.register_channel(topic, 'cdr', schema)
            for log, row in zip(STAMPS.tolist(), rows):
                writer.add_message(channel, log, row.tobytes(), log)
            # Ends the chunk, so that none has both topics.
            writer._Writer__finalize_chunk()
        writer.finish()
    assert is_in_order([Part(path)], TOPICS)
    assert stamps(path) == [STAMPS.tolist()] * 2


def test_pieces_cover_the_files_and_their_first_times_do_not_go_back_within(tmp_path):
    parts = [Part(write(tmp_path / f'{n}.mcap', order))
             for n, order in enumerate((HALVES, NUMBERS))]
    pieces = cut_pieces(parts)
    assert [piece.number for piece in pieces] == [0, 0, 1]
    for number, part in enumerate(parts):
        mine = [piece.stretch for piece in pieces if piece.number == number]
        assert mine[0].begin == part.stretches()[0].begin and mine[-1].end == part.end
        assert [one.end for one in mine[:-1]] == [one.begin for one in mine[1:]]
    assert [piece.first_ns for piece in pieces] == [STAMPS[COUNT // 2], STAMPS[0], STAMPS[0]]
