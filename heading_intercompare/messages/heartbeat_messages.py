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

"""Heartbeats as diagnostic messages: small, so that a watch of many nodes costs little."""

from __future__ import annotations

import math

from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.alarms.graph_watch import Beat, TROUBLE_RULES

from .errors import MessageError
from .status_messages import decode_statuses, encode_statuses, OK, Status, WARN

HEARTBEAT_TOPIC = 'compliance/heartbeat'

_TROUBLES = frozenset(rule.name for rule in TROUBLE_RULES)
#: Words and times of others must not fill the memory, nor keep a dead node alive.
_LONGEST, _LONGEST_S = 300, 3600.0


def encode_beat(beat: Beat, ns: int, owner: str = '') -> bytes:
    """Return a heartbeat as a message of `STATUS_TYPE` with a stamp, nanoseconds."""
    return encode_statuses(ns, [Status(
        beat.name, WARN if beat.troubles else OK, 'ending' if beat.ending else 'running',
        {'priority': beat.priority, 'within_s': beat.within_s, 'keeper': beat.keeper,
         **beat.troubles})], owner)


def decode_beat(data: bytes) -> Beat:
    """Return the heartbeat in a message; MessageError if it is damaged or none."""
    _, statuses = decode_statuses(data)
    if len(statuses) != 1:
        raise MessageError(f'{HEARTBEAT_TOPIC} message with {len(statuses)} statuses: must have 1')
    status, = statuses
    try:
        priority = Priority(status.values.get('priority'))
        within_s = float(status.values.get('within_s', ''))
    except ValueError as error:
        raise MessageError(f'{HEARTBEAT_TOPIC}: {error}') from error
    if not status.name or len(status.name) > _LONGEST or not 0.0 < within_s < math.inf:
        raise MessageError(f'{HEARTBEAT_TOPIC}: must have a name and a time within_s above 0')
    return Beat(status.name, priority, min(within_s, _LONGEST_S),
                status.values.get('keeper') == 'true', status.message == 'ending',
                {kind: words[:_LONGEST] for kind, words in status.values.items()
                 if kind in _TROUBLES})
