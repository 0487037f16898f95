# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The choice of the one kind of sentence to read from a source.

It is the first kind present of THS, HDT, PASHR, PSXN,23, PUHAW,UVH, HDG, and of that kind the
talker heard first. So two sensors on one line are never mixed. A kind is present if one intact
sentence was heard, whatever it said: a THS that calls itself invalid is not replaced by an HDT,
which has no way to say so.
"""

from __future__ import annotations

import mmap
from os import PathLike
from typing import Iterable, Iterator

from .framing import Framer, MAX_SENTENCE
from .sentences import identify, may_lack_checksum, Name
from .settings import DriverSettings, SENTENCES

__all__ = ['accepts', 'choose_sentence', 'find_sentence']

_TOKENS = {'THS': b'THS,', 'HDT': b'HDT,', 'PASHR': b'PASHR,', 'PSXN,23': b'PSXN,23,',
           'PUHAW,UVH': b'PUHAW,UVH,', 'HDG': b'HDG,'}
_BLOCK = 1 << 16


def accepts(name: Name, settings: DriverSettings) -> bool:
    """Tell whether the settings allow this sentence."""
    return (settings.sentence in ('auto', name.kind)
            and (settings.talker is None or not name.talker or settings.talker == name.talker))


def choose_sentence(names: Iterable[Name]) -> Name:
    """Return the sentence to use of those heard, given in the order in which they were heard."""
    return min(names, key=lambda name: SENTENCES.index(name.kind))


def find_sentence(path: str | PathLike, settings: DriverSettings) -> Name | None:
    """
    Return the sentence to use from a log, or None if it has none.

    It searches the log for each kind in turn, and reads only the lines where a kind may stand.

    Raises
    ------
    OSError
        If the log cannot be read.

    """
    with open(path, 'rb') as file:
        if file.seek(0, 2) == 0:
            return None
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as log:
            for kind, token in _TOKENS.items():
                if settings.sentence in ('auto', kind):
                    for name in _names(log, token, settings.checksum == 'if_present'):
                        if name.kind == kind and accepts(name, settings):
                            return name
    return None


def _names(log: mmap.mmap, token: bytes, lenient: bool) -> Iterator[Name]:
    """Yield the heading sentences of the log around each place of the token."""
    at = log.find(token)
    while at >= 0:
        start = max(at - MAX_SENTENCE, log.rfind(b'\n', max(0, at - MAX_SENTENCE), at) + 1, 0)
        end = log.find(b'\n', at + _BLOCK) + 1 or len(log)
        framer = Framer()
        for _, _, text, checked in framer.feed(log[start:end], None) + framer.flush():
            name = identify(text)
            if name is not None and (checked or lenient or may_lack_checksum(name)):
                yield name
        at = log.find(token, end)
