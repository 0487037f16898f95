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

"""What a sensor says of its own readings, to messages on a topic beside its headings and back."""

from __future__ import annotations

import math

from heading_intercompare.core.records import NORMAL_QUALITY, Quality, QUALITY_FLAGS

from .errors import MessageError
from .stamps import fits_message
from .status_messages import decode_statuses, encode_statuses, OK, Status, WARN

_NAME = 'quality'
_MOST = 2**63
#: Rows of one message, at most.
_MOST_ROWS = 200


def quality_topic(heading_topic: str) -> str:
    """Return the topic of the quality beside a topic of headings."""
    return f'{heading_topic}/quality'


def encode_quality(quality: Quality) -> bytes:
    """Return rows, at least one, as a message of statuses with the stamp of the newest."""
    columns = (quality.stamp_ns.tolist(), quality.stated_deg.tolist(), quality.flag.tolist())
    return encode_statuses(max(columns[0]), [
        Status(_NAME, WARN if flag > NORMAL_QUALITY else OK, QUALITY_FLAGS[flag], {
            'stamp_ns': stamp_ns, 'stated_deg': None if math.isnan(stated_deg) else stated_deg})
        for stamp_ns, stated_deg, flag in zip(*columns)])


def quality_messages(quality: Quality) -> list[bytes]:
    """Return rows as messages, for publishing; skip rows whose stamp no message can hold."""
    rows = quality[fits_message(quality.stamp_ns)]
    return [encode_quality(rows[at:at + _MOST_ROWS])
            for at in range(0, len(rows), _MOST_ROWS)]


def decode_quality(data: bytes) -> Quality:
    """
    Return the rows in a message of `encode_quality`.

    Raises
    ------
    MessageError
        If the message is damaged, a stamp or a claim is no number, or a flag is unknown.

    """
    _, statuses = decode_statuses(data)
    try:
        rows = [(int(status.values['stamp_ns']), float(status.values.get('stated_deg', 'nan')),
                 QUALITY_FLAGS.index(status.message)) for status in statuses]
    except (KeyError, ValueError):
        raise MessageError('quality: a stamp, a claim or a flag is none') from None
    if any(not -_MOST < stamp_ns < _MOST or stated_deg <= 0.0 or math.isinf(stated_deg)
           for stamp_ns, stated_deg, _ in rows):
        raise MessageError('quality: a stamp or a claim is out of range')
    return Quality.of(*zip(*rows)) if rows else Quality.empty()
