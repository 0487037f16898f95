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

"""Definition texts are read as ROS writes them."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.fields import definitions_in, Field, leaves, SEQUENCE

TEXT = """# A comment, and a constant
byte OK=0
string WORD = "a # b"
float64 x 1.5   # with default
float64[9] covariance
int32[] many
uint8[<=5] few
string<=10 name
Inner[2] twins
other_msgs/msg/Thing thing
{0}
MSG: some_msgs/Inner
bool flag
{0}
MSG: other_msgs/Thing
octet code
""".format('=' * 80)


def test_fields_constants_defaults_and_arrays_are_told_apart():
    found = definitions_in('some_msgs/msg/Root', TEXT)
    assert found['some_msgs/Root'] == (
        Field('x', 'float64', None), Field('covariance', 'float64', 9),
        Field('many', 'int32', SEQUENCE), Field('few', 'uint8', SEQUENCE),
        Field('name', 'string', None), Field('twins', 'some_msgs/Inner', 2),
        Field('thing', 'other_msgs/Thing', None))


def test_leaves_are_the_primitive_fields_in_the_order_of_the_wire():
    found = definitions_in('some_msgs/msg/Root', TEXT)
    assert list(leaves('some_msgs/Root', found)) == [
        ('x', 'd', None), ('covariance', 'd', 9), ('many', 'i', SEQUENCE), ('few', 'B', SEQUENCE),
        ('name', 's', None), ('twins[]', '', 2), ('twins.flag', '?', None),
        ('thing.code', 'B', None)]


def test_a_type_that_contains_itself_is_refused():
    found = definitions_in('a_msgs/Loop', 'Loop inner\n')
    with pytest.raises(MessageError, match='a_msgs/Loop'):
        list(leaves('a_msgs/Loop', found))


def test_a_line_that_is_no_field_is_refused():
    with pytest.raises(MessageError, match='};'):
        definitions_in('a_msgs/Odd', '};\n')
