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

"""Sentences of NMEA 0183 for tests: their checksum is right unless a test makes it wrong."""

from __future__ import annotations

from functools import reduce
from operator import xor
import zlib


def checksum_of(body: str) -> int:
    """Return the checksum of what stands between ``$`` and ``*``."""
    return reduce(xor, body.encode(), 0)


def with_checksum(body: str) -> str:
    """Return a sentence without its line end, given what stands between ``$`` and ``*``."""
    return f'${body}*{checksum_of(body):02X}'


def with_long_checksum(body: str) -> str:
    """Return a log of a receiver, from its name on, with its checksum of 32 bits."""
    return f'{body}*{zlib.crc32(body.encode(), 2**32 - 1) ^ 2**32 - 1:08x}'
