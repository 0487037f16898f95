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

"""What is synced to the disk, and when."""

from __future__ import annotations

import os

import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recording.disk_sync import Syncing
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.replaced_file import replace_file


@pytest.fixture
def synced(monkeypatch):
    """Return a list that fills with the synced files, by inode."""
    found = []
    fsync = os.fsync

    def note(descriptor):
        fsync(descriptor)
        found.append(os.fstat(descriptor).st_ino)
    monkeypatch.setattr(os, 'fsync', note)
    return found


def inode(path) -> int:
    return path.stat().st_ino


@pytest.mark.parametrize('interval_s, count', [(0.0, 8), (1.0, 4), (2.0, 2)])
def test_a_file_is_synced_once_an_interval(tmp_path, synced, interval_s, count):
    syncing = Syncing(interval_s)
    with open(tmp_path / 'file', 'w') as file:
        for half in range(8):
            syncing.begin_if_due(file.fileno(), half / 2)
            # The worker does one task at a time: when this one is done, so is the sync.
            syncing._worker.submit(int).result(10.0)
    syncing.close()
    assert synced == [inode(tmp_path / 'file')] * count


def test_a_file_that_is_replaced_is_on_the_disk_and_so_is_its_name(tmp_path, synced):
    replace_file(tmp_path / 'file', 'text')
    assert (tmp_path / 'file').read_text() == 'text'
    assert synced == [inode(tmp_path / 'file'), inode(tmp_path)]


def test_of_texts_that_wait_only_the_last_is_written(tmp_path, synced):
    syncing = Syncing(1.0)
    for number in range(100):
        syncing.replace(tmp_path / 'file', str(number))
    syncing.close()
    assert (tmp_path / 'file').read_text() == '99' and syncing.problem is None


def test_files_that_are_left_and_closed_are_on_the_disk(tmp_path, synced):
    bag = BagWriter(tmp_path / 'bag', BagSettings())
    synced.clear()
    bag.split()
    bag.close()
    files = [inode(tmp_path / 'bag' / f'bag_{number}.mcap') for number in (0, 1)]
    assert set(files) <= set(synced)
