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

"""The live page, built for one browser: it asks for the newest view up to five times a second."""

from __future__ import annotations

import asyncio
from functools import partial
from html import escape
import time
from typing import Any, Callable, Sequence, TypeVar

from nicegui import Client, ui

from heading_intercompare.core.count_words import count_words
from heading_intercompare.web.bridge.bridge_records import (
    AlertView,
    JudgedDayView,
    JudgedRunView,
    JudgedTestView,
    Tone,
)
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.judged_runs import group_by_day
from heading_intercompare.web.bridge.sensors_panel import SensorRow
from heading_intercompare.web.bridge.view_texts import (
    alert_words,
    big_difference,
    clock,
    compass_words,
    mark_words,
    node_words,
    Said,
    sensor_words,
    stamp_words,
    tell,
    tile_state,
    vote_words,
    waiting_words,
)
from heading_intercompare.web.drawing.compass_strip import draw_strip
from heading_intercompare.web.drawing.gauge import draw_gauge
from heading_intercompare.web.drawing.markers import draw_marker, draw_symbol
from heading_intercompare.web.drawing.trend_picture import draw_trend, Stretch
from heading_intercompare.web.figures.difference_watch import SPANS_S

from .connections import network_of
from .controls import Controls
from .palettes import PALETTES, script, style
from .tokens import find_operator, NamedToken

_Drawn = TypeVar('_Drawn')
_PERIOD_S = 0.2
#: Updates of all pages together.
_MOST_UPDATES_HZ = 250.0
MOST_PAGES = 256
"""Pages in all, whose browsers are connected or may come back."""

#: How long a page is held whose browser never opened a WebSocket.
_UNSEEN_S = 10.0
#: A view older than this is not live, though the page is.
_OLD_S = 2.0
_PATIENCE_S = 10.0
#: What a wrong token costs.
_WRONG_S = 1.0
#: How long a first tap on a button that ends or begins a run waits for the second.
_SURE_S = 10.0
_SPANS = {'30 min': SPANS_S[0], '6 h': SPANS_S[1], '24 h': SPANS_S[2]}
_NO_REFERENCE = ('silent', 'frozen')


class Drawings:
    """What was drawn of the newest view: it is drawn once for all browsers."""

    def __init__(self) -> None:
        self._view: BridgeView | None = None
        self._drawn: dict[object, Any] = {}

    def draw(self, view: BridgeView, key: object, make: Callable[[], _Drawn]) -> _Drawn:
        """Return what `make` returned for this view and key, or returns now."""
        if view is not self._view:
            self._view, self._drawn = view, {}
        if key not in self._drawn:
            self._drawn[key] = make()
        drawn: _Drawn = self._drawn[key]
        return drawn


def update_period_s(pages: int) -> float:
    """
    Return the time from one update of a page to the next, seconds.

    Where there are many pages, each is updated less often, so that they leave the processor to
    those who pair, judge and record.

    Examples
    --------
    >>> [round(update_period_s(pages), 2) for pages in (1, 50, 200, MOST_PAGES)]
    [0.2, 0.2, 0.8, 1.02]

    """
    return max(_PERIOD_S, pages / _MOST_UPDATES_HZ)


