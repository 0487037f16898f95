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

"""Marks of a topic: each once, of the two kinds, not without end; and what one does, in words."""

from __future__ import annotations

from typing import Iterable

from heading_intercompare.core.runs.run_cutter import CutterState
from heading_intercompare.messages.status_messages import MARKS, WARN
from heading_intercompare.nodes.presence.health import Health

#: Marks that a node takes; a year of watches has 2200.
_MOST = 10_000


def explain_mark(kind: str, state: CutterState) -> str:
    """
    Return in words what a mark after the newest pair will do.

    Parameters
    ----------
    kind : {'start', 'stop'}
        Of the mark.
    state
        Of the cutter of runs, before the mark.

    """
    if kind == 'stop':
        return 'the run in progress ends here' if state.in_run else (
            'no run is in progress; none begins until the next start')
    if not state.marked:
        return ('a run begins with the next pair; what came before this first mark belongs to no '
                'run')
    if state.in_run:
        return 'the run in progress ends here, and another one begins with the next pair'
    return ('nothing changes: a run already begins with the next pair' if state.open else
            'a run begins with the next pair')


class MarkIntake:
    """
    Says which marks are new.

    Parameters
    ----------
    health
        Shows marks that are refused.
    taken
        Marks that have taken effect already, by kind and stamp.

    """

    def __init__(self, health: Health, taken: Iterable[tuple[str, int]] = ()) -> None:
        self._health = health
        self._taken = set(taken)
        self._refused = 0

    def take(self, kind: str, stamp_ns: int) -> bool:
        """Tell whether a mark is to take effect: a late subscriber gets all marks again."""
        if kind not in MARKS:
            self._health.note('marker', WARN, f'mark {kind[:40]!r} is neither start nor stop')
            return False
        if (kind, stamp_ns) in self._taken:
            return False
        if len(self._taken) >= _MOST:
            self._refused += 1
            self._health.note('marker', WARN, f'{self._refused} marks refused: a node takes '
                              f'{_MOST}', latch=True)
            return False
        self._taken.add((kind, stamp_ns))
        return True
