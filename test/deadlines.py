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


"""How long a test waits for what must come, and how long what must be quick has taken."""

from pathlib import Path
import time

_PRESSURE = Path('/proc/pressure/cpu')

#: Seconds. A wait ends as soon as the condition holds, so this costs nothing while tests pass. A
#: loaded machine with slow cores has taken 20 s for what takes 7 s on an idle one.
DEADLINE_S = 150.0


class Stopwatch:
    """
    Times what must be quick; it stands while a program of this computer waits for a processor.

    So a bound holds on a loaded machine, too. Where the kernel does not say how long programs
    have waited, the watch does not stand.
    """

    def __init__(self) -> None:
        self._began_s = _free_s()

    @property
    def passed_s(self) -> float:
        """Time since this watch was made, seconds."""
        return _free_s() - self._began_s


def _free_s() -> float:
    """Return the time of the clock without that in which some program waited for a processor."""
    try:
        some = _PRESSURE.read_text('ascii')
    except OSError:
        return time.monotonic()
    return time.monotonic() - int(some.partition('total=')[2].split()[0]) / 1e6
