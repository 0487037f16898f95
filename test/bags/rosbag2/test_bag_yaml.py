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

"""The YAML of a bag means to parsers what was meant."""

from __future__ import annotations

from textwrap import indent
from time import process_time

import pytest

from heading_intercompare.bags.errors import BagError
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
    assert Qos.of_yaml(QOS_OF_ROSBAG2) == Qos(depth=7)
    assert Qos.of_yaml('[{depth: 3, "reliability": \'best_effort\'}]') == Qos(
        depth=3, reliability='best_effort')
    assert Qos.of_yaml('- history: newer_word\n  durability: 9\n') == Qos(
        'newer_word', durability='9')


@pytest.mark.parametrize('depth', ['²', '9' * 10, '-1', 'many', '~', 'true', '1.5', '[1]', '"7"'])
def test_a_depth_that_cannot_be_is_left_out(depth):
    assert Qos.of_yaml(f'- history: keep_all\n  depth: {depth}\n') == Qos('keep_all')


@pytest.mark.parametrize('text', [
    'history: keep_all', '- keep_all', '[]', '- [history, keep_all]',
    '- history: keep_all\n  x: [',
    '- history: keep_all\n  history: keep_all', '- history: keep_all\n  x: *a',
    '- history: keep_all\n  depth: ' + '9' * 5000, '- history: [keep_all]', '- history: true',
    '- history: keep all', '- history: \ud800', '- history: keep_all\n  x: \x00',
    '- history: keep_all\n#' + 'x' * 2**18, '[' * 10**6])
def test_profiles_that_are_damaged_are_the_default(text):
    assert Qos.of_yaml(text) == Qos()


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


def listing(tmp_path, listed, name='rosbag2_bagfile_information'):
    """Return a metadata.yaml in which a list of files stands."""
    path = tmp_path / 'metadata.yaml'
    path.write_bytes(f'{name}:\n  relative_file_paths: {listed}'.encode(
        errors='surrogatepass'))
    return path


def test_files_listed_are_found_in_any_style(tmp_path):
    path = tmp_path / 'metadata.yaml'
    assert list_parts(path) == []
    path.write_text(metadata_file([PartInfo('a "b" 1.mcap')], {}))
    assert list_parts(path) == ['a "b" 1.mcap']
    listing(tmp_path, "\n  - folder/one_0.mcap\n  - 'two_1.mcap'\n  files:\n    - path: three\n")
    assert list_parts(path) == ['one_0.mcap', 'two_1.mcap']


@pytest.mark.parametrize('listed, expected', [
    ('[a_0.mcap, "b 1.mcap",\n    \'c, "2".mcap\' ]\n  b: [d]',
     ['a_0.mcap', 'b 1.mcap', 'c, "2".mcap']),
    ('[]\n', []), ('', []), ('\n', []), ('~\n', []),
    ("\n    - 'it''s.mcap'\n    - \"2014\"\n    - b [1].mcap\n",
     ["it's.mcap", '2014', 'b [1].mcap']),
    ('["\\x41\\u00e4.mcap"]', ['Aä.mcap'])])
def test_files_are_listed_in_brackets_or_by_lines(tmp_path, listed, expected):
    assert list_parts(listing(tmp_path, listed)) == expected


def test_files_and_topics_that_are_aliases_are_those_of_their_anchors(tmp_path):
    assert list_parts(listing(tmp_path, (
        '&files\n    - &first a_0.mcap\n    - a_1.mcap\n  files: [{path: *first}]\n'
        '  topics_with_message_count:\n    - {qos: &1 [{depth: 3}]}\n    - {qos: *1}'))) == [
            'a_0.mcap', 'a_1.mcap']


@pytest.mark.parametrize('entry', ['a' * 5000, '"a\\u0000b"', '/', '..', '""'])
def test_what_cannot_be_a_file_is_not_listed(tmp_path, entry):
    for listed in (f'\n    - {entry}\n    - a_0.mcap\n', f'[{entry}, a_0.mcap]'):
        assert list_parts(listing(tmp_path, listed)) == ['a_0.mcap']


#: What is no metadata of rosbag2: text, line, problem.
DAMAGED = [
    ('[a_0.mcap, b', 2, 'not YAML: '), ('\n    - "', 3, 'not YAML: '),
    ('[' * 200_000, 2, 'nested'), ('[a]\n  x: \0', 3, 'not YAML: '),
    ('["\\ud800"]', 2, 'not YAML: '), ('[a]\n  x: 1\n  x: 2', 4, "'x' is given twice"),
    ('[a]\n  x: *a', 3, 'the alias *a stands'),
    ('[a]\n  x: !!binary aa', 3, 'tags are not accepted'),
    ('[a]\n---\nb: 1', 3, 'second document'), ('[a]\n  x: \ud800', 3, 'not UTF-8'),
    ('9' * 5000, 2, 'a number with too many digits'),
    ('a_0.mcap', None, 'relative_file_paths must be a list of names'),
    ('[[a]]', None, 'must be a list of names'), ('[7]', None, 'must be a list of names'),
    ('[~]', None, 'must be a list of names'), ('{a: b}', None, 'must be a list of names')]


