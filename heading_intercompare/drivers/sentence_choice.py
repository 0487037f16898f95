# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Which one kind of sentence a source is read from.

Of the kinds present, the first of THS, HDT, PASHR, PSXN,23, PUHAW,UVH, HDG, and of that kind the
talker heard first: two sensors on one line are never mixed. Present is a kind that was heard
undamaged, whatever it said: THS that calls itself invalid is not replaced by an HDT that cannot.
"""

from __future__ import annotations

import mmap
from os import PathLike
from typing import Iterable, Iterator

from .framing import Framer, MAX_SENTENCE
from .sentences import identify, may_lack_checksum, Name
from .settings import DriverSettings, SENTENCES

__all__ = ['accepts', 'best', 'heard_in']

_TOKENS = {'THS': b'THS,', 'HDT': b'HDT,', 'PASHR': b'PASHR,', 'PSXN,23': b'PSXN,23,',
           'PUHAW,UVH': b'PUHAW,UVH,', 'HDG': b'HDG,'}
_BLOCK = 1 << 16


def accepts(name: Name, settings: DriverSettings) -> bool:
    """Tell whether the settings leave this sentence to choose."""
    return (settings.sentence in ('auto', name.kind)
            and (settings.talker is None or not name.talker or settings.talker == name.talker))


def best(names: Iterable[Name]) -> Name:
    """Return the name to take of those heard, given in the order in which they were heard."""
    return min(names, key=lambda name: SENTENCES.index(name.kind))


def heard_in(path: str | PathLike, settings: DriverSettings) -> Name | None:
    """
    Return the sentence to take of a log, or None if it has none.

    The log is searched for each kind in turn; lines are read only where a kind may stand.

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
    """Yield the heading sentences of the log from each place on where the token stands."""
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
