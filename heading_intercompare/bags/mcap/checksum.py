# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The checksum of chunks and attachments: CRC-32 as MCAP has it.

The implementation of isal is used where it is installed (``pip install '.[fast]'``): it is some
ten times as fast as that of zlib, which takes longer than decoding headings does.
"""

from __future__ import annotations

__all__ = ['crc32']

try:
    from isal.isal_zlib import crc32
except ImportError:
    from zlib import crc32
