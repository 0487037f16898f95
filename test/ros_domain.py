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

"""A ROS domain that no other process that tests on this computer uses."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path
import tempfile
from typing import BinaryIO

#: The ports of higher ones are those that the kernel gives to any program.
_MOST = 101

_held: list[BinaryIO] = []


def take_domain() -> int:
    """Return a free domain; it is taken until this process ends."""
    folder = Path(tempfile.gettempdir(), f'ros_domains_{os.getuid()}')
    folder.mkdir(exist_ok=True)
    # The nodes that an earlier process killed are still known for a while in its domain.
    for step in range(_MOST):
        domain = 1 + (os.getpid() + step) % _MOST
        lock = open(folder / str(domain), 'wb')
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            continue
        _held.append(lock)
        return domain
    raise RuntimeError(f'all {_MOST} ROS domains are in use')


DOMAIN = take_domain()
"""The domain of the graphs of this process, one after the other."""
