# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""NMEA sentences and csv, from a network, serial line or file, to headings."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'logs': ('LogReader',),
    'nmea': ('NmeaDecoder',),
    'settings': ('DriverError', 'DriverSettings', 'SENTENCES'),
    'sources': ('FileSource', 'open_source', 'Source'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .logs import LogReader as LogReader
    from .nmea import NmeaDecoder as NmeaDecoder
    from .settings import (
        DriverError as DriverError,
        DriverSettings as DriverSettings,
        SENTENCES as SENTENCES,
    )
    from .sources import FileSource as FileSource, open_source as open_source, Source as Source
