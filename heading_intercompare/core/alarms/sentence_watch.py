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

"""What a driver counts says about its line: damaged sentences, a second talker or sender."""

from __future__ import annotations

from typing import Mapping, Sequence

from heading_intercompare.core.statistics.recent_count import RecentCount

from .alarm import Priority, Rule, Sign

SENTENCE_RULES = (
    Rule('checksum', Priority.CAUTION, 10.0), Rule('second_talker', Priority.WARNING, 10.0),
    Rule('second_sender', Priority.CAUTION, 10.0), Rule('burst', Priority.CAUTION, 10.0),
    Rule('dropped', Priority.CAUTION, 10.0))
"""The alarms of a driver."""

_SPAN_S = 10.0
# One damaged sentence now and then is usual on a serial line.
_FEWEST, _SHARE, _RARE = 5, 0.1, 0.01
_DAMAGED = ('bad_checksum', 'no_checksum', 'cut')
_TALKER = 'other_talker.'
#: Changes of the sender in the span: one that takes over, and a single stray reading, have two.
_CHANGES = 3
#: Lines with an old number in the span; a sender that restarts has eight.
_OLD = 9
#: Counts that only the alarms see.
SENDER_CHANGES, LATE_REPEATS = 'sender_changes', 'late_repeats'


class SentenceWatch:
    """
    Watches the counts of a decoder and of its source.

    Parameters
    ----------
    talker
        The talker that the user chose. Others are expected then.
    senders_expected
        The user takes the readings of several senders.

    """

    def __init__(self, talker: str | None, senders_expected: bool = False) -> None:
        self._talker, self._senders_expected = talker, senders_expected
        self._recent: dict[str, RecentCount] = {}

    def look(self, counts: Mapping[str, int], headings: int, now_s: float,
             senders: Sequence[str] = ()) -> dict[str, Sign]:
        """
        Return the signs at a time.

        Parameters
        ----------
        counts
            What gave no heading so far, by reason; and changes of the sender.
        headings
            Headings so far.
        now_s
            A steady clock, seconds; increases from call to call.
        senders
            The last two senders of readings.

        """
        damaged = self._grow('damaged', sum(counts.get(key, 0) for key in _DAMAGED), now_s)
        good = self._grow('headings', headings, now_s)
        others = {key[len(_TALKER):]: self._grow(key, n, now_s) for key, n in counts.items()
                  if key.startswith(_TALKER)}
        return {
            'checksum': _judge_checksum(damaged, good),
            'second_talker': self._judge_talkers({t: n for t, n in others.items() if n}),
            'second_sender': self._judge_senders(
                {key: self._grow(key, counts.get(key, 0), now_s)
                 for key in (SENDER_CHANGES, LATE_REPEATS, 'old_number')}, ' and '.join(senders)),
            'burst': _judge_count(self._grow('burst', counts.get('burst', 0), now_s),
                                  'readings came in a burst, without a time of receipt'),
            'dropped': _judge_count(
                self._grow('dropped', counts.get('kernel_dropped', 0), now_s),
                'datagrams were dropped by the kernel')}

    def _grow(self, key: str, total: int, now_s: float) -> int:
        return self._recent.setdefault(key, RecentCount(_SPAN_S)).take(total, now_s)

    def _judge_senders(self, figures: Mapping[str, int], names: str) -> Sign:
        changes, late, old = figures.values()
        if changes >= _CHANGES and not self._senders_expected:
            return Sign(True, f'the readings of one talker come from several senders: {names}; '
                        'take one with ?from=ADDRESS or instrument, or remove the other', figures)
        if late >= _FEWEST or old >= _OLD:
            return Sign(True, 'somebody sends old lines of the sensor a second time: their '
                        'numbers n: passed; the driver rejects them', figures)
        return Sign(None if changes or late or old else False)

    def _judge_talkers(self, others: Mapping[str, int]) -> Sign:
        n = sum(others.values())
        if self._talker is not None or not n:
            return Sign(False)
        names = ', '.join(sorted(others))
        return Sign(True if n >= 2 else None, f'another talker sends the same sentence: {names}; '
                    'set talker to the one to use', {'sentences': n})


def _judge_checksum(damaged: int, good: int) -> Sign:
    share = damaged / max(damaged + good, 1)
    figures = {'damaged': damaged, 'share': share}
    if damaged >= _FEWEST and share >= _SHARE:
        return Sign(True, f'{100.0 * share:.0f} % of the sentences of the last {_SPAN_S:.0f} s '
                    'are damaged: wrong or missing checksum', figures)
    return Sign(None if share > _RARE and damaged > 1 else False)


def _judge_count(n: int, words: str) -> Sign:
    return Sign(n > 0, f'{n} {words} in the last {_SPAN_S:.0f} s', {'count': n})
