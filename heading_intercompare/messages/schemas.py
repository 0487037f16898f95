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

"""
Definitions and type hashes of the messages in our bags.

Where ROS is installed, the schema text is the installed one, to the byte as rosbag2 records it.
Elsewhere it is the text below: the same fields without comments, which readers treat alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
import json
import os
from pathlib import Path
import sys
from typing import Callable

from .errors import MessageError
from .fields import CODES, Definitions, definitions_in, leaves, short_name

_AZIMUTH = (
    'std_msgs/Header header\nfloat64 azimuth\nfloat64 variance\n'
    'uint8 UNIT_RAD=0\nuint8 UNIT_DEG=1\nuint8 unit\n'
    'uint8 ORIENTATION_ENU=0\nuint8 ORIENTATION_NED=1\nuint8 orientation\n'
    'uint8 REFERENCE_MAGNETIC=0\nuint8 REFERENCE_GEOGRAPHIC=1\nuint8 REFERENCE_UTM=2\n'
    'uint8 reference\n')

#: Field definitions by package/Type.
DEFINITIONS = {
    'builtin_interfaces/Time': 'int32 sec\nuint32 nanosec\n',
    'compass_interfaces/Azimuth': _AZIMUTH,
    'compass_msgs/Azimuth': _AZIMUTH,
    'diagnostic_msgs/DiagnosticArray': 'std_msgs/Header header\nDiagnosticStatus[] status\n',
    'diagnostic_msgs/DiagnosticStatus':
        'byte OK=0\nbyte WARN=1\nbyte ERROR=2\nbyte STALE=3\nbyte level\nstring name\n'
        'string message\nstring hardware_id\nKeyValue[] values\n',
    'diagnostic_msgs/KeyValue': 'string key\nstring value\n',
    'geometry_msgs/Point': 'float64 x\nfloat64 y\nfloat64 z\n',
    'geometry_msgs/Pose': 'Point position\nQuaternion orientation\n',
    'geometry_msgs/PoseWithCovariance': 'Pose pose\nfloat64[36] covariance\n',
    'geometry_msgs/PoseWithCovarianceStamped':
        'std_msgs/Header header\nPoseWithCovariance pose\n',
    'geometry_msgs/Quaternion': 'float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n',
    'geometry_msgs/QuaternionStamped': 'std_msgs/Header header\nQuaternion quaternion\n',
    'geometry_msgs/Transform': 'Vector3 translation\nQuaternion rotation\n',
    'geometry_msgs/TransformStamped':
        'std_msgs/Header header\nstring child_frame_id\nTransform transform\n',
    'geometry_msgs/Twist': 'Vector3 linear\nVector3 angular\n',
    'geometry_msgs/TwistStamped': 'std_msgs/Header header\nTwist twist\n',
    'geometry_msgs/TwistWithCovariance': 'Twist twist\nfloat64[36] covariance\n',
    'geometry_msgs/TwistWithCovarianceStamped':
        'std_msgs/Header header\nTwistWithCovariance twist\n',
    'geometry_msgs/Vector3': 'float64 x\nfloat64 y\nfloat64 z\n',
    'nav_msgs/Odometry':
        'std_msgs/Header header\nstring child_frame_id\n'
        'geometry_msgs/PoseWithCovariance pose\ngeometry_msgs/TwistWithCovariance twist\n',
    'nmea_msgs/Sentence': 'std_msgs/Header header\nstring sentence\n',
    'rosgraph_msgs/Clock': 'builtin_interfaces/Time clock\n',
    'sensor_msgs/Imu':
        'std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n'
        'float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n'
        'float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n'
        'float64[9] linear_acceleration_covariance\n',
    'sensor_msgs/NavSatFix':
        'uint8 COVARIANCE_TYPE_UNKNOWN=0\nuint8 COVARIANCE_TYPE_APPROXIMATED=1\n'
        'uint8 COVARIANCE_TYPE_DIAGONAL_KNOWN=2\nuint8 COVARIANCE_TYPE_KNOWN=3\n'
        'std_msgs/Header header\nNavSatStatus status\nfloat64 latitude\nfloat64 longitude\n'
        'float64 altitude\nfloat64[9] position_covariance\nuint8 position_covariance_type\n',
    'sensor_msgs/NavSatStatus':
        'int8 STATUS_UNKNOWN=-2\nint8 STATUS_NO_FIX=-1\nint8 STATUS_FIX=0\n'
        'int8 STATUS_SBAS_FIX=1\nint8 STATUS_GBAS_FIX=2\nint8 status -2\n'
        'uint16 SERVICE_UNKNOWN=0\nuint16 SERVICE_GPS=1\nuint16 SERVICE_GLONASS=2\n'
        'uint16 SERVICE_COMPASS=4\nuint16 SERVICE_GALILEO=8\nuint16 service\n',
    'std_msgs/Header': 'builtin_interfaces/Time stamp\nstring frame_id\n',
    'std_msgs/String': 'string data\n',
    'tf2_msgs/TFMessage': 'geometry_msgs/TransformStamped[] transforms\n',
}

#: A longer schema is not read: the longest of a known type, with its comments, has some kilobytes.
_MOST_LETTERS = 2**18

#: REP-2016 hashes (RIHS01) of ROS 2 Jazzy.
TYPE_HASHES = {
    'diagnostic_msgs/msg/DiagnosticArray':
        'RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e',
    'geometry_msgs/msg/PoseWithCovarianceStamped':
        'RIHS01_26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e',
    'geometry_msgs/msg/QuaternionStamped':
        'RIHS01_381add86c6c3160644d228ca342182c7fd6c7fab11c7a85ad817a9cc22dbac6e',
    'geometry_msgs/msg/TwistStamped':
        'RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64',
    'geometry_msgs/msg/TwistWithCovarianceStamped':
        'RIHS01_77b67434531e6529b7a0091357b186b6ebdb17fd9ffd3e0c7ce9d3fb11a44563',
    'nav_msgs/msg/Odometry':
        'RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0',
    'nmea_msgs/msg/Sentence':
        'RIHS01_67d3d300e23d1d018584731cd9642ffb4c78d12da1f483d3f2be3a9396c40984',
    'rosgraph_msgs/msg/Clock':
        'RIHS01_692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564',
    'sensor_msgs/msg/Imu':
        'RIHS01_7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b',
    'sensor_msgs/msg/NavSatFix':
        'RIHS01_62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404',
    'std_msgs/msg/String':
        'RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18',
}


@dataclass(frozen=True, slots=True)
class Schema:
    """
    What a bag says about a message type.

    Attributes
    ----------
    type_name
        As package/msg/Type.
    text
        The definition and all definitions it depends on.
    type_hash
        REP-2016 hash, or empty when unknown.
    encoding
        Encoding of the text: ros2msg, or ros2idl, which other recorders may write.

    """

    type_name: str
    text: str
    type_hash: str
    encoding: str = 'ros2msg'


def _find_installed(name: str, suffix: str) -> Path | None:
    """Return the path of the installed file of package/Type, or None."""
    package, _, kind = name.partition('/')
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep) + [sys.prefix]
    for prefix in filter(None, prefixes):
        path = Path(prefix, 'share', package, 'msg', kind + suffix)
        if path.is_file():
            return path
    return None


def _installed_text(name: str) -> str:
    path = _find_installed(name, '.msg')
    if path is None:
        raise LookupError(name)
    return path.read_bytes().decode()


def _assemble(name: str, text_of: Callable[[str], str]) -> str:
    """Return the text of a type and then of its dependencies: depth first, sorted, each once."""
    seen = {name}

    def append(current: str) -> str:
        text = text_of(current)
        parts = [text]
        fields = definitions_in(current, text)[current]
        for needed in sorted({f.type for f in fields} - CODES.keys()):
            if needed not in seen:
                seen.add(needed)
                parts.append('\n' + '=' * 80 + f'\nMSG: {needed}\n' + append(needed))
        return ''.join(parts)

    return append(name)


def _hash_of(type_name: str) -> str:
    if type_name in TYPE_HASHES:
        return TYPE_HASHES[type_name]
    path = _find_installed(short_name(type_name), '.json')
    if path is not None:
        for row in json.loads(path.read_text())['type_hashes']:
            if row['type_name'] == type_name:
                type_hash: str = row['hash_string']
                return type_hash
    return ''


@lru_cache(maxsize=None)
def shipped_schema(type_name: str) -> Schema:
    """Return the schema built from `DEFINITIONS`; LookupError if the type is not in them."""
    text = _assemble(short_name(type_name), DEFINITIONS.__getitem__)
    return Schema(type_name, text, TYPE_HASHES.get(type_name, ''))


def schema_of(type_name: str) -> Schema:
    """
    Return the schema of a message type: the installed one, or ours if none is installed.

    Raises
    ------
    MessageError
        If the type is neither installed nor known to this module.

    Examples
    --------
    >>> schema_of('std_msgs/msg/String').type_hash[:13]
    'RIHS01_df668c'

    """
    try:
        text = _assemble(short_name(type_name), _installed_text)
        return Schema(type_name, text, _hash_of(type_name))
    except LookupError:
        pass
    try:
        return shipped_schema(type_name)
    except LookupError:
        raise MessageError(f'message type {type_name!r} is not installed and not one of '
                           f'{", ".join(TYPE_HASHES)}') from None


@lru_cache(maxsize=None)
def definitions_of(type_name: str) -> Definitions:
    """Return the fields of a type in `DEFINITIONS` and of its dependencies."""
    return definitions_in(type_name, shipped_schema(type_name).text)


def layout_problem(type_name: str, encoding: str, text: str) -> str | None:
    """
    Return how a schema in a bag differs from the layout we expect; None if it does not.

    Parameters
    ----------
    type_name
        One of `TYPE_HASHES`.
    encoding, text
        Schema encoding and text in the bag.

    """
    if encoding != 'ros2msg':
        return f'its schema has encoding {encoding!r}, not ros2msg'
    if len(text) > _MOST_LETTERS:
        return f'its schema is longer than {_MOST_LETTERS} letters'
    name = short_name(type_name)
    ours = list(leaves(name, definitions_of(type_name)))
    try:
        # A few lines of types within types can mean more fields than any memory holds.
        theirs = list(islice(leaves(name, definitions_in(name, text)), len(ours) + 1))
    except MessageError as error:
        return error.problem
    for (path, *kind), (their_path, *their_kind) in zip(ours, theirs):
        if path != their_path or kind != their_kind:
            return f'its schema has field {their_path} where {path} is expected'
    if len(ours) != len(theirs):
        count = f'more than {len(ours)}' if len(theirs) > len(ours) else f'{len(theirs)}'
        return f'its schema has {count} fields instead of {len(ours)}'
    return None