@pytest.mark.parametrize('listed, line, problem', DAMAGED)
def test_damaged_metadata_are_refused_with_line_and_remedy(tmp_path, listed, line, problem):
    path = listing(tmp_path, listed)
    with pytest.raises(BagError) as refused:
        list_parts(path)
    said = str(refused.value)
    assert said.startswith(f'{path}: ' + ('' if line is None else f'line {line}: '))
    assert problem in said and '\n' not in said
    assert said.endswith('; `recover` reads the bag without this file, and so do all other '
                         'commands once it is removed')


@pytest.mark.parametrize('text', ['', '[]', 'x: 1', 'rosbag2_bagfile_information: ~', '\0' * 512,
                                  'rosbag2_bagfile_information: [a]', '3'])
def test_what_is_no_metadata_of_rosbag2_is_refused(tmp_path, text):
    path = tmp_path / 'metadata.yaml'
    path.write_text(text)
    with pytest.raises(BagError, match='rosbag2_bagfile_information is missing|not YAML'):
        list_parts(path)


def test_a_large_file_is_refused_and_not_read_to_its_end(tmp_path):
    path = listing(tmp_path, '[a_0.mcap]\n')
    with path.open('r+b') as file:
        file.truncate(3 * 2**30)
    with pytest.raises(BagError, match='longer than 67108864 bytes'):
        list_parts(path)


@pytest.mark.parametrize('lines', [
    '    - bag_{}.mcap\n', '    - bag.mcap\n  custom_{}: x\n  relative_{}:\n'])
def test_many_names_take_a_time_that_grows_with_their_number(tmp_path, lines):
    """Eight times the names take about eight times the time; were it the square, 64 times."""
    def seconds(count: int) -> float:
        text = ''.join(lines.format(n, n) for n in range(count))
        path = listing(tmp_path, f'\n    - first.mcap\n{text}    - last.mcap\n')
        began_s = process_time()
        assert list_parts(path)[0] == 'first.mcap'
        return process_time() - began_s
    seconds(100)
    few_s, many_s = (min(seconds(count) for _ in range(3)) for count in (2_500, 20_000))
    assert many_s < 32.0 * few_s


def test_the_bound_is_one_of_bytes_not_of_letters(tmp_path):
    with pytest.raises(BagError, match='longer than 16777216 bytes'):
        list_parts(listing(tmp_path, f'[a_0.mcap]\n#{"ä" * 2**23}'))


@pytest.mark.parametrize('behind', ['compression_mode: ""\n  ', ''])
def test_more_topics_than_fit_leave_the_files_readable(tmp_path, behind):
    """As `recover` writes them of a bag with 60000 topics; a fault after them has its line."""
    row = '    - topic_metadata:\n        name: /{}\n      message_count: 1\n\n'
    rows = ''.join(row.format('x' * 900) for _ in range(20_000))
    text = ('rosbag2_bagfile_information:\n  version: 9\n  topics_with_message_count:\n'
            f'{rows}  {behind}relative_file_paths:\n    - a_0.mcap\n    - a_1.mcap\n')
    path = tmp_path / 'metadata.yaml'
    path.write_text(text)
    assert len(text) > 2**24 and list_parts(path) == ['a_0.mcap', 'a_1.mcap']
    path.write_text(f'{text}  files: [\n')
    with pytest.raises(BagError, match=f'line {text.count(chr(10)) + 1}: '):
        list_parts(path)


def test_metadata_of_any_version_are_read(tmp_path):
    """Up to version 8 profiles are a text with numbers, from version 9 on a list with words."""
    old = ('  topics_with_message_count:\n    - topic_metadata:\n        name: /a\n'
           '        type: std_msgs/msg/String\n        serialization_format: cdr\n'
           '        offered_qos_profiles: "- history: 3\\n  depth: 0\\n  reliability: 1"\n'
           '      message_count: 5\n')
    for version in range(1, 10):
        path = listing(tmp_path, f'\n    - a_0.mcap\n  version: {version}\n{old}')
        assert list_parts(path) == ['a_0.mcap']
    path.write_text(f'rosbag2_bagfile_information:\n{indent(EMPTY_BAG_OF_ROSBAG2, "  ")}\n')
    assert list_parts(path) == ['bag_0.mcap']


@pytest.mark.slow
def test_reading_takes_a_time_that_grows_with_the_length(tmp_path):
    """Twice the names take about twice the time; were it the square, 16 times for 4 times."""
    times = []
    for count in (50_000, 200_000):
        path = listing(tmp_path, '\n' + ''.join(f'    - b_{n}.mcap\n' for n in range(count)))
        began = process_time()
        assert len(list_parts(path)) == count
        times.append(process_time() - began)
    assert times[1] < 10.0 * times[0]


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
