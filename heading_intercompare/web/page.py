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

"""The live page, built for one browser: it asks for the newest view five times a second."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

from nicegui import ui

from heading_intercompare.web.bridge.view_texts import (
    alarm_words,
    node_words,
    Said,
    sensor_words,
    tell,
    vote_words,
)

from .controls import Controls
from .guard import check_token
from .palettes import draw_trend, PALETTES, style

_PERIOD_S = 0.2
#: A view older than this is not live, though the page is.
_OLD_S = 2.0
_PATIENCE_S = 10.0
#: What a wrong token costs.
_WRONG_S = 1.0

_HEAD = """<script>
(() => {
  const root = document.documentElement;
  let kept = null;
  try { kept = localStorage.getItem('palette'); } catch (error) { kept = null; }
  root.dataset.palette = kept || 'day';
  window.choosePalette = name => {
    root.dataset.palette = name;
    try { localStorage.setItem('palette', name); } catch (error) { return; }
  };
  let beat = '', at = performance.now();
  setInterval(() => {
    const mark = document.querySelector('.k-beat');
    const age = document.getElementById('page-age');
    if (!mark || !age) return;
    if (mark.textContent !== beat) { beat = mark.textContent; at = performance.now(); }
    const seconds = (performance.now() - at) / 1000;
    age.textContent = 'page ' + seconds.toFixed(1) + ' s old';
    document.getElementById('page-dead-s').textContent = seconds.toFixed(0);
    root.dataset.dead = seconds > 2 ? 'yes' : 'no';
  }, 200);
})();
</script>"""
_BODY = ('<div id="page-age"></div><div id="page-dead">✖ NOT LIVE: nothing has come for '
         '<span id="page-dead-s"></span> s</div>')


class _Page:
    """The elements of the page of one browser."""

    def __init__(self, controls: Controls, token: str | None) -> None:
        self._controls, self._token = controls, token
        self._labels: dict[str, Any] = {}
        self._shown: dict[str, Said] = {}
        self._alarms: list[tuple[str, Said]] | None = None
        self._nodes: list[Said] | None = None
        self._sensors: tuple[list[tuple[str, Said]], Said] | None = None
        self._trend: Any = None
        self._ticks = 0

    def build(self) -> None:
        """Make the elements, and begin to update them."""
        ui.add_head_html(f'<style>{style()}</style>{_HEAD}')
        ui.add_body_html(_BODY)
        with self._box('bridge'):
            several = self._controls.look()[0].sensors is not None
            if several:
                self._build_sensors()
            for name, title in () if several else (('ts', 'TS, tested sensor'), ('', 'TS - RS'),
                                ('rs', 'RS, reference sensor')):
                with self._box('panel heading'):
                    self._title(title)
                    self._label(f'{name}_heading' if name else 'difference', 'big')
                    self._label(f'{name}_state' if name else 'difference_state', 'row')
            self._lamp = self._box('panel wide box-none')
            with self._lamp:
                self._title('Verdict')
                for key, size in (('lamp', 'lamp'), ('lamp_given', 'row'),
                                  ('lamp_headline', 'small'), ('validity', 'row')):
                    self._label(key, size)
            if several:
                with self._box('panel narrow'):
                    for key in ('mode', 'bag', 'graph'):
                        self._label(key, 'row')
            else:
                self._build_pair()
            self._build_controls()
            with self._box('panel wide'):
                self._title('Alarms')
                self._alarm_rows = self._box('k-alarms')
            with self._box('panel narrow'):
                self._title('Nodes')
                self._node_rows = self._box('k-nodes')
        self._beat = ui.label('').classes('k-beat').style('display: none')
        self.update()
        ui.timer(_PERIOD_S, self.update)

    def _build_sensors(self) -> None:
        with self._box('panel all'):
            self._title('Sensors; figures of the window, and the last outcome')
            self._sensor_rows = self._box('k-sensors')
            self._vote = ui.label('').classes('mid k-vote')

    def _build_pair(self) -> None:
        with self._box('panel narrow'):
            self._title('Still missing')
            for key, size in (('lacking', 'mid'), ('run', 'row'), ('turn', 'row'),
                              ('mode', 'row')):
                self._label(key, size)
        with self._box('panel wide'):
            self._title('TS - RS of the last 30 min; dashed: limit of a single difference')
            self._label('trend', 'small')
            self._trend = ui.html('', sanitize=False).style('width: 100%')
        with self._box('panel narrow'):
            self._title('Window')
            for key, size in (('window', 'mid'), ('norm', 'row'), ('paired', 'row'),
                              ('ledger', 'small'), ('bag', 'row'), ('graph', 'small')):
                self._label(key, size)

    def _build_controls(self) -> None:
        with self._box('panel all'), self._box('bar'):
            for what, text in (('start', 'Start run'), ('stop', 'Stop run'),
                               ('acknowledge', 'Acknowledge all')):
                self._button(text, partial(self._act, what, ''), f'k-{what}')
            self._note = ui.input('Note').classes('k-note')
            self._button('Keep note', self._keep_note, 'k-keep')
            self._token_input = None
            if self._token is not None:
                self._token_input = ui.input('Token', password=True).classes('k-token')
            for name in PALETTES:
                button = self._button(name.capitalize(), None, f'k-{name}')
                button.on('click', js_handler=f'() => window.choosePalette("{name}")')
            self._answer = ui.label('').classes('row k-answer')

    @staticmethod
    def _box(classes: str) -> Any:
        return ui.element('div').classes(classes)

    @staticmethod
    def _title(text: str) -> None:
        ui.label(text).classes('title')

    def _label(self, key: str, size: str) -> None:
        self._labels[key] = ui.label('').classes(f'{size} k-{key}')

    @staticmethod
    def _button(text: str, act: Any, classes: str) -> Any:
        return ui.button(text, on_click=act, color=None).props('no-caps unelevated').classes(
            classes)

    def update(self) -> None:
        """Show the newest view; what has not changed is not sent."""
        view, age_s = self._controls.look()
        self._ticks += 1
        # The beat stands still with the view, so the browser sees that the page is not live.
        if age_s < _OLD_S:
            self._beat.set_text(str(self._ticks))
        for key, phrase in tell(view).items():
            if key in self._labels and self._shown.get(key) != phrase:
                self._tone(self._labels[key], phrase)
                self._shown[key] = phrase
        self._lamp.classes(remove='box-none box-good box-doubt box-bad',
                           add=f'box-{view.lamp.tone}')
        if self._trend is not None and self._ticks % 5 == 1:
            self._trend.set_content(draw_trend(view.trend))
        self._show_sensors(sensor_words(view), vote_words(view))
        self._show_alarms(alarm_words(view))
        self._show_nodes(node_words(view))

    @staticmethod
    def _tone(label: Any, phrase: Said) -> None:
        label.set_text(phrase.text)
        label.classes(remove='none good doubt bad', add=phrase.tone.value)

    def _show_sensors(self, sensors: list[tuple[str, Said]], vote: Said) -> None:
        if not sensors or (sensors, vote) == self._sensors:
            return
        self._tone(self._vote, vote)
        self._sensors = sensors, vote
        self._sensor_rows.clear()
        with self._sensor_rows:
            for name, phrase in sensors:
                with self._box('bar'):
                    ui.label(name).classes('mid k-sensor')
                    self._tone(ui.label().classes('row'), phrase)

    def _show_alarms(self, alarms: list[tuple[str, Said]]) -> None:
        if alarms == self._alarms:
            return
        self._alarms = alarms
        self._alarm_rows.clear()
        with self._alarm_rows:
            for name, phrase in alarms:
                with self._box('bar'):
                    self._tone(ui.label().classes('row k-alarm'), phrase)
                    if name:
                        self._button('Acknowledge', partial(self._act, 'acknowledge', name),
                                     'k-acknowledge-one')
            if not alarms:
                ui.label('no alarm').classes('row')

    def _show_nodes(self, nodes: list[Said]) -> None:
        if nodes == self._nodes:
            return
        self._nodes = nodes
        self._node_rows.clear()
        with self._node_rows:
            for phrase in nodes:
                self._tone(ui.label().classes('row'), phrase)
            if not nodes:
                ui.label('no node is heard').classes('row')

    async def _keep_note(self) -> None:
        text = (self._note.value or '').strip()
        if not text:
            self._answer.set_text('the note is empty')
        elif await self._act('note', text):
            self._note.set_value('')

    async def _act(self, what: str, text: str) -> bool:
        """Do an action, if the token is right, and show the answer; tell whether it was done."""
        token = '' if self._token_input is None else self._token_input.value or ''
        if not check_token(token, self._token):
            await asyncio.sleep(_WRONG_S)
            self._answer.set_text('refused: the token is wrong; the program printed it at its '
                                  'start')
            return False
        try:
            answer = await asyncio.wait_for(
                asyncio.wrap_future(self._controls.act(what, text)), _PATIENCE_S)
        except asyncio.TimeoutError:
            self._answer.set_text(f'no answer in {_PATIENCE_S:g} s: is the graph running?')
            return False
        self._answer.set_text(answer)
        return True


def build(controls: Controls, token: str | None) -> None:
    """Build the page for one browser; with a token, actions need it."""
    _Page(controls, token).build()
