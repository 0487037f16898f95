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

"""Sentences and bytes that come over the loopback of this machine."""

from __future__ import annotations

import socket
import time

from checksums import with_checksum

HDT = [b'$HEHDT,1.0,T*2E\r\n', b'$HEHDT,2.0,T*2D\r\n', b'$HEHDT,3.0,T*2C\r\n']
DEADLINE_S = 10.0


def sentence(text: str) -> bytes:
    """Return a sentence with its checksum."""
    return f'{with_checksum(text)}\r\n'.encode()


def read_until(source, done):
    """Read until `done(what has come)`, at most ten seconds."""
    received, end = [], time.monotonic() + DEADLINE_S
    while not done(received):
        assert time.monotonic() < end, f'only {received} came; {source.status}'
        received += source.read(0.5)
    return received


def joined(received) -> bytes:
    """Return all bytes of what has come."""
    return b''.join(came.data for came in received)


def free_port(kind: int) -> int:
    """Return a port of the loopback that nobody uses."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]
