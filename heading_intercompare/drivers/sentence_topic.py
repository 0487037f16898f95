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

"""The sentences of a topic to headings: message by message, as they came."""

from __future__ import annotations

from dataclasses import replace
from typing import Iterable

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings, Integers

from .nmea import NmeaDecoder
from .settings import DriverSettings, SENTENCES

#: What ends the sentence of a message, which mostly has no line end of its own.
_LINE_END = b'\r\n'


class SentenceTopic:
    """
    Turns the sentences of a topic into headings of one sensor.

    Each sentence has the stamp of its message, so the headings of a bag are those of the live
    topic, however the messages are cut into chunks. The sentence is chosen as on a live line: from
    what comes in the first `learn_s`, by the stamps.

    Parameters
    ----------
    settings
        Sentence, talker, time, checksum, `learn_s`; the source does not matter.

    Examples
    --------
    >>> topic = SentenceTopic(DriverSettings(sentence='HDT'))
    >>> topic.take([1_000], [b'$HEHDT,218.53,T*12']).heading_deg.tolist()
    [218.53]

    """

    def __init__(self, settings: DriverSettings) -> None:
        # What the source says of lines and their stamps does not hold for messages.
        self._decoder = NmeaDecoder(replace(settings, source=None, stamp_format='none'))

    def take(self, stamp_ns: Integers | Iterable[int], texts: Iterable[bytes]) -> Headings:
        """
        Take sentences in the order of their messages, and return the headings that they give.

        Parameters
        ----------
        stamp_ns
            Stamp of each message, nanoseconds.
        texts
            The text of each message: a sentence, or several.

        Returns
        -------
        Headings
            None while it listens; those held until the choice come with the first one after it.

        """
        return Headings.concatenate([
            self._decoder.feed(text + _LINE_END, int(ns)) for ns, text in zip(stamp_ns, texts)])

    def flush(self) -> Headings:
        """Return the last headings, at the end of the topic."""
        return self._decoder.flush()

    @property
    def sentence(self) -> str | None:
        """Return talker and kind in one word, HEHDT; None while it listens."""
        return None if self._decoder.chosen is None else str(self._decoder.chosen)

    @property
    def counts(self) -> dict[str, int]:
        """Return everything so far that gave no heading, by reason; see `NmeaDecoder.counts`."""
        return self._decoder.counts


def choose_by_name(name: str) -> DriverSettings:
    """
    Return the settings that choose a sentence by its name.

    Parameters
    ----------
    name
        Kind of the sentence, with or without its talker; '' for the first present.

    Raises
    ------
    SettingsError
        If there is no such sentence.

    Examples
    --------
    >>> [(rule.talker, rule.sentence) for rule in map(choose_by_name, ('HEHDT', 'THS', ''))]
    [('HE', 'HDT'), (None, 'THS'), (None, 'auto')]

    """
    if not name:
        return DriverSettings()
    for kind in SENTENCES:
        if name == kind or len(name) > 2 and name[2:] == kind:
            return DriverSettings(sentence=kind, talker=name.removesuffix(kind) or None)
    raise SettingsError(f'{name}: is no sentence with a heading; must be {", ".join(SENTENCES)}, '
                        'with or without a talker such as HE before it')
