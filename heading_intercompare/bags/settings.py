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

"""Settings of the bag writer."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.declared_settings import Checked, setting


@dataclass(frozen=True, slots=True)
class BagSettings(Checked):
    """How bags are written."""

    chunk_bytes: int = setting(
        1048576, 'size at which a chunk of messages is compressed and written [bytes]',
        1024, 268435456)
    compression: str = setting(
        'zstd', 'compression of the chunks', choices=('none', 'lz4', 'zstd'))
    flush_interval_s: float = setting(
        0.5, 'longest time that messages stay in memory while recording; this much is lost if '
        'the recorder is killed [s]', 0.0, 3600.0)
    fsync_interval_s: float = setting(
        0.5, 'least time from one sync of the file to the disk to the next, which follows a write '
        'from memory; the longer of both times is lost if power fails [s]', 0.0, 3600.0)
    split_bytes: int = setting(
        0, 'size at which a bag continues in a new file; 0: never [bytes]', 0, 2**50)
    split_duration_s: float = setting(
        0.0, 'time after which a bag continues in a new file; 0: never [s]', 0.0, 1e9)
    free_space_mb: float = setting(
        100.0, 'recording stops while less than this is free on the disk [MB]', 0.0, 1e9)
    waiting_mb: float = setting(
        64.0, 'memory for messages that cannot be written at the moment; further messages are '
        'lost and counted [MB]', 0.0, 100000.0)
