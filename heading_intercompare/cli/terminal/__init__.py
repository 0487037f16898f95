# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The terminal: progress, keys, and streams that may be closed."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'keyboard': ('Keyboard',),
    'progress': ('Progress',),
    'standard_streams': ('safe_stderr', 'safe_stdout'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .keyboard import Keyboard as Keyboard
    from .progress import Progress as Progress
    from .standard_streams import safe_stderr as safe_stderr, safe_stdout as safe_stdout