class _Page:
    """The elements of the page of one browser."""

    def __init__(self, controls: Controls, tokens: Sequence[NamedToken],
                 drawings: Drawings) -> None:
        self._controls, self._tokens, self._drawings = controls, tokens, drawings
        self._labels: dict[str, Any] = {}
        self._shown: dict[str, Any] = {}
        self._stretch = Stretch()
        self._sure: tuple[str, float] = '', 0.0
        self._alerts: tuple[AlertView, ...] = ()
        self._ticks = 0

    def build(self) -> None:
        """Make the elements, and begin to update them."""
        ui.add_head_html(f'<style>{style()}</style><script>{script()}</script>')
        ui.add_body_html('<div id="page-dead" role="status"></div>')
        view = self._controls.look()[0]
        with self._box('bridge'):
            with ui.element('h1'):
                ui.html('Heading intercomparison', sanitize=False, tag='span')
            self._build_alerts()
            with self._section('strip-area', 'Compass'):
                self._strip = ui.html('', sanitize=False)
            with self._box('left'):
                several = ' several' if len(view.rows) > 2 else ''
                with self._section(f'tiles{several}', 'Sensors'):
                    self._tiles = [self._build_tile(number, row)
                                   for number, row in enumerate(view.rows)]
                self._build_trend(view)
            with self._box('right'):
                self._build_verdict()
                self._build_window(view)
            self._build_controls()
            self._build_more()
        self._beat = ui.label('').classes('k-beat hidden')
        self.update()
        self._timer = ui.timer(_PERIOD_S, self._update_in_turn)

    def _build_alerts(self) -> None:
        with self._section('alerts', 'Alerts'):
            self._alert = self._box('alert quiet')
            with self._alert:
                self._symbol = ui.html('', sanitize=False)
                with ui.element('div').classes('alert-words').props(
                        'role=alert aria-live=assertive'):
                    self._label('alert', 'k-alert')
                self._label('alert_since', 'alert-since')
                self._acknowledge = self._button(
                    'Acknowledge', self._acknowledge_first, 'k-acknowledge')
                self._silence = self._button('Silence', None, 'k-silence')
                self._silence.on('click', js_handler='() => window.silence()')
                self._all = self._button('All alerts', self._toggle_list, 'k-list')
                self._all.props('aria-expanded=false')
            self._alert_rows = self._box('alert-list k-alerts hidden')

    def _build_tile(self, number: int, row: SensorRow) -> dict[str, Any]:
        with ui.element('article').classes(f'tile k-tile-{row.name}') as tile:
            with ui.element('h2'):
                marker = ui.html('', sanitize=False, tag='span')
                role = '' if row.title in ('Reference', 'Tested sensor') else (
                    'reference' if row.reference else 'tested')
                ui.html(f'{escape(row.title)} <small>{role}</small>', sanitize=False, tag='span')
            return {'tile': tile, 'marker': marker, 'number': number,
                    'heading': ui.label().classes(f'heading k-{row.name}_heading'),
                    'difference': ui.label().classes(f'difference k-{row.name}_difference'),
                    'state': ui.label().classes(f'state k-{row.name}_state')}

    def _build_verdict(self) -> None:
        with self._section('verdict', 'Verdict'):
            self._title('Verdict')
            for key, size in (('lamp', 'lamp box-none'), ('lamp_given', 'row'),
                              ('lamp_headline', 'small'), ('last_run', 'row')):
                self._label(key, size)
            self._progress = self._box('progress k-progress')
            with self._progress:
                self._done = ui.element('i')
            with self._box('ends'):
                self._label('run_begin', 'small')
                self._label('run_next', 'small')
            for key, size in (('missing', 'row'), ('now', 'row')):
                self._label(key, size)

    def _build_trend(self, view: BridgeView) -> None:
        with self._section('trend', 'Trend'):
            with self._box('trend-head'):
                self._title('No sensor is the reference' if not view.trends else
                            'Difference from the reference' if len(view.trends) == 1 else
                            'Differences from the reference, about the usual')
                with self._box('spans'):
                    for name, span_s in _SPANS.items():
                        button = self._button(name, partial(self._choose_span, span_s),
                                              f'k-span-{round(span_s)}')
                        button.props(f'aria-pressed={str(span_s == SPANS_S[0]).lower()}')
                    self._whole = self._button('Whole', partial(self._zoom, None),
                                               'k-whole hidden')
            self._trend = ui.html('', sanitize=False)
            ui.on('zoom', lambda event: self._zoom(event.args))

    def _build_window(self, view: BridgeView) -> None:
        with self._section('window', 'Window'):
            if view.sensors is not None:
                self._title('Vote')
                self._label('vote', 'mid')
            self._title('Scatter beside the norm')
            self._gauges = ui.html('', sanitize=False)
            if view.sensors is None:
                self._label('unpaired', 'row')

    def _build_controls(self) -> None:
        with self._section('controls', 'Controls'):
            self._run_buttons = {what: self._button(text, partial(self._ask, what), f'k-{what}')
                                 for what, text in (('start', 'Start run'), ('stop', 'Stop run'))}
            self._name = ui.input('Your name').classes('k-name')
            if any(named.operator for named in self._tokens):
                self._name.classes('hidden')
            self._note = ui.input('Note').classes('k-note')
            self._button('Keep note', self._keep_note, 'k-keep')
            self._token_input = None
            if self._tokens:
                self._token_input = ui.input('Token', password=True).classes('k-token')
            self._box('space')
            for name in PALETTES:
                button = self._button(name.capitalize(), None, f'k-{name}')
                button.on('click', js_handler=f'() => window.choosePalette("{name}")')
            sound = self._button('Sound test', None, 'k-sound')
            sound.on('click', js_handler='() => window.testSound()')
            with ui.element('div').props('role=status'):
                self._answer = ui.label('').classes('row k-answer')
            self._waiting = self._box('waiting hidden')
            with self._waiting:
                with ui.element('div').props('role=timer'):
                    self._label('waiting', 'row')
                for what, text in (('undo', 'Undo'), ('now', 'Do it now')):
                    self._button(text, partial(self._shorten, what), f'k-{what}')

    def _build_more(self) -> None:
        with self._box('more'):
            with ui.element('details').classes('k-history'):
                ui.html('Days and runs', sanitize=False, tag='summary')
                self._tests = ui.html('', sanitize=False).classes('k-tests')
                self._runs = ui.html('', sanitize=False)
            with ui.element('details').classes('k-details'):
                ui.html('Details', sanitize=False, tag='summary')
                for key in ('run', 'norm', 'paired', 'ledger', 'turn', 'mode', 'bag', 'graph',
                            'validity'):
                    self._label(key, 'row')
                self._sensor_rows = ui.html('', sanitize=False)
                self._nodes = ui.html('', sanitize=False).classes('k-nodes')

    @staticmethod
    def _box(classes: str) -> Any:
        return ui.element('div').classes(classes)

    @staticmethod
    def _section(classes: str, name: str) -> Any:
        return ui.element('section').classes(classes).props(f'aria-label="{name}"')

    @staticmethod
    def _title(text: str) -> None:
        with ui.element('h2'):
            ui.html(escape(text), sanitize=False, tag='span')

    def _label(self, key: str, size: str) -> None:
        self._labels[key] = ui.label('').classes(f'{size} k-{key}')

    @staticmethod
    def _button(text: str, act: Any, classes: str) -> Any:
        return ui.button(text, on_click=act, color=None).props('no-caps unelevated').classes(
            classes)

    def _update_in_turn(self) -> None:
        self._timer.interval = update_period_s(len(Client.instances))
        self.update()

    def update(self) -> None:
        """Show the newest view; what has not changed is not sent."""
        view, age_s = self._controls.look()
        self._ticks += 1
        # The beat stands still with the view, so the browser sees that the page is not live.
        if age_s < _OLD_S:
            self._beat.set_text(str(self._ticks))
        self._show_alerts(view.alerts)
        self._show_waiting(view)
        self._show_html('strip', self._strip, self._drawings.draw(
            view, 'strip', lambda: draw_strip(view.rows)))
        no_reference = any(row.reference and (row.now.stale or row.state in _NO_REFERENCE)
                           for row in view.rows)
        for tile, row in zip(self._tiles, view.rows):
            self._show_tile(tile, row, no_reference)
        self._show_texts(view)
        if self._ticks % 5 == 1:
            self._show_slowly(view)
        if self._sure[0] and time.monotonic() > self._sure[1]:
            self._forget_tap()

    def _show_texts(self, view: BridgeView) -> None:
        texts = self._drawings.draw(
            view, 'texts', lambda: {**tell(view), 'vote': vote_words(view)})
        lamp = self._labels['lamp']
        if self._shown.get('box') != view.lamp.tone:
            self._shown['box'] = view.lamp.tone
            lamp.classes(remove='box-none box-good box-doubt box-bad',
                         add=f'box-{view.lamp.tone}')
        for key, phrase in texts.items():
            if key in self._labels and self._shown.get(key) != phrase:
                self._tone(self._labels[key], phrase)
                self._shown[key] = phrase

    def _show_waiting(self, view: BridgeView) -> None:
        """Show the action that waits, from whichever page it comes, and how the last one ended."""
        delay = self._controls.delay
        action, outcome = delay.waiting, delay.outcome
        if self._shown.setdefault('outcome', outcome) != outcome:
            self._shown['outcome'] = outcome
            self._answer.set_text(outcome)
        if action is not None:
            self._labels['waiting'].set_text(
                waiting_words(action, delay.left_s(action), view.run))
        if self._shown.get('action') != action:
            self._shown['action'] = action
            self._waiting.classes(remove='hidden', add='' if action is not None else 'hidden')

    def _show_slowly(self, view: BridgeView) -> None:
        """Show what need not be shown more often than once a second."""
        draw = self._drawings.draw
        self._show_html('trend', self._trend, draw(
            view, self._stretch, lambda: _draw_trends(view, self._stretch)))
        self._show_progress(view)
        self._show_html('gauges', self._gauges, draw(view, 'gauges', lambda: _draw_gauges(view)))
        self._show_html('sensors', self._sensor_rows, ''.join(
            f'<p class="row {phrase.tone}">{escape(name)}: {escape(phrase.text)}</p>'
            for name, phrase in sensor_words(view)))
        self._show_html('tests', self._tests, draw(
            view, 'tests', lambda: _list_tests(view.tests)))
        self._show_html('runs', self._runs, draw(view, 'runs', lambda: _list_days(view.runs)))
        self._show_html('nodes', self._nodes, ''.join(
            f'<p class="row {phrase.tone}">{escape(phrase.text)}</p>'
            for phrase in node_words(view)) or '<p class="row">no node is heard</p>')

    def _show_progress(self, view: BridgeView) -> None:
        """Show how far the run has come towards its next decision."""
        run = view.run
        decides_ns = run.next_look_ns or run.ends_ns
        span_s = run.span_s or 0.0
        whole_s = span_s + run.needed_s if run.needed_s is not None else 0.0
        if decides_ns is not None and run.start_ns is not None:
            whole_s = (decides_ns - run.start_ns) / 1e9
        share = 0.0 if not whole_s > 0.0 else min(1.0, span_s / whole_s)
        width = f'width:{100.0 * share:.1f}%'
        state = 'hidden' if not run.number else (
            'waits' if view.validity.tone is Tone.BAD else '')
        if self._shown.get('progress') != (width, state):
            self._shown['progress'] = width, state
            self._done.style(width)
            self._progress.classes(remove='waits hidden', add=state)

    def _show_html(self, key: str, element: Any, content: str) -> None:
        if self._shown.get(key) != content:
            self._shown[key] = content
            element.set_content(content)

    @staticmethod
    def _tone(label: Any, phrase: Said) -> None:
        label.set_text(phrase.text)
        label.classes(remove='none good doubt bad', add=phrase.tone.value)

    def _show_tile(self, tile: dict[str, Any], row: SensorRow, no_reference: bool) -> None:
        if self._shown.get(row.name) == (row, no_reference):
            return
        self._shown[row.name] = row, no_reference
        state = tile_state(row, no_reference)
        wrong = state.tone is Tone.BAD
        stale = row.now.heading_deg is None
        heading_deg = row.now.last_deg if stale else row.now.heading_deg
        self._show_html(f'{row.name} marker', tile['marker'], draw_marker(
            tile['number'], row.reference, row.named or stale))
        tile['heading'].set_text('–' if heading_deg is None else compass_words(heading_deg))
        tile['heading'].classes(remove='stale', add='stale' if stale else '')
        tile['tile'].classes(remove='wrong', add='wrong' if wrong else '')
        tile['difference'].set_text('' if row.reference or row.difference_deg is None else
                                    big_difference(row.difference_deg))
        self._tone(tile['state'], state)

    def _show_alerts(self, alerts: Sequence[AlertView]) -> None:
        first = next(iter(alerts), None)
        since = '' if first is None else stamp_words(first)
        self._labels['alert_since'].set_text(since)
        # Ages pass; a screen reader hears a change alone.
        steady = tuple((alert.words, alert.priority, alert.active, alert.acknowledged,
                        alert.consequences) for alert in alerts)
        if self._shown.get('alerts') == steady:
            return
        self._shown['alerts'], self._alerts = steady, tuple(alerts)
        more = len(alerts) - 1
        self._labels['alert'].set_text('No alerts' if first is None else first.words + (
            f' (and {more} more)' if more else ''))
        self._symbol.set_content('' if first is None else draw_symbol(
            first.priority, first.acknowledged))
        open_alert = first is not None and not first.acknowledged
        self._alert.classes(
            remove='quiet unacknowledged p-alarm p-warning p-caution',
            add='quiet' if first is None else
            f'p-{first.priority}{" unacknowledged" if open_alert else ""}')
        self._alert.props(f'data-sound="{first.priority if first and open_alert else ""}"')
        for button, is_shown in ((self._acknowledge, open_alert), (self._silence, open_alert),
                                 (self._all, first is not None)):
            button.classes(remove='hidden', add='' if is_shown else 'hidden')
        self._alert_rows.clear()
        with self._alert_rows:
            for alert in alerts:
                self._build_alert_row(alert)

    def _build_alert_row(self, alert: AlertView) -> None:
        calm = '' if not alert.acknowledged else ' calm'
        with self._box(f'entry p-{alert.priority}{calm}'):
            ui.html(draw_symbol(alert.priority, alert.acknowledged), sanitize=False)
            with self._box(''):
                ui.label(alert_words(alert).text).classes('words k-alert-row')
                ui.label(alert.details).classes('small')
            if not alert.acknowledged:
                self._button('Acknowledge', partial(self._acknowledge_alert, alert),
                             'k-acknowledge-row')

    def _toggle_list(self) -> None:
        is_open = 'hidden' in self._alert_rows.classes
        self._alert_rows.classes(remove='hidden', add='' if is_open else 'hidden')
        self._all.props(f'aria-expanded={str(is_open).lower()}')

    async def _acknowledge_first(self) -> None:
        if self._alerts:
            await self._acknowledge_alert(self._alerts[0])

    async def _acknowledge_alert(self, alert: AlertView) -> None:
        for name in alert.alarms:
            if not await self._act('acknowledge', name):
                return

    def _choose_span(self, span_s: float) -> None:
        self._stretch = Stretch(span_s)
        ui.run_javascript(
            'document.querySelectorAll("[class*=k-span-]").forEach(button => '
            'button.setAttribute("aria-pressed", '
            f'String(button.classList.contains("k-span-{round(span_s)}"))))')
        self._zoom(None)

    def _zoom(self, shares: Sequence[float] | None) -> None:
        """Show a part of the trend, as shares of what is shown now; None: all of it."""
        before = self._stretch
        if shares is None:
            self._stretch = Stretch(before.span_s)
        else:
            width = before.to_share - before.from_share
            low, high = (min(1.0, max(0.0, float(share))) for share in shares)
            self._stretch = before._replace(from_share=before.from_share + low * width,
                                            to_share=before.from_share + high * width)
        zoomed = self._stretch != Stretch(before.span_s)
        self._whole.classes(remove='hidden', add='' if zoomed else 'hidden')
        self._show_slowly(self._controls.look()[0])

    async def _ask(self, what: str) -> None:
        """Do what begins or ends a run at the second tap; the first says what that means."""
        if self._sure[0] == what:
            self._forget_tap()
            await self._act(what, '')
            return
        self._forget_tap()
        self._sure = what, time.monotonic() + _SURE_S
        run = self._controls.look()[0].run
        button = self._run_buttons[what]
        button.set_text(f'Tap again: {"a new run begins" if what == "start" else "the run ends"}')
        button.classes(add='sure')
        self._answer.set_text(mark_words(what, run))

    async def _shorten(self, what: str) -> None:
        """Undo the action that this page shows as waiting, or do it now."""
        action = self._shown.get('action')
        if action is not None:
            await self._act(what, action.what)

    def _forget_tap(self) -> None:
        self._sure = '', 0.0
        for what, text in (('start', 'Start run'), ('stop', 'Stop run')):
            self._run_buttons[what].set_text(text)
            self._run_buttons[what].classes(remove='sure')

    async def _keep_note(self) -> None:
        text = (self._note.value or '').strip()
        if not text:
            self._answer.set_text('the note is empty')
        elif await self._act('note', text):
            self._note.set_value('')

    async def _act(self, what: str, text: str) -> bool:
        """Do an action, if the token is right, and show the answer; tell whether it was done."""
        token = '' if self._token_input is None else self._token_input.value or ''
        operator = find_operator(token, self._tokens)
        if operator is None:
            await asyncio.sleep(_WRONG_S)
            self._answer.set_text('refused: the token is wrong; ask the person who started the '
                                  'program')
            return False
        try:
            answer = await asyncio.wait_for(asyncio.wrap_future(self._controls.act(
                what, text, operator or (self._name.value or '').strip())), _PATIENCE_S)
        except asyncio.TimeoutError:
            self._answer.set_text(f'no answer in {_PATIENCE_S:g} s: is the graph running?')
            return False
        self._answer.set_text(answer)
        return True


