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

import os
from pathlib import Path
import shutil

import pytest

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_files import find_files
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main


def names(folder: Path) -> list[str]:
    return [each.name for each in find_files(folder).paths]


def another(bag: Path, name: str) -> None:
    """Write a file of the same size as the first, with other bytes at its beginning."""
    data = bytearray((bag / 'trial_0.mcap').read_bytes())
    place = data.index(b'heading_intercompare', 0, 200)
    data[place:place + 7] = b'another'
    (bag / name).write_bytes(data)


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
    another(bag, 'trial_1.mcap')
    assert names(bag) == ['trial_0.mcap', 'trial_1.mcap']
    assert find_files(bag).unlisted == []


@pytest.mark.parametrize('listed, later, is_read', [
    ('0_trial_2026_03_01-09_00_00.mcap', '1_trial_2026_03_01-10_00_07.mcap', True),
    ('9_trial_2026_03_01-09_00_30.mcap', '10_trial_2026_03_02-00_00_00.mcap', True),
    ('0_trial_2026_03_01-09_00_00.mcap', '1_other_2026_03_01-10_00_07.mcap', False),
    ('0_trial_2026_03_01-09_00_00.mcap', '0_trial_2026_03_01-09_00_00 (copy).mcap', False),
    ('0_trial_2026_03_01-09_00_00.mcap', 'trial_1.mcap', False)])
def test_a_file_that_goes_on_has_the_next_number_and_a_later_time(bag, listed, later, is_read):
    """Since rosbag2 #2265 the number stands first, and the time of the first message last."""
    another(bag, later)
    (bag / 'trial_0.mcap').rename(bag / listed)
    place = bag / 'metadata.yaml'
    place.write_text(place.read_text().replace('trial_0.mcap', listed))
    assert names(bag) == ([listed, later] if is_read else [listed])
    assert find_files(bag).unlisted == ([] if is_read else [later])


def test_all_files_are_read_if_none_is_listed_or_none_of_the_listed_is_there(bag):
    another(bag, 'another.mcap')
    (bag / 'trial_0.mcap').rename(bag / 'other.mcap')
    assert names(bag) == ['another.mcap', 'other.mcap']
    assert find_files(bag).absent == ['trial_0.mcap']
    (bag / 'metadata.yaml').unlink()
    assert names(bag) == ['another.mcap', 'other.mcap'] and find_files(bag).absent == []


def test_many_strange_files_are_counted_not_listed(bag):
    for number in range(8):
        (bag / f'strange {number}.mcap').touch()
    assert find_files(bag).oddities[0].endswith('strange 4.mcap and 3 more')


@pytest.mark.parametrize('listed', [True, False])
@pytest.mark.parametrize('make', [shutil.copy, os.link, os.symlink])
def test_a_copy_with_the_next_number_doubles_nothing_and_is_named(bag, tmp_path, make, listed):
    whole = len(list(BagReader(bag).messages()))
    make(bag / 'trial_0.mcap', bag / 'trial_1.mcap')
    if not listed:
        (bag / 'metadata.yaml').unlink()
    reader = BagReader(bag)
    assert len(list(reader.messages())) == whole
    said = 'left out, because it is a copy: trial_1.mcap (of trial_0.mcap)'
    assert reader.oddities == [said]
    assert check_bag(bag).files == 1
    total = recover(bag, tmp_path / 'new')
    assert total.messages == whole and total.files == 1
    assert f'trial: {said}' in total.notes


def test_of_equal_files_the_one_that_is_listed_is_read(bag):
    shutil.copy(bag / 'trial_0.mcap', bag / 'trial_-1.mcap')
    (bag / 'trial_0.mcap').rename(bag / 'trial_5.mcap')
    shutil.copy(bag / 'trial_5.mcap', bag / 'trial_4.mcap')
    text = (bag / 'metadata.yaml').read_text().replace('trial_0.mcap', 'trial_5.mcap')
    (bag / 'metadata.yaml').write_text(text)
    found = find_files(bag)
    assert names(bag) == ['trial_5.mcap'] and found.unlisted == ['trial_-1.mcap']
    assert found.copies == [('trial_4.mcap', 'trial_5.mcap')]


