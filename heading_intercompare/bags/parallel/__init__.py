# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Decoding of headings minute by minute, in several processes."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'by_minute': ('Window',),
    'decode_workers': ('can_fork', 'decode_stretches', 'Task'),
    'decoding': ('Decoded', 'Decoder', 'Kind'),
    'prefetch': ('run_ahead',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .by_minute import Window as Window
    from .decode_workers import (
        can_fork as can_fork,
        decode_stretches as decode_stretches,
        Task as Task,
    )
    from .decoding import Decoded as Decoded, Decoder as Decoder, Kind as Kind
    from .prefetch import run_ahead as run_ahead
