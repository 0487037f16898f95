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
from heading_intercompare.messages.status_messages import decode_marks, encode_mark, MARKS


@pytest.mark.parametrize('kind', MARKS)
def test_a_mark_arrives_with_its_stamp(kind):
    assert decode_marks(encode_mark(kind, 123_456_789_012)) == [(kind, 123_456_789_012)]


def test_a_mark_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_marks(encode_mark('start', 1)[:-1])
