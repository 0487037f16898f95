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

"""A running graph on standard error: lines that are drawn again on a terminal, text elsewhere."""

from __future__ import annotations

from contextlib import ExitStack
import re
import sys
import time

from heading_intercompare.web.bridge.bridge_view import BridgeView

from .keyboard import Keyboard
from .screen import can_draw, Screen
from .status_lines import StatusLines
from .view_lines import lay_out, one_line

_NUMBER = re.compile(r'\d[\d.,:]*')


class LiveView:
    """
    A context manager that shows views of a graph until it is left.

    Parameters
    ----------
    title
        What runs.
    foot
        What can be done, such as how to end it.
    quiet
        Show nothing.

    Notes
    -----
    On a terminal with rich the view is drawn again each time. Elsewhere a line of text is written
    every 10 s, and when something changes: a verdict, what speaks against the comparison, an
    alarm, a node.

    """

    def __init__(self, title: str, foot: str = '', quiet: bool = False) -> None:
        self._title, self._foot, self._quiet = title, foot, quiet
        self._screen = Screen() if not quiet and can_draw(sys.stderr) else None
        self._open = ExitStack()
        self._keyboard: Keyboard | None = None
        self._lines = StatusLines()

    def __enter__(self) -> 'LiveView':
        if self._screen is not None:
            self._open.enter_context(self._screen)
            # Typed letters would tear the view apart.
            self._keyboard = self._open.enter_context(Keyboard())
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def show(self, view: BridgeView, phase: str = '') -> None:
        """
        Show a view.

        Parameters
        ----------
        view
            What the graph tells by now.
        phase
            What the graph does at the moment if it does not just run.

        """
        if self._screen is not None:
            if self._keyboard is not None:
                self._keyboard.keys()
            columns, rows = self._screen.room()
            self._screen.draw(lay_out(view, columns, rows, title=self._title, phase=phase,
                                      foot=self._foot))
        elif not self._quiet and self._lines.is_due(_state_of(view, phase)):
            self._lines.write(one_line(view, time.time_ns(), phase))

    def tell(self, text: str) -> None:
        """Write a line that stays."""
        if self._screen is not None:
            self._screen.tell(text)
        elif not self._quiet:
            self._lines.write(text)


def _state_of(view: BridgeView, phase: str) -> tuple[object, ...]:
    """Return what a person wants to know at once when it changes."""
    return (phase, view.lamp.word, view.lamp.given_ns, _NUMBER.sub('#', view.validity.words),
            tuple((alarm.name, alarm.state) for alarm in view.alarms),
            tuple((node.name, node.level, node.stale) for node in view.nodes),
            view.ts.stale, view.rs.stale, view.run.number,
            None if view.sensors is None else (
                _NUMBER.sub('#', view.sensors.vote),
                tuple((row.now.stale, row.lamp.word) for row in view.sensors.rows)))
