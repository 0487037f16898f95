# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The YAML of a bag means to parsers what was meant."""

from __future__ import annotations

import pytest

from heading_intercompare.bags.rosbag2.bag_yaml import (
    bag_metadata,
    list_parts,
    metadata_file,
    PartInfo,
    Qos,
    TopicRow,
)

yaml = pytest.importorskip('yaml')

# As rosbag2 of ROS 2 Rolling wrote it in October 2025 for the talker of its demos.
QOS_OF_ROSBAG2 = """- history: keep_last
  depth: 7
  reliability: reliable
  durability: volatile
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: automatic
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false"""

# Likewise the record at the start of a bag.
EMPTY_BAG_OF_ROSBAG2 = """version: 9
storage_identifier: mcap
duration:
  nanoseconds: 0
starting_time:
  nanoseconds_since_epoch: 9223372036854775807
message_count: 0
topics_with_message_count:
  []
compression_format: ""
compression_mode: ""
relative_file_paths:
  - bag_0.mcap
files:
  - path: bag_0.mcap
    starting_time:
      nanoseconds_since_epoch: 9223372036854775807
    duration:
      nanoseconds: 0
    message_count: 0
custom_data: ~
ros_distro: jazzy"""


def test_qos_is_written_as_rosbag2_writes_it():
    assert Qos(depth=7).to_yaml() == QOS_OF_ROSBAG2


def test_qos_is_read_from_words_and_numbers():
    qos = Qos('keep_all', 5, 'best_effort', 'transient_local')
    assert Qos.of_yaml(qos.to_yaml() + '\n' + Qos().to_yaml()) == qos
    assert Qos.of_yaml('- history: 3\n  depth: 0\n  reliability: 1\n  durability: 2\n') == Qos(
        'unknown', 0, 'reliable', 'volatile')
    assert Qos.of_yaml('') == Qos()


@pytest.mark.parametrize('depth', ['²', '9' * 5000, '-', 'many'])
def test_a_depth_that_cannot_be_is_left_out(depth):
    assert Qos.of_yaml(f'- history: keep_all\n  depth: {depth}\n') == Qos('keep_all')


def test_an_empty_bag_is_described_as_rosbag2_does():
    parts = [PartInfo('bag_0.mcap')]
    file_text, record_text = metadata_file(parts, {}), bag_metadata(parts, {})
    expected = yaml.safe_load(EMPTY_BAG_OF_ROSBAG2)
    assert yaml.safe_load(record_text) == expected
    assert yaml.safe_load(file_text) == {'rosbag2_bagfile_information': expected}
    assert list(yaml.safe_load(record_text)) == list(expected)


@pytest.mark.parametrize('name', [
    'trial: 3 #1', "it's", 'a "b" \\c', 'null', 'Yes', '2014', '1e3', '- x', 'Länge 54°', '~', '',
    ' blank ', '[x]', 'a: b', '日本', '\U0001F6A2', 'tab\there', '0x10', '.5', '1:30',
    'x\x7f', 'x\x85 y', 'x\ufffe', 'x\u2028y', '\ufeffx'])
def test_any_text_comes_back(name):
    part = PartInfo(name, 5, 12, 3, [TopicRow('/ts', 'a/msg/B', '', Qos(), 3)])
    loaded = yaml.safe_load(bag_metadata([part], {name: name}))
    assert loaded['relative_file_paths'] == [name]
    assert loaded['custom_data'] == {name: name}
    assert loaded['duration'] == {'nanoseconds': 7}
    assert loaded['topics_with_message_count'][0]['message_count'] == 3


def test_files_listed_are_found_in_any_style(tmp_path):
    path = tmp_path / 'metadata.yaml'
    assert list_parts(path) == []
    path.write_text(metadata_file([PartInfo('a "b" 1.mcap')], {}))
    assert list_parts(path) == ['a "b" 1.mcap']
    path.write_text("x:\n  relative_file_paths:\n  - folder/one_0.mcap\n  - 'two_1.mcap'\n"
                    '  files:\n    - path: three\n')
    assert list_parts(path) == ['one_0.mcap', 'two_1.mcap']


@pytest.mark.parametrize('listed, expected', [
    ('[a_0.mcap, "b 1.mcap",\n    \'c, "2".mcap\' ]\n  b: [d]',
     ['a_0.mcap', 'b 1.mcap', 'c, "2".mcap']),
    ('[]\n', []), ('[a_0.mcap, b', ['a_0.mcap']), ('', []), ('\n', []), ('~\n', []),
    ("\n    - 'it''s.mcap'\n    - 2014\n    - b [1].mcap\n", ["it's.mcap", '2014', 'b [1].mcap'])])
def test_files_are_listed_in_brackets_or_by_lines(tmp_path, listed, expected):
    path = tmp_path / 'metadata.yaml'
    path.write_text(f'x:\n  relative_file_paths: {listed}')
    assert list_parts(path) == expected


@pytest.mark.parametrize('entry', ['[' * 200_000, '9' * 5000, 'a' * 5000, '"\\ud800"',
                                   '"a\\u0000b"', '/', '"', "'"])
def test_what_cannot_be_a_file_is_not_listed(tmp_path, entry):
    path = tmp_path / 'metadata.yaml'
    for listed in (f'\n    - {entry}\n    - a_0.mcap\n', f'[{entry}, a_0.mcap]'):
        path.write_text(f'x:\n  relative_file_paths:{listed}')
        assert list_parts(path)[-1:] == ['a_0.mcap']


def test_of_a_large_file_only_the_beginning_is_read(tmp_path):
    path = tmp_path / 'metadata.yaml'
    path.write_text('  relative_file_paths:\n    - a_0.mcap\n')
    with path.open('r+b') as file:
        file.truncate(3 * 2**30)
    assert list_parts(path) == ['a_0.mcap']


def test_counts_and_spans_of_several_files_are_joined():
    parts = [PartInfo('a_0.mcap', 5, 12, 3, [TopicRow('/ts', 'a/msg/B', '', Qos(), 3)]),
             PartInfo('a_1.mcap'),
             PartInfo('a_2.mcap', 4, 30, 2, [TopicRow('/ts', 'a/msg/B', '', Qos(), 1),
                                             TopicRow('/rs', 'a/msg/B', '', Qos(), 1)])]
    loaded = yaml.safe_load(bag_metadata(parts, {}))
    assert loaded['starting_time'] == {'nanoseconds_since_epoch': 4}
    assert loaded['duration'] == {'nanoseconds': 26}
    assert loaded['message_count'] == 5
    assert loaded['relative_file_paths'] == ['a_0.mcap', 'a_1.mcap', 'a_2.mcap']
    assert [f['duration']['nanoseconds'] for f in loaded['files']] == [7, 0, 26]
    assert [t['message_count'] for t in loaded['topics_with_message_count']] == [4, 1]
