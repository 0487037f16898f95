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

"""Files that a disk cannot read completely."""

from __future__ import annotations

import errno
import os

from bags.mcap_bytes import assert_exact, sent
import pytest

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.scanner import Salvage
from heading_intercompare.bags.recovery.unreadable_sectors import HOLE_BYTES, open_with_holes


@pytest.fixture
def spoil(monkeypatch):
    """Return a function after which a block of every file cannot be read."""
    readv = os.readv

    def spoiled(block: int) -> None:
        def read(descriptor: int, buffers: list) -> int:
            at = os.lseek(descriptor, 0, os.SEEK_CUR)
            if at < (block + 1) * HOLE_BYTES and block * HOLE_BYTES < at + len(buffers[0]):
                raise OSError(errno.EIO, 'Input/output error')
            return readv(descriptor, buffers)
        monkeypatch.setattr(os, 'readv', read)
    return spoiled


def test_reading_ends_at_a_hole_and_goes_on_behind_it(tmp_path, spoil, rng):
    data = rng.bytes(300_000)
    (tmp_path / 'x').write_bytes(data)
    spoil(10)
    holes = []
    with open_with_holes(tmp_path / 'x', holes) as file:
        assert file.read(200_000) == data[:10 * HOLE_BYTES]
        assert file.read(1) == b''
        file.seek(10 * HOLE_BYTES + 5)
        assert file.read(5) == b''
        file.seek(11 * HOLE_BYTES)
        assert file.read() == data[11 * HOLE_BYTES:]
    assert holes == [10 * HOLE_BYTES]


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['none', 'zstd'])
def test_only_the_chunks_are_lost_that_the_disk_cannot_read(write_bag, tmp_path, spoil,
                                                            compression):
    path = write_bag(chunk_bytes=5_000, compression=compression)
    file = path / 'trial_0.mcap'
    before = sent(path)
    with open(file, 'rb') as stream:
        rows = [(chunk.start, chunk.end, sum(count for _, count in chunk.counts))
                for item in Salvage(stream).scan() if item.run for chunk in item.run.chunks]
    for block in (0, 3, file.stat().st_size // HOLE_BYTES // 2, file.stat().st_size // HOLE_BYTES):
        spoil(block)
        lo, hi = block * HOLE_BYTES, (block + 1) * HOLE_BYTES
        target = tmp_path / str(block)
        total = recover(path, target)
        assert total.damaged and any('disk cannot read' in note for note in total.notes)
        assert_exact(target)
        after = sent(target)
        assert set(after) <= set(before)
        touched = sum(count for start, end, count in rows if start < hi and lo < end)
        assert len(before) - touched <= len(after) == total.messages


def test_a_file_that_cannot_be_read_does_not_stop_the_others(write_bag, tmp_path):
    path = write_bag()
    (path / 'trial_1.mcap').mkdir()
    (path / 'trial_2.mcap').symlink_to('nowhere')
    total = recover(path, tmp_path / 'new')
    assert total.messages == 3000
