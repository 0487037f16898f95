# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the bag writer."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.settings import Checked, setting

__all__ = ['BagSettings']


@dataclass(frozen=True, slots=True)
class BagSettings(Checked):
    """How bags are written."""

    chunk_bytes: int = setting(
        1048576, 'size at which a chunk of messages is compressed and written [bytes]',
        1024, 268435456)
    compression: str = setting(
        'zstd', 'compression of the chunks', choices=('none', 'lz4', 'zstd'))
    flush_interval_s: float = setting(
        0.5, 'longest time that messages stay in memory while recording; what is lost when the '
        'recorder is killed [s]', 0.0, 3600.0)
    fsync_interval_s: float = setting(
        1.0, 'longest time that what was written may stay in the cache of the operating system; '
        'what is lost when power fails [s]', 0.0, 3600.0)
    split_bytes: int = setting(
        0, 'size at which a bag goes on in a new file; 0: never [bytes]', 0, 2**50)
    split_duration_s: float = setting(
        0.0, 'time after which a bag goes on in a new file; 0: never [s]', 0.0, 1e9)
    free_space_mb: float = setting(
        100.0, 'nothing is recorded while less than this is free on the disk [MB]', 0.0, 1e9)
    waiting_mb: float = setting(
        64.0, 'messages kept in memory while they cannot be written; what comes then is lost and '
        'counted [MB]', 0.0, 100000.0)
