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

"""Sentences for the drivers of a test, and ports to send them to."""

from __future__ import annotations

import socket
from threading import Event, Thread
import time

from checksums import with_checksum


def sentence(heading) -> str:
    """Return an HDT sentence with a heading, a number or text."""
    body = f'HEHDT,{heading},T'
    return f'{with_checksum(body)}\r\n'


def free_port() -> int:
    """Return a port of UDP that nobody listens to."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


class TurningShip(Thread):
    """Sends the heading of a turning ship to two UDP ports, 20 times a second, until stopped."""

    def __init__(self, ports):
        super().__init__(daemon=True)
        self.ports, self.sent, self.stopped = ports, {}, Event()

    def run(self):
        """Send; note between which times each heading was sent."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            while not self.stopped.wait(0.05):
                heading = round(len(self.sent) * 0.1 % 360.0, 1)
                before_ns = time.time_ns()
                for port in self.ports:
                    out.sendto(sentence(heading).encode(), ('127.0.0.1', port))
                self.sent[heading] = (before_ns, time.time_ns())
