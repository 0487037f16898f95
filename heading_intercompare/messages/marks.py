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

"""Marks that start and stop runs, to messages and back."""

from __future__ import annotations

from .status_messages import decode_statuses, encode_statuses, OK, Status

__all__ = ['decode_marks', 'encode_mark', 'MARKER_TOPIC', 'MARKS']

MARKER_TOPIC = 'compliance/marker'

MARKS = ('start', 'stop')


def encode_mark(kind: str, ns: int) -> bytes:
    """Return a mark, 'start' or 'stop', as `STATUS_TYPE`; `ns` is the stamp of the newest pair."""
    return encode_statuses(ns, [Status('marker', OK, kind)])


def decode_marks(data: bytes) -> list[tuple[str, int]]:
    """Return the kind and stamp (ns) of the marks in a message; MessageError if damaged."""
    ns, statuses = decode_statuses(data)
    return [(status.message, ns) for status in statuses]
