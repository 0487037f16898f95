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

"""Single messages against the encoders of others."""

from __future__ import annotations

from importlib import import_module

import pytest

from heading_intercompare.messages.cdr import decode, encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.schemas import shipped_schema, TYPE_HASHES

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

HEADER = {'stamp': {'sec': 1406851200, 'nanosec': 183}, 'frame_id': 'gyro'}
VECTOR = {'x': 1.0, 'y': -2.0, 'z': 3.5}
QUATERNION = {'x': 0.0, 'y': 0.0, 'z': 0.6, 'w': 0.8}
NINE = [float(i) for i in range(9)]
POSE = {'pose': {'position': VECTOR, 'orientation': QUATERNION},
        'covariance': [i / 7 for i in range(36)]}
TWIST = {'linear': VECTOR, 'angular': VECTOR}
STATUS = {'level': 2, 'name': 'compliance', 'message': 'no partner', 'hardware_id': '',
          'values': [{'key': 'mean_deg', 'value': '0.125'}, {'key': 'n', 'value': '7'}]}

MESSAGES = {
    'sensor_msgs/msg/Imu': {
        'header': HEADER, 'orientation': QUATERNION, 'orientation_covariance': NINE,
        'angular_velocity': VECTOR, 'angular_velocity_covariance': NINE,
        'linear_acceleration': VECTOR, 'linear_acceleration_covariance': NINE},
    'geometry_msgs/msg/QuaternionStamped': {'header': HEADER, 'quaternion': QUATERNION},
    'geometry_msgs/msg/PoseWithCovarianceStamped': {'header': HEADER, 'pose': POSE},
    'nav_msgs/msg/Odometry': {
        'header': HEADER, 'child_frame_id': 'base', 'pose': POSE,
        'twist': {'twist': TWIST, 'covariance': [0.0] * 36}},
    'geometry_msgs/msg/TwistStamped': {'header': HEADER, 'twist': TWIST},
    'geometry_msgs/msg/TwistWithCovarianceStamped': {
        'header': HEADER, 'twist': {'twist': TWIST, 'covariance': [0.0] * 36}},
    'sensor_msgs/msg/NavSatFix': {
        'header': HEADER, 'status': {'status': -1, 'service': 513}, 'latitude': 54.3,
        'longitude': 10.1, 'altitude': 2.5, 'position_covariance': NINE,
        'position_covariance_type': 2},
    'diagnostic_msgs/msg/DiagnosticArray': {'header': HEADER, 'status': [STATUS, STATUS]},
    'nmea_msgs/msg/Sentence': {'header': HEADER, 'sentence': '$HEHDT,218.53,T*12'},
    'std_msgs/msg/String': {'data': 'Kreiselkompass, Länge 54°'},
    'rosgraph_msgs/msg/Clock': {'clock': HEADER['stamp']},
}


