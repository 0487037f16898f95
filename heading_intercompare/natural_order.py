# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The order of numbered files: by the values of the numbers in their names."""

from __future__ import annotations

import os
import re

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
