# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bytes of NMEA sentences and csv, from wherever, to headings."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'logs': ('LogReader',),
    'nmea': ('NmeaDecoder',),
    'settings': ('DriverError', 'DriverSettings', 'SENTENCES'),
    'sources': ('FileSource', 'open_source', 'Source'),
})
