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

"""
The choice of the one kind of sentence to read from a source.

It is the first kind present in the order of `PARSERS`, and of that kind the talker heard first. So
two sensors on one line are never mixed. A kind is present if one intact sentence was heard,
whatever it said: a THS that calls itself invalid is not replaced by an HDT, which has no way to
say so.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import chain
from typing import Callable, Iterable, Iterator, Sequence

from heading_intercompare.core.records import ColumnBuffer

from .framing import Framer
from .log_lines.line_words import InstrumentChoice
from .sentences import identify, may_lack_checksum, Name
from .settings import DriverSettings, SENTENCES

#: A receiver of GNSS names itself after the systems that it uses, and changes its name with them.
_GNSS_TALKERS = frozenset(('GN', 'GP', 'GL', 'GA', 'GB', 'BD', 'GQ', 'QZ', 'GI'))
#: Sentences of a turn of a talker, at least; those of two receivers alternate one by one.
_LEAST_TURN = 3

#: Bytes framed at once; of the first line that may hold a heading no more than that line.
_BLOCK = 1 << 16


def accepts(name: Name, settings: DriverSettings) -> bool:
    """Tell whether the settings allow this sentence."""
    return (settings.kind in ('auto', name.kind)
            and (settings.talker is None or not name.talker or settings.talker == name.talker))


def choose_naming(settings: DriverSettings) -> Callable[[bytes], Name | None]:
    """
    Return what names a heading sentence; a name lacks its talker if it is one of several to read.

    Parameters
    ----------
    settings
        A sentence that the user describes, and the talkers to read as one: several with commas
        between, or 'any'; another one joins none.

    Examples
    --------
    >>> [choose_naming(DriverSettings(talker=talker))(b'GNHDT,1.0,T')
    ...  for talker in ('GN', 'GP,GN')]
    [Name(kind='HDT', talker='GN'), Name(kind='HDT', talker='')]

    """
    talker, own_sentence = settings.talker, settings.described_sentence
    name_alone = identify if own_sentence is None else own_sentence.identify
    if talker is None or talker != 'any' and ',' not in talker:
        return name_alone
    talkers = talker.split(',')

    def name_together(text: bytes) -> Name | None:
        name = name_alone(text)
        return (Name(name.kind, '') if name and (talker == 'any' or name.talker in talkers)
                else name)
    return name_together


class TalkerTurns:
    """
    Tells which talkers of GNSS take turns with the one chosen, as those of one receiver do.

    A talker takes turns if it sends three sentences or more before the chosen one sends again, and
    so does the chosen one, on average.
    """

    def __init__(self) -> None:
        self._n: Counter[str] = Counter()
        self._n_turns: Counter[str] = Counter()
        self._after: dict[str, int] = {}

    def hear(self, name: Name, chosen: Name | None, n_chosen: int) -> None:
        """Take note of a sentence that is not the chosen one, after `n_chosen` of that."""
        talker = name.talker
        if chosen is None or name.kind != chosen.kind or not {
                talker, chosen.talker} <= _GNSS_TALKERS:
            return
        self._n[talker] += 1
        self._n_turns[talker] += self._after.get(talker) != n_chosen
        self._after[talker] = n_chosen

    def find(self, n_chosen: int) -> list[str]:
        """Return these talkers, given how many sentences the chosen one has sent."""
        return [talker for talker, n in self._n.items()
                if min(n, n_chosen) >= _LEAST_TURN * self._n_turns[talker]]


def choose_sentence(names: Iterable[Name], kinds: Sequence[str] = SENTENCES) -> Name:
    """
    Return the sentence to use of those heard, given in the order in which they were heard.

    Of two kinds, that which is earlier in `kinds` is better.
    """
    return min(names, key=lambda name: kinds.index(name.kind))


@dataclass(slots=True)
class Heard:
    """
    What was heard of one sentence.

    Attributes
    ----------
    rows
        Its readings.
    n
        Number of sentences, also without a reading.
    counts
        Sentences without a reading, by reason.

    """

    rows: ColumnBuffer
    n: int = 0
    counts: Counter[str] = field(default_factory=Counter)


class Listening:
    """
    Holds the readings of all sentences that tell one thing, until it chooses the best sentence.

    Parameters
    ----------
    kinds
        The kinds of sentences, the best first.
    learn_s
        How long to listen after the first sentence, seconds of receipt time.
    most
        Sentences held at most; a flood does not wait for the end of `learn_s`.
    chosen
        The sentence to use, if it is chosen already.
    width
        Columns of a reading.

    Attributes
    ----------
    chosen
        The sentence whose readings are used; None while it listens.
    rows : ColumnBuffer
        The readings of that sentence.
    held
        All that was heard of the sentences to choose from.

    """

    def __init__(self, kinds: Sequence[str], learn_s: float, most: float,
                 chosen: Name | None = None, width: int = 1) -> None:
        self._kinds, self._learn_ns, self._most = kinds, learn_s * 1e9, most
        self._width = width
        self._since_ns: int | None = None
        self.chosen, self.rows = chosen, ColumnBuffer(width)
        self.held: dict[Name, Heard] = {}

    def hear(self, name: Name) -> Heard:
        """Count a sentence, and return what was heard of this name before the choice."""
        heard = self.held.get(name)
        if heard is None:
            heard = self.held[name] = Heard(ColumnBuffer(self._width))
        heard.n += 1
        return heard

    @property
    def n_held(self) -> int:
        """Return the number of sentences held."""
        return sum(heard.n for heard in self.held.values())

    def learn(self, now_ns: int | None) -> dict[Name, Heard]:
        """Choose a sentence if the time to listen is over; return as `choose` does."""
        if not self.held:
            return {}
        if now_ns is not None:
            self._since_ns = now_ns if self._since_ns is None else min(self._since_ns, now_ns)
            if now_ns - self._since_ns >= self._learn_ns:
                return self.choose()
        return self.choose() if self.n_held > self._most else {}

    def choose(self) -> dict[Name, Heard]:
        """Choose the best sentence held, if any; return all that were held."""
        heard, self.held = self.held, {}
        if heard:
            self.chosen = choose_sentence(heard, self._kinds)
            self.rows = heard[self.chosen].rows
        return heard


def find_sentence(blocks: Iterable[bytes], settings: DriverSettings) -> Name | None:
    """
    Return the sentence to use from a log, or None if it has none.

    It reads the log once, and frames only the lines where a kind may stand that is better than
    the best found so far.

    Parameters
    ----------
    blocks
        The log, cut anywhere.
    settings
        Sentence, talker, instrument, checksum.

    """
    kinds = [kind for kind in settings.kinds if settings.kind in ('auto', kind)]
    tokens = {kind: f'{kind},'.encode() for kind in kinds}
    choice, naming = choose_instrument(settings), choose_naming(settings)
    best, tail, span = None, b'', 0
    for block in chain(blocks, (b'\n',)):
        text = tail + block
        end = text.rfind(b'\n') + 1
        if not end and len(text) < _BLOCK:
            tail = text
            continue
        text, tail = (text[:end], text[end:]) if end else (text, b'')
        at = 0
        places = dict.fromkeys(kinds, -1)
        while at < len(text):
            if choice is None:
                for kind in kinds:
                    if places[kind] < at:
                        place = text.find(tokens[kind], at)
                        places[kind] = len(text) if place < 0 else place
                at = min(places[kind] for kind in kinds)
                if at == len(text):
                    break
            begin = text.rfind(b'\n', 0, at) + 1
            at = text.find(b'\n', at + span) + 1 or len(text)
            span = _BLOCK
            for name in _names(text[begin:at], settings, choice, naming):
                if name.kind in kinds and accepts(name, settings):
                    best = name
                    kinds = kinds[:kinds.index(name.kind)]
            if not kinds:
                return best
    return best


def choose_instrument(settings: DriverSettings) -> InstrumentChoice | None:
    """Return what tells the lines of one instrument; None if all lines are taken."""
    if settings.instrument in (None, 'any'):
        return None
    return InstrumentChoice(str(settings.instrument))


def _names(text: bytes, settings: DriverSettings, choice: InstrumentChoice | None,
           identify_sentence: Callable[[bytes], Name | None]) -> Iterator[Name]:
    """Yield the heading sentences of whole lines, in the order of the log."""
    lenient, own_sentence = settings.checksum == 'if_present', settings.described_sentence
    framer = Framer(with_lines=choice is not None)
    for _, prefix, sentence, checked, suffix in framer.feed(text, None) + framer.flush():
        if choice is not None and not choice.accepts(prefix, suffix):
            continue
        name = identify_sentence(sentence)
        if name is not None and (checked or lenient or may_lack_checksum(name, own_sentence)):
            yield name
