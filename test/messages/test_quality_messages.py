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

"""What a sensor says of its readings, to messages and back."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Quality, QUALITY_FLAGS
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.quality_messages import (
    decode_quality,
    encode_quality,
    quality_topic,
)
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    OK,
    Status,
    WARN,
)

ROWS = Quality.of([3, 10 ** 18 + 7, 5], [0.1 + 0.2, np.nan, 4.986], [1, 0, 3])


def test_rows_come_back_to_the_bit():
    assert decode_quality(encode_quality(ROWS)) == ROWS
    for flag in range(len(QUALITY_FLAGS)):
        row = Quality.of([9], [0.5], [flag])
        assert decode_quality(encode_quality(row)) == row


def test_a_poor_reading_is_a_warning_for_those_who_show_diagnostics():
    _, statuses = decode_statuses(encode_quality(ROWS))
    assert [(status.level, status.message) for status in statuses] == [
        (OK, 'normal'), (OK, 'unknown'), (WARN, 'float solution')]
    assert quality_topic('/rs/heading') == '/rs/heading/quality'


@pytest.mark.parametrize('words, values', [
    ('splendid', {'stamp_ns': 1}), ('normal', {}), ('normal', {'stamp_ns': 'x'}),
    ('normal', {'stamp_ns': 2 ** 70}), ('normal', {'stamp_ns': 1, 'stated_deg': 'y'}),
    ('normal', {'stamp_ns': 1, 'stated_deg': -0.1}),
    ('normal', {'stamp_ns': 1, 'stated_deg': 'inf'})])
def test_a_row_that_says_nothing_sound_is_refused(words, values):
    with pytest.raises(MessageError, match='^quality: '):
        decode_quality(encode_statuses(1, [Status('quality', OK, words, values)]))


def test_a_damaged_message_is_refused():
    with pytest.raises(MessageError):
        decode_quality(encode_quality(ROWS)[:40])
