# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Sentences of NMEA 0183 for tests: their checksum is right unless a test makes it wrong."""

from __future__ import annotations

from functools import reduce
from operator import xor

__all__ = ['checksum_of', 'with_checksum']


def checksum_of(body: str) -> int:
    """Return the checksum of what stands between ``$`` and ``*``."""
    return reduce(xor, body.encode(), 0)


def with_checksum(body: str) -> str:
    """Return a sentence without its line end, given what stands between ``$`` and ``*``."""
    return f'${body}*{checksum_of(body):02X}'
