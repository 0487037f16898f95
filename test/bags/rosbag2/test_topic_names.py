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

"""A bag of a graph in a namespace gives the verdict of one in the root."""

from __future__ import annotations

import re

import numpy as np
import pytest

from heading_intercompare import analyze_bag, Headings, read_bag, Settings
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import (
    describe_origin,
    read_texts,
    RECORD,
    REPORT_TOPIC,
)
from heading_intercompare.bags.rosbag2.topic_names import find_elsewhere, find_topic
from heading_intercompare.cli import main
from heading_intercompare.core.records import Losses
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.ledger_messages import encode_losses
from heading_intercompare.messages.status_messages import (
    encode_mark,
    encode_text,
    MARKER_TOPIC,
    STATUS_TYPE,
    TEXT_TYPE,
)
from heading_intercompare.readers.registry import open_recording
from heading_intercompare.readers.stream_recording import ReaderError

S = 10 ** 9
T0 = 1_400_000_000 * S
STAMPS = T0 + np.arange(9000) * (S // 10)
SETTINGS = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)
ABSOLUTE = Settings.of(
    sigma_max_deg=0.3, sigma_ref_max_deg=0.1, ts_topic='/gyro', rs_topic='/gnss')


def write(path, place='', told=None, ts='/ts/heading', rs='/rs/heading', into=None):
    """Write 15 minutes of both sensors and all that belongs to them; marks end it after 10."""
    rng = np.random.default_rng(4)
    with BagWriter(path) as bag:
        if told is not None:
            bag.metadata(RECORD, describe_origin(SETTINGS.to_mapping(), namespace=told))
        for where in [place] if into is None else [place, into]:
            for topic, sigma in ((ts, 0.1), (rs, 0.02)):
                name = topic if topic in ('/gyro', '/gnss') else where + topic
                bag.add_topic(name, IMU)
                readings = Headings.of(STAMPS, 100.0 + sigma * rng.standard_normal(9000))
                bag.write_rows([Rows(name, encode_imu(readings, 'x'), STAMPS)])
            bag.add_topic(f'{where}{rs}/lost', STATUS_TYPE)
            bag.write(f'{where}{rs}/lost', encode_losses({'lost.at_source': Losses.of(
                [T0 + 100 * S], [T0 + 99 * S], [11])}), T0 + 900 * S)
            bag.add_topic(f'{where}/{MARKER_TOPIC}', STATUS_TYPE)
            for kind, at in (('start', T0), ('stop', T0 + 600 * S)):
                bag.write(f'{where}/{MARKER_TOPIC}', encode_mark(kind, at), T0)
            bag.add_topic(f'{where}/{REPORT_TOPIC}', TEXT_TYPE)
            bag.write(f'{where}/{REPORT_TOPIC}', encode_text(f'report of {where}'), T0)
    return path


def judge(path, settings=SETTINGS):
    """Return the verdict on a bag without the names of files and their hash."""
    verdict = analyze_bag(path, settings).to_dict()
    for run in verdict['runs']:
        del run['source']
    del verdict['inputs'], verdict['settings'], verdict['settings_sha256']
    return verdict


def test_a_name_is_found_within_the_namespace_only():
    present = ['/a/heading', '/heading', 'bare']
    assert find_topic(present, 'heading') == find_topic(present, '/heading') == '/heading'
    assert find_topic(present, 'heading', '/a') == '/a/heading'
    assert find_topic(present, '/heading', '/a') == '/heading'
    assert find_topic(present, 'heading', '/b') is None
    assert find_topic(present, 'bare') == find_topic(present, '/bare') == 'bare'
    assert find_elsewhere(present, 'heading', '/a') == ['/heading']
    assert find_elsewhere(present, '/heading') == []


@pytest.mark.parametrize('told', ['/ship1', '/ship1/'])
def test_the_bag_of_a_recorder_in_a_namespace_needs_no_other_settings(tmp_path, told):
    """Such a bag had "no topic 'ts/heading'"."""
    root, named = write(tmp_path / 'root'), write(tmp_path / 'named', '/ship1', told)
    assert judge(named) == judge(root)
    run, = analyze_bag(named, SETTINGS).runs
    assert run.end_ns <= T0 + 600 * S, 'its marks count'
    assert read_bag(named).marks == read_bag(root).marks != ()
    assert read_texts(BagReader(named), REPORT_TOPIC) == [(T0, 'report of /ship1')]


def test_headings_of_other_places_are_judged_with_the_marks_of_the_graph(tmp_path):
    """They were silently judged without: a run of 15 minutes instead of 10."""
    places = {'ts': '/gyro', 'rs': '/gnss'}
    root = write(tmp_path / 'root', **places)
    named = write(tmp_path / 'named', '/ship1', '/ship1', **places)
    foreign = write(tmp_path / 'foreign', '/ship1', **places)
    marked = [run.end_ns for run in analyze_bag(root, ABSOLUTE).runs]
    assert [run.end_ns for run in analyze_bag(named, ABSOLUTE).runs] == marked
    with pytest.warns(UserWarning, match='marks of another graph .*/ship1/compliance/marker'):
        read_bag(foreign, ABSOLUTE)


def test_a_bag_of_another_recorder_says_which_namespaces_it_has(tmp_path, capsys):
    bag = write(tmp_path / 'bag', '/ship1', into='/ship2')
    command = ['analyze', str(bag), '--set', 'norms.sigma_max_deg=0.3',
               '--set', 'norms.sigma_ref_max_deg=0.1', '--quiet']
    assert main(command) == 2
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert ("has no topic 'ts/heading', but /ship1/ts/heading (bag_namespace=/ship1) or "
            '/ship2/ts/heading (bag_namespace=/ship2); it has ') in said
    for name in ('/ship1', 'ship2', '/ship2/'):
        assert main([*command, '--set', f'bag_namespace={name}']) == 0
        assert '10 min' in capsys.readouterr().out
    assert main([*command, '--set', 'bag_namespace=/ship3']) == 2
    assert "has no topic 'ts/heading' in /ship3, but /ship1" in capsys.readouterr().err


def test_both_readers_know_the_namespace(tmp_path):
    rosbag1 = pytest.importorskip('rosbags.rosbag1', reason='rosbags is not installed')
    typesys = pytest.importorskip('rosbags.typesys', reason='rosbags is not installed')
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
    with rosbag1.Writer(tmp_path / 'a.bag') as bag:
        bag.write(bag.add_connection('/ship1/note/text', 'std_msgs/msg/String', typestore=store),
                  5, store.serialize_ros1(store.types['std_msgs/msg/String']('x'),
                                          'std_msgs/msg/String'))
    reader = open_recording(tmp_path / 'a.bag', 'ship1')
    assert reader.resolve('note/text') == '/ship1/note/text' and reader.find('other') is None
    words = re.escape('but /ship1/note/text (bag_namespace=/ship1)')
    with pytest.raises(ReaderError, match=words):
        open_recording(tmp_path / 'a.bag').resolve('note/text')
