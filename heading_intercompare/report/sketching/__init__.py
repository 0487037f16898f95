# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Summaries of a series in bounded memory: bins, turning, shifts, spectra, tracks, traces."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bins': ('Bins', 'Envelope', 'Histogram'),
    'shift_scan': ('ShiftScan',),
    'spectra': ('Spectra',),
    'trace': ('Trace',),
    'track': ('Track',),
    'turning': ('Turning',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bins import Bins as Bins, Envelope as Envelope, Histogram as Histogram
    from .shift_scan import ShiftScan as ShiftScan
    from .spectra import Spectra as Spectra
    from .trace import Trace as Trace
    from .track import Track as Track
    from .turning import Turning as Turning
