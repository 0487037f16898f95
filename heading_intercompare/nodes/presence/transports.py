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

"""
How a live graph reaches other processes: by UDP, unless the user decides otherwise.

Fast DDS prefers shared memory. If a process is stopped or killed while it uses that, others may
lose their connection to it for good: nothing they publish arrives any more. The launch file makes
the same choice.
"""

from __future__ import annotations

from contextlib import contextmanager
import os
from typing import Iterator

#: Processes on a busy computer have discovered each other this long after their start.
DISCOVERY_S = 3.0

#: How far a context looks for others.
RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'

_TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
# With a file of profiles the user decides on the transports there.
_PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')


def is_alone() -> bool:
    """Tell whether nodes hear only those of their own process."""
    return os.environ.get(RANGE) == 'OFF'


@contextmanager
def set_variable(name: str, value: str) -> Iterator[None]:
    """Set a variable of the environment while entered."""
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        os.environ.pop(name)
        if before is not None:
            os.environ[name] = before


@contextmanager
def prefer_udp() -> Iterator[None]:
    """Let contexts that are made while entered use UDP, unless the user has chosen transports."""
    if any(name in os.environ for name in (_TRANSPORTS, *_PROFILES)):
        yield
    else:
        with set_variable(_TRANSPORTS, 'UDPv4'):
            yield