def _draw_trends(view: BridgeView, stretch: Stretch) -> str:
    """Return the trends of the tested sensors as HTML."""
    numbers = {row.name: number for number, row in enumerate(view.rows)}
    return draw_trend(view.trends, stretch, [row.name for row in view.rows if row.named],
                      [numbers[trend.sensor] for trend in view.trends])


def _draw_gauges(view: BridgeView) -> str:
    """Return the scatter of each tested sensor in the window, and the mean of a single one."""
    if view.sensors is not None:
        return ''.join(
            draw_gauge(row.title, row.std_deg, row.std_deg / row.share)
            for row in view.rows if not row.reference and row.std_deg and row.share)
    window = view.window
    if window.stale:
        return draw_gauge('sd', None, None)
    mean_norm_deg = window.limit_deg if window.judges_mean else None
    return (draw_gauge('sd', window.std_deg, window.limit_deg)
            + draw_gauge('mean', window.mean_deg, mean_norm_deg))


def _list_tests(tests: Sequence[JudgedTestView]) -> str:
    """Return the tests of the norm as a table; nothing if it requires none."""
    if not tests:
        return ''
    cells = ''.join(f'<tr><td>{escape(test.words)}</td><td class="{test.tone}">'
                    f'{escape(test.result)}</td><td>{escape(test.notes)}</td></tr>'
                    for test in tests)
    return ('<div class="scrolls" tabindex="0"><table><thead><tr><th>test of the norm</th>'
            '<th>result, figure, limit</th><th>what the record holds</th></tr></thead>'
            f'<tbody>{cells}</tbody></table></div>')


