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

"""The motion of the ship as text and back, to the bit, for the account beside a csv of pairs."""

from __future__ import annotations

from base64 import b64decode, b64encode
import binascii
from typing import Mapping

import numpy as np

from heading_intercompare.core.records import Integers, Motion, MOTION_COLUMNS, Reals

__all__ = ['motion_of_text', 'text_of_motion']

#: The word of the account for what rows tell.
_WORDS = {'fix': 'position', 'velocity': 'velocity', 'rate': 'rate'}


def text_of_motion(motion: Motion) -> dict[str, str] | None:
    """
    Return the motion as text; None if there is none.

    Parameters
    ----------
    motion : Motion
        In any order.

    Returns
    -------
    dict of str to str, or None
        Base64 of the columns, each little-endian and whole: the stamps as int64, then the reals
        as float64; by what the rows tell: 'position', 'velocity', 'rate'.

    """
    texts = {}
    for what, rows in motion.split().items():
        if len(rows):
            columns: list[Integers | Reals] = [rows.stamp_ns.astype('<i8')]
            columns += [getattr(rows, name).astype('<f8') for name in MOTION_COLUMNS[what]]
            texts[_WORDS[what]] = b64encode(
                b''.join(column.tobytes() for column in columns)).decode('ascii')
    return texts or None


def motion_of_text(text: Mapping[str, str] | None) -> Motion:
    """
    Return the motion in a text of `text_of_motion`.

    Raises
    ------
    ValueError
        If the text is not one.

    """
    chunks = []
    things = {word: what for what, word in _WORDS.items()}
    for word, columns in (text or {}).items():
        what = things.get(word, '')
        names = MOTION_COLUMNS.get(what)
        try:
            data = b64decode(columns, validate=True)
        except binascii.Error as error:
            raise ValueError(f'motion.{word} is no base64: {error}') from None
        if names is None or len(data) % (8 * (1 + len(names))):
            raise ValueError(f'motion.{word} has {len(data)} bytes: must be whole rows')
        size = len(data) // (1 + len(names))
        stamps = np.frombuffer(data[:size], '<i8').astype(np.int64)
        reals = [np.frombuffer(data[at:at + size], '<f8').astype(np.float64)
                 for at in range(size, len(data), size)] if size else [np.zeros(0)] * len(names)
        chunks.append(Motion.of(what, stamps, *reals))
    return Motion.concatenate(chunks)
