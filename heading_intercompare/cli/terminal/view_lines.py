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

"""A view of a running graph as lines for a terminal, and as a single line of text."""

from __future__ import annotations

import math
from typing import Iterable, NamedTuple, Sequence

from heading_intercompare.core.decision.coverage import span_words
from heading_intercompare.core.utc_text import utc
from heading_intercompare.web.bridge.bridge_records import NodeView, Tone, TrendView
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.view_texts import (
    alert_words,
    node_words,
    Said,
    sensor_words,
    tell,
    vote_words,
)

#: Columns of the label of a line.
LABEL = 9
_BAR = 24
_LEVELS = '▁▂▃▄▅▆▇█'
_LEAST_SPAN_S = 60.0


class Line(NamedTuple):
    """
    One line of the terminal: a label, a text, and what both look like.

    Attributes
    ----------
    label
        Stands at the left; '' for a line that goes on with the one above.
    tone
        Colour of the text; the words alone say everything.
    bold
        The text is among the figures that people look for.

    """

    label: str
    text: str
    tone: Tone = Tone.NONE
    bold: bool = False


def lay_out(view: BridgeView, columns: int, rows: int, *, title: str = '', phase: str = '',
            foot: str = '') -> list[Line]:
    """
    Return the lines of a view, at most `rows`, for a terminal of a width.

    Parameters
    ----------
    view
        What the graph tells by now.
    columns, rows
        Room for the view. What does not fit is cut: first words of nodes and alarms.
    title, phase, foot
        What runs, what it does at the moment, and what can be done; '' leaves a line out.

    """
    texts = tell(view)
    room = max(20, columns - LABEL - 1)

    def line(label: str, *places: str, bold: bool = False) -> Line:
        phrases = [texts[place] for place in places if texts[place].text]
        return Line(label, '; '.join(phrase.text for phrase in phrases), _gravest(phrases), bold)
    heading = [Line('', title, bold=True)] if title else []
    verdict = [Line('verdict', texts['lamp'].text, texts['lamp'].tone, bold=True),
               *(Line('', phrase.text) for phrase in (texts['lamp_given'], texts['lamp_headline'])
                 if phrase.text),
               line('now', 'validity')]
    fixed = [*heading, *_list_sensors(view), *verdict, line('bag', 'bag')] if view.sensors else [
        *heading,
        _numeral('TS', texts['ts_heading'], texts['ts_state']),
        _numeral('RS', texts['rs_heading'], texts['rs_state']),
        _numeral('TS - RS', texts['difference'], texts['difference_state']),
        line('turn', 'turn'),
        *([line('AHRS', 'mode')] if view.mode else []),
        *verdict,
        Line('run', ' '.join(filter(None, [texts['run'].text, _bar(view)]))),
        line('missing', 'lacking'),
        line('window', 'window', 'norm'),
        Line('trend', draw_trend(view.trend, room), texts['trend'].tone),
        line('pairs', 'paired', 'ledger'),
        line('bag', 'bag'),
    ]
    last = [Line('', text) for text in (phase, foot) if text]
    listed = [*_list_alerts(view), *_list_nodes(view)]
    left = rows - len(fixed) - len(last)
    if len(listed) > left:
        more = len(listed) - max(left, 1) + 1
        listed = [*listed[:max(left - 1, 0)], Line('', f'and {more} lines more')]
    return [*fixed, *listed, *last][:rows]


def _numeral(label: str, figure: Said, state: Said) -> Line:
    return Line(label, f'{figure.text:<9}{state.text}', state.tone, bold=True)


def _gravest(phrases: Iterable[Said]) -> Tone:
    order = (Tone.NONE, Tone.GOOD, Tone.DOUBT, Tone.BAD)
    return max((phrase.tone for phrase in phrases), key=order.index, default=Tone.NONE)


def _list_sensors(view: BridgeView) -> list[Line]:
    """Return a line for each of several sensors, and the vote."""
    vote = vote_words(view)
    return [*(Line(name, phrase.text, phrase.tone, bold=True)
              for name, phrase in sensor_words(view)),
            Line('vote', vote.text, vote.tone)]


def _list_alerts(view: BridgeView) -> list[Line]:
    """Return a line per alert; the first one has the label."""
    alerts = [alert_words(alert) for alert in view.alerts] or [Said('none')]
    return [Line('' if at else 'alerts', alert.text, alert.tone)
            for at, alert in enumerate(alerts)]


