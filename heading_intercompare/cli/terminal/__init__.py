# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The terminal: progress, keys, streams that may be closed."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'keyboard': ('Keyboard',),
    'progress': ('Progress',),
    'standard_streams': ('safe_stderr', 'safe_stdout'),
})
