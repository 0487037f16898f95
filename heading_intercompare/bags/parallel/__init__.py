# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Headings decoded minute by minute, by several processes."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'by_minute': ('Window',),
    'decode_workers': ('can_fork', 'decode_stretches', 'Task'),
    'decoding': ('Decoded', 'Decoder', 'Kind'),
    'prefetch': ('run_ahead',),
})