@pytest.fixture(scope='module')
def typestore():
    """Return the message types of Jazzy as rosbags knows them."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    store.register(typesys.get_types_from_msg(
        'std_msgs/msg/Header header\nstring sentence', 'nmea_msgs/msg/Sentence'))
    return store


def test_every_type_that_we_know_is_tried():
    assert MESSAGES.keys() == TYPE_HASHES.keys()


@pytest.mark.parametrize('type_name', MESSAGES)
def test_messages_come_back_as_they_were(type_name):
    assert decode(type_name, encode(type_name, MESSAGES[type_name])) == MESSAGES[type_name]


@pytest.mark.parametrize('type_name', MESSAGES)
def test_bytes_are_those_of_rosbags(typestore, type_name):
    data = encode(type_name, MESSAGES[type_name])
    message = typestore.deserialize_cdr(data, type_name)
    assert bytes(typestore.serialize_cdr(message, type_name, little_endian=True)) == data


@pytest.mark.parametrize('type_name', MESSAGES)
def test_big_endian_messages_of_rosbags_are_read(typestore, type_name):
    message = typestore.deserialize_cdr(encode(type_name, MESSAGES[type_name]), type_name)
    data = bytes(typestore.serialize_cdr(message, type_name, little_endian=False))
    assert data[:2] == b'\0\0'
    assert decode(type_name, data) == MESSAGES[type_name]


# mcap_ros2 before 0.6 has its own idea of the field type byte.
@pytest.mark.parametrize('type_name', sorted(
    MESSAGES.keys() - {'diagnostic_msgs/msg/DiagnosticArray'}))
def test_bytes_are_those_of_mcap_ros2(type_name):
    dynamic = pytest.importorskip('mcap_ros2._dynamic')
    text = shipped_schema(type_name).text
    theirs = dynamic.serialize_dynamic(type_name, text)[type_name](MESSAGES[type_name])
    assert encode(type_name, MESSAGES[type_name]) == bytes(theirs)


@pytest.mark.parametrize('type_name', MESSAGES)
def test_rclpy_reads_and_writes_the_same_but_for_rubbish_in_its_padding(type_name):
    serialization = pytest.importorskip('rclpy.serialization')
    package, _, name = type_name.split('/')
    if package == 'nmea_msgs':
        pytest.importorskip('nmea_msgs', reason='it is built in test/nodes')
    kind = getattr(import_module(f'{package}.msg'), name)
    data = encode(type_name, MESSAGES[type_name])
    message = serialization.deserialize_message(data, kind)
    theirs = serialization.serialize_message(message)
    assert len(theirs) == len(data)
    assert decode(type_name, theirs) == MESSAGES[type_name]
    if 'header' in MESSAGES[type_name]:
        assert message.header.stamp.sec == 1406851200 and message.header.frame_id == 'gyro'


def test_a_level_reads_as_a_number():
    data = encode('diagnostic_msgs/msg/DiagnosticArray', {'status': [{'level': 2}]})
    assert decode('diagnostic_msgs/msg/DiagnosticArray', data)['status'][0]['level'] == 2


def test_absent_fields_are_zero():
    imu = decode('sensor_msgs/msg/Imu', encode('sensor_msgs/msg/Imu', {}))
    assert imu['header'] == {'stamp': {'sec': 0, 'nanosec': 0}, 'frame_id': ''}
    assert imu['orientation_covariance'] == [0.0] * 9


@pytest.mark.parametrize('type_name', MESSAGES)
def test_a_message_cut_anywhere_is_refused(type_name):
    data = encode(type_name, MESSAGES[type_name])
    for size in range(len(data)):
        with pytest.raises(MessageError, match='ends early|does not start as CDR'):
            decode(type_name, data[:size])


def test_a_sequence_that_claims_to_be_endless_is_refused():
    data = bytearray(encode('diagnostic_msgs/msg/DiagnosticArray', {}))
    data[-4:] = b'\xff' * 4
    with pytest.raises(MessageError, match='ends early'):
        decode('diagnostic_msgs/msg/DiagnosticArray', bytes(data))


@pytest.mark.parametrize('message, problem', [
    ({'headr': {}}, "no field 'headr'"),
    ({'orientation_covariance': [1.0]}, '1 elements instead of 9'),
    ({'header': {'stamp': {'sec': 2**31}}}, 'sec'),
    ({'orientation': {'x': 'east'}}, 'east'),
])
def test_a_message_that_does_not_fit_its_type_is_refused(message, problem):
    with pytest.raises(MessageError, match=problem):
        encode('sensor_msgs/msg/Imu', message)


WORDS = st.text(st.characters(exclude_categories=['Cs'], exclude_characters='\0'), max_size=20)


@hypothesis.given(WORDS, st.lists(st.tuples(WORDS, WORDS), max_size=4))
def test_strings_of_any_length_come_back(name, pairs):
    values = [{'key': key, 'value': value} for key, value in pairs]
    message = {'header': {'stamp': {'sec': 1, 'nanosec': 2}, 'frame_id': name},
               'status': [{'level': 1, 'name': name, 'message': '', 'hardware_id': name,
                           'values': values}]}
    type_name = 'diagnostic_msgs/msg/DiagnosticArray'
    assert decode(type_name, encode(type_name, message)) == message
