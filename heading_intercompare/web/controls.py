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

"""What a person at the page can do, and where the page gets what it shows."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass, field
import time
from typing import Callable

from heading_intercompare.web.bridge.bridge_records import WaitingAction
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.view_texts import clock_with_seconds

DELAY_S = 60.0
"""For how long an action that begins or ends a run can be undone."""

RUN_ACTIONS = {'start': 'start run', 'stop': 'stop run'}
"""The actions that wait, in words."""


class Delay:
    """
    Keeps the action that can still be undone; there is at most one.

    One thread changes it; any thread may look at it.

    Parameters
    ----------
    clock_s
        A steady clock, seconds.

    Attributes
    ----------
    waiting : WaitingAction or None
        The action that waits.
    outcome : str
        How the action that waited last ended, in words; '' before the first.

    """

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        self.clock_s = clock_s
        self.waiting: WaitingAction | None = None
        self.outcome = ''

    def begin(self, what: str, operator: str) -> str:
        """Let an action wait unless one does; return the answer in words."""
        if self.waiting is not None:
            return (f'{RUN_ACTIONS[self.waiting.what]} waits already: undo it or do it now before '
                    'you ask for another action')
        due_ns = time.time_ns() + round(DELAY_S * 1e9)
        self.waiting = WaitingAction(what, operator, self.clock_s() + DELAY_S, due_ns)
        return (f'{RUN_ACTIONS[what]} waits until {clock_with_seconds(due_ns)}; '
                'it can be undone until then')

    def left_s(self, action: WaitingAction) -> float:
        """Return for how long an action still waits, seconds."""
        return max(0.0, action.due_s - self.clock_s())

    def take(self, what: str) -> WaitingAction | None:
        """Return the action that waits, which then no longer does; None if it is another."""
        action = self.waiting
        if action is None or action.what != what:
            return None
        self.waiting = None
        return action

    def take_due(self) -> WaitingAction | None:
        """Return the action whose time has come, which then no longer waits; None if none."""
        action = self.waiting
        return None if action is None or self.left_s(action) > 0.0 else self.take(action.what)


@dataclass(frozen=True, slots=True)
class Controls:
    """
    The graph as the page sees it; every function may be called from any thread.

    Attributes
    ----------
    look
        Returns the newest view, and its age in seconds.
    act
        ``act(what, text, operator)`` begins an action and returns a future with the answer.
        `what` is 'start', 'stop', 'undo' or 'now' (of the waiting action `text`), 'acknowledge'
        (of the alarm `text`, all if empty) or 'note' (`text`); `operator` is the name of the
        person, '' if it is not known.
    delay
        Where 'start' and 'stop' wait.

    """

    look: Callable[[], tuple[BridgeView, float]]
    act: Callable[[str, str, str], 'Future[str]']
    delay: Delay = field(default_factory=Delay)
