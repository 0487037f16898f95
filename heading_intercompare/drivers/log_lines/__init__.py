# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The lines of logs: their files, the forms of their stamps, and the words around sentences."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'line_formats': ('FORMATS', 'LineFormat'),
    'line_stamps': ('LineStamps',),
    'log_files': ('LogFiles',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .line_formats import FORMATS as FORMATS, LineFormat as LineFormat
    from .line_stamps import LineStamps as LineStamps
    from .log_files import LogFiles as LogFiles
