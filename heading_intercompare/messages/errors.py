# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The one error for messages: what is wrong with bytes, fields or definitions, in one line."""

from __future__ import annotations

from typing import Sequence

__all__ = ['MessageError']


class MessageError(ValueError):
    """
    A message, or the definition of its type, cannot be read or written.

    Parameters
    ----------
    problem : str
        What is wrong, and what is allowed.
    offset : int, optional
        First byte of the message in the data that holds it.
    offsets : sequence of int
        The same of all messages with this problem, if there are several.

    """

    def __init__(self, problem: str, offset: int | None = None,
                 offsets: Sequence[int] = ()) -> None:
        super().__init__(problem + ('' if offset is None else f' (at byte {offset})'))
        self.problem = problem
        self.offset = offset
        self.offsets = offsets