def _list_nodes(view: BridgeView) -> list[Line]:
    """Return the nodes in order in one line, and a line for each other one."""
    nodes = [*zip(view.nodes, node_words(view))]
    well = [node.name for node, _ in nodes if _is_well(node)]
    lines = [phrase for node, phrase in nodes if not _is_well(node)]
    if well or not lines:
        lines.append(Said(f'{", ".join(well)}: OK' if well else 'none heard yet'))
    return [Line('' if at else 'nodes', line.text, line.tone) for at, line in enumerate(lines)]


def _is_well(node: NodeView) -> bool:
    return not node.level and not node.stale


def _bar(view: BridgeView) -> str:
    """Return how far the run has come towards a decision, if that can be told."""
    needed_s, span_s = view.run.needed_s, view.run.span_s
    if not view.run.number or needed_s is None or span_s is None or not math.isfinite(needed_s):
        return ''
    whole_s = span_s + max(0.0, needed_s)
    full = _BAR if whole_s <= 0.0 else min(_BAR, int(_BAR * span_s / whole_s))
    return f'[{"=" * full}{"." * (_BAR - full)}]'


def draw_trend(trend: TrendView, room: int) -> str:
    """Return the sparkline of a trend with its extremes and its length, in at most `room`."""
    if not trend.columns:
        return 'no pairs yet'
    low = min(column.low_deg for column in trend.columns)
    high = max(column.high_deg for column in trend.columns)
    ages_s = sorted(column.age_s for column in trend.columns)
    step_s = min((b - a for a, b in zip(ages_s, ages_s[1:])), default=_LEAST_SPAN_S)
    span_s = max(_LEAST_SPAN_S, ages_s[-1] + 0.5 * step_s)
    words = f'{low:+.2f}° .. {high:+.2f}° in {span_words(span_s)}'
    # A cell shorter than a column would often be blank.
    width = max(5, min(room - len(words) - 1, round(span_s / step_s)))
    spark = draw_sparkline(
        [(column.age_s / span_s, 0.5 * (column.low_deg + column.high_deg))
         for column in trend.columns], width)
    return f'{spark} {words}'


def draw_sparkline(points: Sequence[tuple[float, float]], width: int) -> str:
    """
    Return a row of bars; a gap is blank.

    Parameters
    ----------
    points : sequence of (age, value)
        The age in terms of the width of the picture: 0 is its right edge, 1 its left one.
    width
        Number of characters.

    Examples
    --------
    >>> draw_sparkline([(0.9, 0.0), (0.6, 7.0), (0.1, 3.0)], 4)
    '▁█ ▄'

    """
    cells: list[list[float]] = [[] for _ in range(width)]
    for age, value in points:
        cells[max(0, min(width - 1, int((1.0 - age) * width)))].append(value)
    means = [sum(cell) / len(cell) for cell in cells if cell]
    if not means:
        return ' ' * width
    low, high = min(means), max(means)
    scale = (len(_LEVELS) - 1) / (high - low) if high > low else 0.0
    return ''.join(_LEVELS[int(scale * (sum(cell) / len(cell) - low) + 0.5)] if cell else ' '
                   for cell in cells)


def _tell_sensors(view: BridgeView) -> list[str]:
    """Return the headings of several sensors, and the vote."""
    heard = ', '.join(f'{name} {" ".join(phrase.text[:7].split())}'
                      for name, phrase in sensor_words(view))
    return [heard, vote_words(view).text]


def one_line(view: BridgeView, now_ns: int, phase: str = '') -> str:
    """Return a view as one line of plain text, with the time of day."""
    texts = tell(view)
    heard = view.ts.age_s is not None or view.rs.age_s is not None
    last_verdict = f' ({texts["lamp_given"].text})' if texts['lamp_given'].text else ''
    parts = [
        phase,
        *(_tell_sensors(view) if view.sensors else [
            f'TS {texts["ts_heading"].text}, RS {texts["rs_heading"].text}, TS - RS '
            f'{texts["difference"].text}' if heard else 'neither TS nor RS heard yet']),
        f'verdict {view.lamp.word}{last_verdict}' if view.judged else '',
        view.validity.words,
        f'{texts["run"].text}, {texts["lacking"].text}' if view.run.number else '',
        f'{texts["window"].text}, {texts["norm"].text}' if view.window.n else '',
        '' if view.paired_share is None else texts['paired'].text,
        '' if view.bag.age_s is None else texts['bag'].text,
        *(alert_words(alert).text for alert in view.alerts),
        *(phrase.text for node, phrase in zip(view.nodes, node_words(view)) if not _is_well(node))]
    return f'{utc(now_ns)[11:19]} {"; ".join(filter(None, parts))}'
