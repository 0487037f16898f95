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

"""Texts as messages."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_text, encode_text


@pytest.mark.parametrize('text', ['', 'all fast', 'Länge 54°\n'])
def test_a_text_arrives_as_it_was(text):
    assert decode_text(encode_text(text)) == text


def test_a_text_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_text(encode_text('all fast')[:-1])
