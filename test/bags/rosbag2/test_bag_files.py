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

"""Which files belong to a bag: those that its metadata.yaml lists."""

from __future__ import annotations

from pathlib import Path
import shutil

import pytest

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_files import find_files
from heading_intercompare.bags.rosbag2.bag_reader import BagReader


def names(folder: Path) -> list[str]:
    return [each.name for each in find_files(folder).paths]


@pytest.fixture
def bag(write_bag) -> Path:
    return write_bag()


def test_of_many_missing_files_a_few_are_named(bag):
    place = bag / 'metadata.yaml'
    listed = ''.join(f'    - gone_{n}\n' for n in range(20_000))
    place.write_text(place.read_text().replace('  relative_file_paths:\n',
                                               f'  relative_file_paths:\n{listed}'))
    said = BagReader(bag).incomplete
    assert 'gone_4 is missing' in said and said.endswith('19995 more files are missing')
    assert len(said) < 200 and len(check_bag(bag).faults) == 6


@pytest.mark.parametrize('copy', ['trial_0 (copy).mcap', 'a.mcap', 'trial_0_copy_1.mcap',
                                  'trial_00 2.mcap'])
def test_a_copy_in_the_folder_doubles_nothing_and_is_named(bag, tmp_path, copy):
    whole = len(list(BagReader(bag).messages()))
    shutil.copy(bag / 'trial_0.mcap', bag / copy)
    reader = BagReader(bag)
    assert len(list(reader.messages())) == whole
    assert reader.oddities == [f'left out, because metadata.yaml does not list it: {copy}']
    assert check_bag(bag).files == 1
    total = recover(bag, tmp_path / 'new')
    assert total.messages == whole and total.files == 1
    assert any(copy in note for note in total.notes)


def test_a_file_that_goes_on_with_the_numbers_is_read(bag):
    """A recorder that was killed had no time to list it."""
    shutil.copy(bag / 'trial_0.mcap', bag / 'trial_1.mcap')
    assert names(bag) == ['trial_0.mcap', 'trial_1.mcap']
    assert find_files(bag).unlisted == []


def test_all_files_are_read_if_none_is_listed_or_none_of_the_listed_is_there(bag):
    (bag / 'trial_0.mcap').rename(bag / 'other.mcap')
    shutil.copy(bag / 'other.mcap', bag / 'another.mcap')
    assert names(bag) == ['another.mcap', 'other.mcap']
    assert find_files(bag).absent == ['trial_0.mcap']
    (bag / 'metadata.yaml').unlink()
    assert names(bag) == ['another.mcap', 'other.mcap'] and find_files(bag).absent == []


def test_many_strange_files_are_counted_not_listed(bag):
    for number in range(8):
        (bag / f'strange {number}.mcap').touch()
    assert find_files(bag).oddities[0].endswith('strange 4.mcap and 3 more')
