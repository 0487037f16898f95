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

"""Marks as messages."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import (
    decode_marks,
    decode_statuses,
    encode_mark,
    encode_statuses,
    MARKS,
    OK,
    Status,
)


@pytest.mark.parametrize('kind', MARKS)
def test_a_mark_arrives_with_its_stamp(kind):
    assert decode_marks(encode_mark(kind, 123_456_789_012)) == [(kind, 123_456_789_012)]


def test_a_mark_names_its_operator_and_one_without_a_name_has_the_bytes_of_before():
    assert decode_marks(encode_mark('stop', 7, 'J. Smith')) == [('stop', 7)]
    _, (status,) = decode_statuses(encode_mark('stop', 7, 'J. Smith'))
    assert status.values == {'operator': 'J. Smith'}
    assert encode_mark('stop', 7) == encode_statuses(7, [Status('marker', OK, 'stop')])


def test_a_mark_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_marks(encode_mark('start', 1)[:-1])