def test_files_that_differ_or_are_empty_are_no_copies(bag):
    another(bag, 'trial_1.mcap')
    for number in (2, 3):
        (bag / f'trial_{number}.mcap').touch()
    assert len(names(bag)) == 4 and find_files(bag).copies == []


def test_files_of_different_sizes_are_not_opened(bag, monkeypatch):
    (bag / 'trial_1.mcap').write_bytes((bag / 'trial_0.mcap').read_bytes() + b'x')
    listed = ['trial_0.mcap']
    monkeypatch.setattr(Path, 'open', None)
    assert [each.name for each in find_files(bag, listed).paths] == [
        'trial_0.mcap', 'trial_1.mcap']


def test_the_verdict_names_a_copy_and_counts_its_readings_once(bag, capsys):
    shutil.copy(bag / 'trial_0.mcap', bag / 'trial_1.mcap')
    assert main(['analyze', str(bag), '--set', 'norms.sigma_max_deg=0.3',
                 '--set', 'norms.sigma_ref_max_deg=0.3']) == 0
    out, err = capsys.readouterr()
    assert 'it is a copy: trial_1.mcap (of trial_0.mcap)' in err
    assert 'stamp_not_increasing' not in out


def rename(bag: Path, *names: str) -> None:
    """Make files of these names, all different, out of the only one."""
    for name in names:
        another(bag, name)
        with (bag / name).open('r+b') as file:
            file.seek(bag.joinpath(name).read_bytes().index(b'another'))
            file.write(f'{len(name)}{name}'.encode()[:7])
    (bag / 'trial_0.mcap').unlink()


@pytest.mark.parametrize('files, gone', [
    (['bag_0.mcap', 'bag_2.mcap'], ['bag_1.mcap']),
    (['bag_0.mcap', 'bag_3.mcap'], ['bag_1.mcap', 'bag_2.mcap']),
    (['0_bag_2026_03_01-10_00_07.mcap', '2_bag_2026_03_01-12_00_07.mcap'], ['1_bag_*.mcap']),
    (['bag_0.mcap', 'bag_1.mcap'], []),
    # The older files of a ring are removed; numbers may also be dates.
    (['bag_4.mcap', 'bag_6.mcap'], []),
    (['bag_0.mcap', 'bag_20260301.mcap'], []),
    (['bag_0.mcap', 'other_2.mcap'], [])])
def test_a_file_whose_number_is_missing_is_named_without_a_list_too(bag, tmp_path, files, gone):
    (bag / 'metadata.yaml').unlink()
    rename(bag, *files)
    assert find_files(bag).absent == gone
    incomplete = BagReader(bag).incomplete or ''
    assert all(f'{name} is missing' in incomplete for name in gone)
    assert sum('is missing' in fault for fault in check_bag(bag).faults) == len(gone)
    notes = recover(bag, tmp_path / 'new').notes
    assert [note for note in notes if 'is missing' in note] == [
        f'{name}: is missing' for name in gone]


@pytest.mark.parametrize('listed, files, gone', [
    (['trial_0.mcap', 'trial_1.mcap'], ['trial_0.mcap'], ['trial_1.mcap']),
    (['trial_0.mcap', 'trial_2.mcap'], ['trial_0.mcap', 'trial_2.mcap'], []),
    (['trial_0.mcap'], ['trial_0.mcap', 'trial_2.mcap'], ['trial_1.mcap'])])
def test_the_list_says_which_numbers_there_were(bag, listed, files, gone):
    place = bag / 'metadata.yaml'
    place.write_text(place.read_text().replace(
        '    - trial_0.mcap\n', ''.join(f'    - {name}\n' for name in listed), 1))
    for name in files[1:]:
        another(bag, name)
    assert find_files(bag).absent == gone


def test_the_verdict_notes_a_missing_file(bag, capsys):
    another(bag, 'trial_2.mcap')
    main(['analyze', str(bag), '--set', 'norms.sigma_max_deg=0.2', '--set',
          'norms.sigma_ref_max_deg=0.1'])
    assert 'trial_1.mcap is missing' in capsys.readouterr().err
