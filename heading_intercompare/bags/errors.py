# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The one error for bags and csv files: what, where, what is allowed, in one line."""

from __future__ import annotations

import os

__all__ = ['BagError']


class BagError(ValueError):
    """
    A bag, a message in it, or a csv file of pairs cannot be used.

    Parameters
    ----------
    problem : str
        What is wrong, and what is allowed.
    path : str or path, optional
        The file.
    offset : int, optional
        Byte of the file at which the problem begins.

    """

    def __init__(self, problem: str, path: str | os.PathLike[str] = '',
                 offset: int | None = None) -> None:
        place = f'{os.fspath(path)}: ' if os.fspath(path) else ''
        suffix = '' if offset is None else f' (at byte {offset})'
        super().__init__(f'{place}{problem}{suffix}')
        self.problem = problem
        self.path = os.fspath(path)
        self.offset = offset

    def locate(self, path: str | os.PathLike[str], offset: int | None = None) -> 'BagError':
        """Return the same error with a path and an offset."""
        return BagError(self.problem, path, offset)
