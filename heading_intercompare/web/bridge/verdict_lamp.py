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

"""The state lamp: which verdict was given last, and where it was given."""

from __future__ import annotations

from typing import Sequence

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import HOLDS, NOT_TESTABLE
from heading_intercompare.messages.status_messages import Status

from .bridge_records import LampView, Tone
from .view_texts import coming_words, integer, shorten

_TONES = {Outcome.COMPLIANT: Tone.GOOD, Outcome.INDETERMINATE: Tone.DOUBT,
          Outcome.NON_COMPLIANT: Tone.BAD}
#: From the mildest to the gravest.
GRAVITY = (Tone.NONE, Tone.GOOD, Tone.DOUBT, Tone.BAD)


def light_lamp(statuses: Sequence[Status], stamp_ns: int, next_look_ns: int | None = None,
               ends_ns: int | None = None) -> LampView:
    """
    Return the lamp for the last message on `compliance/verdict`.

    Parameters
    ----------
    statuses
        Statuses of that message; none if no message has come.
    stamp_ns
        Stamp of that message, nanoseconds.
    next_look_ns, ends_ns
        When the next look is due, and when the clock ends the run.

    Returns
    -------
    LampView
        The graver one of the verdict on the judged runs and of the look at the run in progress.
        It is good only if nothing speaks against the comparison.

    """
    named = {status.name: status for status in statuses}
    lamps = [lamp for lamp in (_judge_look(named.get('run in progress'), stamp_ns),
                               _judge_runs(named, stamp_ns)) if lamp is not None]
    if not lamps:
        return LampView(what=coming_words(next_look_ns, ends_ns) or 'at the end of the run')
    return max(lamps, key=lambda lamp: GRAVITY.index(lamp.tone))


def _judge_look(look: Status | None, stamp_ns: int) -> LampView | None:
    if look is None:
        return None
    values = look.values
    return make_lamp(values.get('outcome', ''), values.get('validity_effect', ''), stamp_ns,
                 f"look {values.get('look', '?')} of {values.get('looks', '?')}",
                 values.get('headline') or look.message)


def _judge_runs(named: dict[str, Status], stamp_ns: int) -> LampView | None:
    whole = named.get('verdict')
    n = 0 if whole is None else integer(whole.values.get('runs')) or 0
    if whole is None or not n:
        return None
    last = named.get(f'run {n}')
    end_ns = None if last is None else integer(last.values.get('end_ns'))
    return make_lamp(whole.values.get('outcome', ''), whole.values.get('validity', ''),
                 stamp_ns if end_ns is None else end_ns,
                 'end of run 1' if n == 1 else f'end of run {n}, all {n} together', whole.message)


def make_lamp(outcome: str, validity: str, given_ns: int, what: str,
              headline: str) -> LampView:
    """Return the lamp for an outcome and its validity, as words of a message."""
    try:
        tone = _TONES[Outcome(outcome)]
    except ValueError:
        tone = Tone.DOUBT
    word = shorten(outcome, 20).replace('_', '-').upper() or 'UNKNOWN'
    if validity not in (HOLDS, NOT_TESTABLE):
        word = f'{word}, {shorten(validity, 20).upper()}'
        tone = Tone.DOUBT if tone is Tone.GOOD else tone
    return LampView(word, tone, given_ns, what, shorten(headline, 400))
