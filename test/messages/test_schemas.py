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

"""Our definitions, schema texts and hashes against those that ROS installs."""

from __future__ import annotations

import json
from pathlib import Path
import re
import sys
import time

import pytest

from heading_intercompare.messages import schemas
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import definitions_in, leaves, short_name
from heading_intercompare.messages.schemas import (
    DEFINITIONS,
    layout_problem,
    schema_of,
    shipped_schema,
    TYPE_HASHES,
)

IMU = 'sensor_msgs/msg/Imu'


def installed(name: str, suffix: str) -> Path:
    """Return the installed file of package/Type, or skip."""
    package, kind = name.split('/')
    path = Path(sys.prefix, 'share', package, 'msg', kind + suffix)
    if not path.is_file():
        pytest.skip(f'{package} is not installed')
    return path


@pytest.fixture
def without_ros(monkeypatch, tmp_path):
    """Hide the installed definitions."""
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))


@pytest.mark.parametrize('type_name', TYPE_HASHES)
def test_hashes_are_those_of_the_installed_type_descriptions(type_name):
    rows = json.loads(installed(short_name(type_name), '.json').read_text())['type_hashes']
    assert TYPE_HASHES[type_name] == {r['type_name']: r['hash_string'] for r in rows}[type_name]


@pytest.mark.parametrize('name', DEFINITIONS)
def test_shipped_definitions_have_the_fields_of_the_installed_ones(name):
    text = installed(name, '.msg').read_text()
    assert definitions_in(name, text) == definitions_in(name, DEFINITIONS[name])


def assembled_by_rosbag2(name: str, seen: set[str]) -> str:
    """Return the text by the rule of rosbag2: depth first, dependencies sorted, each once."""
    text = installed(name, '.msg').read_text()
    package = name.split('/')[0]
    types = re.findall(r'^ *([A-Za-z]\w*(?:/\w+)?)(?:\[[^\]]*\])?[ \t]+\w+ *(?![=\w])', text,
                       re.MULTILINE)
    needed = {t if '/' in t else f'{package}/{t}' for t in types if '/' in t or t[0].isupper()}
    for each in sorted(needed):
        if each not in seen:
            seen.add(each)
            text += '\n' + '=' * 80 + f'\nMSG: {each}\n' + assembled_by_rosbag2(each, seen)
    return text


@pytest.mark.parametrize('type_name', TYPE_HASHES)
def test_schema_text_is_assembled_as_rosbag2_does(type_name):
    assert schema_of(type_name).text == assembled_by_rosbag2(short_name(type_name), set())


def test_dependencies_come_depth_first_in_order_and_once():
    sections = re.findall(r'MSG: (\S+)', shipped_schema('nav_msgs/msg/Odometry').text)
    assert sections == [
        'geometry_msgs/PoseWithCovariance', 'geometry_msgs/Pose', 'geometry_msgs/Point',
        'geometry_msgs/Quaternion', 'geometry_msgs/TwistWithCovariance', 'geometry_msgs/Twist',
        'geometry_msgs/Vector3', 'std_msgs/Header', 'builtin_interfaces/Time']


def test_without_ros_the_shipped_definitions_are_used(without_ros):
    schema = schema_of(IMU)
    assert schema == shipped_schema(IMU)
    assert schema.type_hash == TYPE_HASHES[IMU]
    assert '#' not in schema.text


def test_a_type_of_which_nothing_is_known_is_refused(without_ros):
    with pytest.raises(MessageError, match="'sensor_msgs/msg/Joy' is not installed"):
        schema_of('sensor_msgs/msg/Joy')


def test_an_installed_type_beyond_ours_is_found_with_its_hash():
    installed('sensor_msgs/Joy', '.msg')
    schema = schema_of('sensor_msgs/msg/Joy')
    assert 'float32[] axes' in schema.text and schema.type_hash.startswith('RIHS01_')


def test_ament_prefix_path_is_searched_first(monkeypatch, tmp_path):
    folder = tmp_path / 'share' / 'my_msgs' / 'msg'
    folder.mkdir(parents=True)
    (folder / 'Mine.msg').write_text('float64 mine\n')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    assert schema_of('my_msgs/msg/Mine') == schemas.Schema('my_msgs/msg/Mine', 'float64 mine\n',
                                                           '')


@pytest.mark.parametrize('type_name', TYPE_HASHES)
def test_own_schemas_have_the_layout_assumed(type_name):
    assert layout_problem(type_name, 'ros2msg', schema_of(type_name).text) is None
    assert layout_problem(type_name, 'ros2msg', shipped_schema(type_name).text) is None


@pytest.mark.parametrize('old, new, problem', [
    ('orientation_covariance', 'covariance', 'field covariance where orientation_covariance'),
    ('float64[9] linear', 'float32[9] linear', 'field linear_acceleration_covariance where'),
    ('float64[9] linear_acceleration_covariance\n', '', '30 fields'),
    ('linear_acceleration_covariance\n', 'linear_acceleration_covariance\nfloat64 x\n',
     'more than 16 fields'),
    ('MSG: std_msgs/Header', 'MSG: std_msgs/Other', 'std_msgs/Header is not defined'),
])
def test_a_schema_with_other_fields_is_described(old, new, problem):
    text = shipped_schema(IMU).text
    assert old in text
    fields = len(list(leaves('sensor_msgs/Imu', definitions_in(IMU, text))))
    expected = problem.replace('30', str(fields - 1))
    assert expected in layout_problem(IMU, 'ros2msg', text.replace(old, new, 1))


def test_a_schema_of_a_million_fields_is_refused_unread():
    text = 'float64 a\n' * 1_000_000
    began_s = time.process_time()
    assert 'longer than 262144 letters' in layout_problem(IMU, 'ros2msg', text)
    assert time.process_time() - began_s < 0.5


@pytest.mark.parametrize('last', ['', 'float64 x\n'])
def test_types_within_types_take_no_time_that_grows_with_their_fields(last):
    """Ten to the eighteenth fields in twenty lines."""
    parts = [shipped_schema(IMU).text.replace('float64[9] linear_acceleration_covariance',
                                              'my_msgs/T0 x')]
    parts += [f'{"=" * 80}\nMSG: my_msgs/T{n}\n' + ''.join(
        f'my_msgs/T{n + 1} a{k}\n' for k in range(10)) for n in range(18)]
    parts.append(f'{"=" * 80}\nMSG: my_msgs/T18\n{last}')
    expected = 'field x.a0' if last else 'has no field'
    assert expected in layout_problem(IMU, 'ros2msg', ''.join(parts))


def test_another_schema_encoding_is_described():
    assert 'ros2idl' in layout_problem(IMU, 'ros2idl', '')
