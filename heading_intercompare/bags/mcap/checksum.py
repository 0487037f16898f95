# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The checksum of chunks and attachments: CRC-32 as in MCAP.

isal computes it where it is installed (``pip install '.[fast]'``), about ten times as fast as
zlib. With zlib it takes longer than decoding the headings.
"""

from __future__ import annotations

__all__ = ['crc32']

try:
    from isal.isal_zlib import crc32
except ImportError:
    from zlib import crc32
