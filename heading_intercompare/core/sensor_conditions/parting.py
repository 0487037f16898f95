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

"""The condition that the sensors do not point far apart for a part of the run."""

from __future__ import annotations

from heading_intercompare.core.conditions.partings import cut_spans, Parting
from heading_intercompare.core.utc_text import utc_span
from heading_intercompare.core.validity.condition import Condition, DOUBTFUL, Finding, HOLDS
from heading_intercompare.core.validity.examined import Examined

_MOST_NAMED = 3


def _describe(parting: Parting) -> str:
    return (f'the sensors part by {abs(parting.size_deg):.1f} deg '
            f'{utc_span(parting.start_ns, parting.end_ns)}')


def _judge(e: Examined) -> Finding:
    c, partings = e.columns, e.columns.partings
    if not partings:
        return PARTING.find(HOLDS, '', 'the sensors nowhere point far apart for a minute')
    spans_ns = [(parting.start_ns, parting.end_ns) for parting in partings]
    rest = e.decide(*cut_spans(c.stamp_ns, c.x_deg, spans_ns))
    evidence = ', '.join(map(_describe, partings[:_MOST_NAMED]))
    if len(partings) > _MOST_NAMED:
        evidence += f', and {len(partings) - _MOST_NAMED} times more'
    if rest is e.outcome:
        return PARTING.find(HOLDS, '', f'{evidence}; the outcome is the same without that')
    largest = max(partings, key=lambda parting: parting.lasted_s)
    return PARTING.find(DOUBTFUL, f'{_describe(largest)}, without that {rest.words}',
                        f'{evidence}; without that the outcome is {rest.words}')


PARTING = Condition(
    name='parting',
    holds='the sensors do not point far apart for a part of the run',
    doubtful_when='the sensors point apart by more than ten times what both norms explain, for a '
                  'minute or longer and less than half of the run, and without that the outcome '
                  'would differ: the headline says by how much and from when to when',
    judge=_judge, watched_by=('jump',))
