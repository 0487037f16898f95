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

"""The layouts for other displays name topics and fields that the nodes publish and record."""

from __future__ import annotations

import importlib
import json
import re
from xml.etree import ElementTree

from diagnostic_msgs.msg import DiagnosticStatus
from nodes.launch_files import FOLDER, nodes
from nodes.ros_nodes import NORMS
import pytest
from rclpy.node import Node
import yaml

from heading_intercompare.bags.recording.part_states import PartStates
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.judging.figures import SCALARS
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import HeadingTypes, Taking
from heading_intercompare.nodes.taking.recorded_topics import make_intakes

ROOT = FOLDER.parent
DISPLAYS = ROOT / 'displays'
POLICY = ElementTree.parse(ROOT / 'security' / 'heading_intercompare.policy.xml').getroot()


def walk(value):
    """Return all mappings in a JSON value."""
    found = [value] if isinstance(value, dict) else []
    for one in value.values() if isinstance(value, dict) else value:
        found += walk(one) if isinstance(one, (dict, list)) else []
    return found


def paths_in(name):
    """Return the topics in a layout, each with the field that it shows, '' for all of it."""
    path = DISPLAYS / name
    if path.suffix == '.xml':
        root = ElementTree.parse(path).getroot()
        curves = [curve.get('name') for curve in root.iter('curve')]
        topics = [topic.get('name') for topic in root.iter('topic')]
        split = [re.fullmatch(r'(/scalar/\w+|/pairs)/(.+)', curve).groups() for curve in curves]
        assert not topics or {topic for topic, _ in split} == {*topics}
        return {(topic, field.replace('/', '.')) for topic, field in split}
    layout = json.loads(path.read_text('utf-8'))
    panels = walk(layout['configById'])
    shown = {one[key] for one in panels for key in ('value', 'path', 'topicPath') if key in one}
    found = {tuple((one.split('.', 1) + [''])[:2]) for one in shown}
    return found | {(one['topicToRender'], '') for one in panels if 'topicToRender' in one}


def get_message(type_name):
    """Return the class of a message type."""
    package, _, name = type_name.split('/')
    return getattr(importlib.import_module(f'{package}.msg'), name)


def has_field(type_name, field):
    """Tell whether a message type has a field, given as a.b or a[0].b."""
    kind = get_message(type_name)
    for part in filter(None, field.split('.')):
        name, index = re.fullmatch(r'(\w+)(\[0\])?', part).groups()
        kinds = kind.get_fields_and_field_types()
        if name not in kinds:
            return False
        inner = kinds[name].removeprefix('sequence<').removesuffix('>')
        assert (inner != kinds[name]) == bool(index), part
        if '/' in inner:
            kind = get_message(inner.replace('/', '/msg/'))
    return True


@pytest.mark.parametrize('name', ['lichtblick_live.json', 'plotjuggler_live.xml'])
def test_a_live_layout_shows_what_the_nodes_publish(ros, name):
    node = ros.ours(Compliance)
    made = dict(node.get_publisher_names_and_types_by_node(node.get_name(), '/'))
    paths = paths_in(name)
    assert len(paths) >= 6
    for topic, field in paths:
        kind, = made[topic]
        assert has_field(kind, field), (topic, field)
    assert {f'/{topic}' for topic in SCALARS} - {topic for topic, _ in paths} <= {'/scalar/lag_s'}


@pytest.mark.parametrize('name', ['lichtblick_bag.json', 'plotjuggler_bag.xml'])
def test_a_layout_for_bags_shows_what_the_recorder_records(ros, name):
    node = ros.add(Node, 'recording')
    made = make_intakes(node, Settings.from_mapping(NORMS), Taking(), HeadingTypes(), Health(node),
                        PartStates(10.0))
    types = {one.intake.full_name: [*one.intake._types] for one in made.values()}
    for topic, field in paths_in(name):
        assert any(has_field(kind, field) for kind in types[topic]), (topic, field)


@pytest.mark.parametrize('name', ['lichtblick_live.json', 'lichtblick_bag.json'])
def test_a_layout_of_lichtblick_places_each_panel_once(name):
    layout = json.loads((DISPLAYS / name).read_text('utf-8'))

    def leaves(part):
        return [part] if isinstance(part, str) else leaves(part['first']) + leaves(part['second'])
    assert sorted(leaves(layout['layout'])) == sorted(layout['configById'])


def test_the_lamp_is_green_only_for_the_level_of_a_certificate():
    for name in ('lichtblick_live.json', 'lichtblick_bag.json'):
        lamp = json.loads((DISPLAYS / name).read_text('utf-8'))['configById']['Indicator!verdict']
        levels = {int(rule['rawValue']): rule['label'] for rule in lamp['rules']}
        assert {level for level, label in levels.items() if label == 'COMPLIANT'} == {
            DiagnosticStatus.OK[0]}
        assert lamp['fallbackLabel'] == 'none yet'


def test_the_tree_of_states_has_each_node_once(tmp_path):
    """As the profiles of the policy and the launch files name them, in any namespace."""
    text = (DISPLAYS / 'diagnostic_aggregator.yaml').read_text('utf-8')
    groups = {key: one for key, one in yaml.safe_load(text)['analyzers']['ros__parameters'].items()
              if isinstance(one, dict)}
    words = [word for one in groups.values() for word in one['contains']]
    names = {profile.get('node') for profile in POLICY.iter('profile')}
    config = tmp_path / 'a.yaml'
    config.write_text('/**:\n  ros__parameters: {norms: {sigma_max_deg: 1.0, '
                      'sigma_ref_max_deg: 1.0}}\n')
    names |= {node.name for node in nodes('intercompare.launch.py', config=str(config))}
    names &= {'ts_driver', 'rs_driver', 'synchronizer', 'compliance', 'recorder', 'replayer',
              'dashboard', 'sensor_simulator', 'nmea_driver', 'motion_driver'}
    assert len(names) >= 7
    for state in (f'{place}{name}: part' for name in names for place in ('', 'ship1/', 'gyro1/')):
        assert sum(word in state for word in words) == 1, state


def test_the_page_lists_the_files_and_topics():
    page = (ROOT / 'docs' / 'displays.md').read_text('utf-8')
    for path in DISPLAYS.iterdir():
        assert f'`{path.name}`' in page
    for topic, words in SCALARS.items():
        assert f'| `{topic}` | {words} |' in page
