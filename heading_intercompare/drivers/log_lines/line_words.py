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

"""The words that a logger writes around a sentence, which name its instrument."""

from __future__ import annotations

from collections import Counter
import re

#: Texts around sentences that are told apart; counters in them would have no end.
_MOST_TEXTS = 1000
#: Instruments that are told apart; more are counters.
_MOST_INSTRUMENTS = 20
#: An instrument with less than this share of the headings is a damaged word.
_LEAST_SHARE = 0.05

_CHECKSUM = re.compile(rb'\*[0-9A-Fa-f]{2}')
_WORD = re.compile(rb'\d{1,3}(?:\.\d{1,3}){3}(?::\d+)?|[^\s,;:|<>()\[\]"\'=\\*$!]+')
_NAME = re.compile(rb'[A-Za-z]|\d{1,3}(?:\.\d{1,3}){3}')
_MARKS = (b'Z', b'UTC', b'GMT', b'T', b'AM', b'PM')


def words_of(text: bytes) -> tuple[bytes, ...]:
    """
    Return the words that may name an instrument: they begin with a letter, or are an address.

    Examples
    --------
    >>> words_of(b'NAV  GYRO 17 192.168.1.5:4001 ')
    (b'NAV', b'GYRO', b'192.168.1.5:4001')

    """
    return tuple(word for word in _WORD.findall(_CHECKSUM.sub(b' ', text))
                 if _NAME.match(word) and word not in _MARKS)


class InstrumentChoice:
    """
    Tells which lines are of the one instrument to read.

    Parameters
    ----------
    name
        A word of its lines, letters in either case. A line without words belongs to the
        instrument of the line before it.

    """

    def __init__(self, name: str) -> None:
        self._name = name.encode().lower()
        self._last = False

    def accepts(self, prefix: bytes, suffix: bytes) -> bool:
        """Tell whether a line is of the instrument, from the text around its sentence."""
        text = prefix + b' ' + suffix
        words = [word.lower() for word in _WORD.findall(text)]
        if self._name in words:
            self._last = True
        elif words_of(text):
            self._last = False
        return self._last


class WordCounts:
    """Counts of the texts around the headings of one kind and talker."""

    def __init__(self) -> None:
        self._counts: Counter[bytes] = Counter()

    def add(self, text: bytes) -> None:
        """Count the text around one sentence, without its stamp."""
        if text in self._counts or len(self._counts) < _MOST_TEXTS:
            self._counts[text] += 1

    def instruments(self) -> list[tuple[str, int]]:
        """
        Return the instruments that the words name, with their counts, if they are several.

        Returns
        -------
        list of (str, int)
            The word that tells each instrument from the others, and how many headings it has;
            empty if the words name no instrument or one, or change so often that they are
            counters.

        """
        by_words: Counter[tuple[bytes, ...]] = Counter()
        for text, n in self._counts.items():
            by_words[words_of(text)] += n
        by_words.pop((), None)
        total = sum(by_words.values())
        instruments = {words: n for words, n in by_words.items() if n >= _LEAST_SHARE * total}
        if not 2 <= len(instruments) <= _MOST_INSTRUMENTS or len(by_words) > 5 * len(instruments):
            return []
        shared = set.intersection(*(set(words) for words in instruments))
        return sorted((next((word for word in words if word not in shared), words[0]).decode(
            'ascii', 'replace'), n) for words, n in instruments.items())
