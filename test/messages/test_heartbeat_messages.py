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

"""Heartbeats as messages."""

from __future__ import annotations

import pytest

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.alarms.graph_watch import Beat, MISMATCH
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.heartbeat_messages import decode_beat, encode_beat
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_statuses,
    OK,
    Status,
    WARN,
)

GOOD = {'priority': 'warning', 'within_s': '5.0'}


@pytest.mark.parametrize('beat', [
    Beat('recorder', Priority.CAUTION), Beat('gyro1/compliance', within_s=48.25, keeper=True),
    Beat('ts_driver', ending=True, troubles={MISMATCH: 'QoS mismatch on ts/heading: DURABILITY'})])
def test_a_heartbeat_reads_back(beat):
    data = encode_beat(beat, 7, '/node 1')
    assert decode_beat(data) == beat
    ns, (status,) = decode_statuses(data)
    assert (ns, status.owner, status.level) == (7, '/node 1', WARN if beat.troubles else OK)


def test_what_others_add_is_left_out_and_what_is_too_long_is_cut():
    status = Status('x', OK, 'running', {
        **GOOD, 'within_s': '1e9', 'other': 'y', MISMATCH: 'z' * 999})
    beat = decode_beat(encode_statuses(0, [status]))
    assert (beat.within_s, len(beat.troubles[MISMATCH]), len(beat.troubles)) == (3600.0, 300, 1)


@pytest.mark.parametrize('statuses', [
    [], [Status('x', OK, 'running', GOOD)] * 2, [Status('x', OK, 'running')],
    [Status('', OK, 'running', GOOD)], [Status('x' * 301, OK, 'running', GOOD)],
    *([Status('x', OK, 'running', {**GOOD, key: value})] for key, value in (
        ('priority', 'emergency'), ('within_s', 'soon'), ('within_s', 'nan'), ('within_s', '-1'),
        ('within_s', 'inf')))])
def test_what_is_no_heartbeat_is_refused(statuses):
    with pytest.raises(MessageError):
        decode_beat(encode_statuses(0, statuses))