def _list_days(runs: Sequence[JudgedRunView]) -> str:
    """Return the judged runs as a table, each day with its figures, the newest first."""
    if not runs:
        return '<p class="row">no run has been judged yet</p>'
    cells = ''.join(
        f'<tr class="day"><th scope="rowgroup" colspan="2">{escape(day.date)}, '
        f'{count_words(len(day.runs), "run")}</th>{_figures(day)}<td></td></tr>'
        + ''.join(f'<tr><td class="number">{run.number}</td><td>{clock(run.start_ns)} – '
                  f'{clock(run.end_ns)}</td>{_figures(run)}<td>{escape(run.reason)}</td></tr>'
                  for run in day.runs)
        for day in group_by_day(runs))
    return ('<div class="scrolls" tabindex="0"><table><thead><tr><th class="number">run</th>'
            '<th>time</th><th class="number">differences</th><th class="number">mean</th>'
            '<th class="number">sd</th><th>verdict</th><th>why</th></tr></thead>'
            f'<tbody>{cells}</tbody></table></div>')


def _figures(judged: JudgedDayView | JudgedRunView) -> str:
    return (f'<td class="number">{judged.n:,}</td><td class="number">{_deg(judged.mean_deg, "+")}'
            f'</td><td class="number">{_deg(judged.std_deg)}</td>'
            f'<td class="{judged.tone}">{escape(judged.word)}</td>')


def _deg(value: float | None, sign: str = '') -> str:
    return '–' if value is None else f'{value:{sign}.3f}°'


def has_room(connections_by_address: int, host: str) -> bool:
    """
    Tell whether one more page may be built for the browser at an address.

    A page is held until its browser opens a WebSocket, and for some seconds after that is closed.
    A program that asks for pages and never opens one could fill the memory with them.
    """
    Client.prune_instances(client_age_threshold=_UNSEEN_S)
    waiting = [client for client in Client.instances.values()
               if not client.has_socket_connection]
    network = network_of(host)
    return len(Client.instances) < MOST_PAGES and sum(
        network_of(client.ip) == network for client in waiting) < connections_by_address // 4


def build(controls: Controls, tokens: Sequence[NamedToken], drawings: Drawings) -> None:
    """Build the page for one browser; with tokens, actions need one of them."""
    _Page(controls, tokens, drawings).build()
