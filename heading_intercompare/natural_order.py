# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The order of numbered files: by the values of the numbers in their names."""

from __future__ import annotations

import os
import re

__all__ = ['natural_key']

_DIGITS = re.compile(r'(\d+)')


def natural_key(path: str | os.PathLike[str]) -> list[tuple[int, str]]:
    """
    Return a key that puts `gyro_9.log` before `gyro_10.log`.

    Examples
    --------
    >>> sorted(['part_10', 'part_9', 'part'], key=natural_key)
    ['part', 'part_9', 'part_10']

    """
    return [(int(part), '') if part.isdecimal() else (-1, part)
            for part in _DIGITS.split(os.fspath(path))]
