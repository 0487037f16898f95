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

"""The rows of a table that a setting holds as one text."""

from __future__ import annotations

import re


def split_rows(text: str | None) -> list[str]:
    r"""
    Return the rows of a text, separated by line ends or ``;``, without empty ones.

    Examples
    --------
    >>> split_rows('a 1; b 2\n\n c 3 ;')
    ['a 1', 'b 2', 'c 3']

    """
    return [row for row in map(str.strip, re.split(r'[;\r\n]', text or '')) if row]
