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

"""TAG blocks before a sentence: `s:` names its source, `c:` tells a time, `n:` numbers lines."""

from __future__ import annotations

from functools import reduce
from operator import xor
import re
from typing import Iterator

_TAG = re.compile(rb'\\([^\\*]*)\*([0-9A-Fa-f]{2})\\')


def tag_blocks(prefix: bytes) -> Iterator[list[bytes]]:
    r"""
    Yield the fields of each TAG block with a correct checksum, of the last block first.

    Examples
    --------
    >>> [*tag_blocks(b'\\s:HE0001,n:7*0A\\\\s:II0001*00\\')]
    [[b's:HE0001', b'n:7']]

    """
    for text, checksum in reversed(_TAG.findall(prefix)):
        if reduce(xor, text, 0) == int(checksum, 16):
            yield text.split(b',')
