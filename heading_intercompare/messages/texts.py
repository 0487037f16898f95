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

"""Texts as messages: reports, and the operator's notes."""

from __future__ import annotations

from .cdr import decode, encode

__all__ = ['decode_text', 'encode_text', 'TEXT_TYPE']

TEXT_TYPE = 'std_msgs/msg/String'


def encode_text(text: str) -> bytes:
    """Return a text as std_msgs/msg/String."""
    return encode(TEXT_TYPE, {'data': text})


def decode_text(data: bytes) -> str:
    """Return the text of a std_msgs/msg/String; MessageError if it is damaged."""
    text: str = decode(TEXT_TYPE, data)['data']
    return text
