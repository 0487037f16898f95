# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of readers: which files can be read, and their headings by stream."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'errors': ('ReaderError',),
    'registry': ('find_format', 'FORMATS', 'open_recording'),
    'stream_recording': ('StreamRecording',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .errors import ReaderError as ReaderError
    from .registry import (
        find_format as find_format,
        FORMATS as FORMATS,
        open_recording as open_recording,
    )
    from .stream_recording import StreamRecording as StreamRecording
