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
        1.0, 'longest time that messages stay in memory while recording [s]', 0.0, 3600.0)
