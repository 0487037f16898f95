# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The one error for files of other programs: what, where, what to do, in one line."""

from __future__ import annotations

import os

__all__ = ['ReaderError']


class ReaderError(ValueError):
    """A file of another program cannot be used; the message begins with its path."""

    def __init__(self, path: str | os.PathLike[str], problem: str) -> None:
        super().__init__(f'{os.fspath(path)}: {" ".join(problem.split())}')
