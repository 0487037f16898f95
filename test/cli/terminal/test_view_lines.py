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

"""The lines of a view fit the terminal, and say what the page says."""

from __future__ import annotations

import pytest

from heading_intercompare.cli.terminal.view_lines import (
    draw_sparkline,
    draw_trend,
    lay_out,
    one_line,
)
from heading_intercompare.web.bridge.bridge_records import (
    AlertView,
    BagView,
    LampView,
    NodeView,
    RunView,
    Tone,
    TrendView,
    ValidityView,
    WindowView,
)
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.figures.stream_watch import SensorView
from heading_intercompare.web.figures.trend import TrendColumn

T0_NS = 1_700_000_000_000_000_000


def a_view(**changed):
    """Return a view of a trial in order."""
    sensor = SensorView(heading_deg=87.3, last_deg=87.3, age_s=0.1, rate_hz=10.0, offset_s=-0.02,
                        turn_deg_min=3.0, stale=False)
    given = {
        'ts': sensor, 'rs': sensor, 'difference_deg': 0.19, 'last_difference_deg': 0.19,
        'difference_age_s': 0.1, 'difference_stale': False, 'turn_deg_min': 3.0,
        'paired_share': 0.999, 'paired': 2345, 'rejected': 2,
        'lamp': LampView(what='next look 12:40 UTC'),
        'validity': ValidityView('nothing speaks against the comparison now', Tone.NONE),
        'window': WindowView(600, 0.19, 0.12, 0.316, 0.5, False),
        'run': RunView(1, 2345, 240.0, 720.0, None, '12 min more if it goes on like this', 0.5,
                       False),
        'trend': TrendView(tuple(TrendColumn(3.0 * i + 1.5, 0.1, 0.1 + 0.01 * i)
                                 for i in range(80)), newest_ns=T0_NS, stale=False),
        'nodes': (NodeView('compliance', 0, 'running', 0.2, False),
                  NodeView('recorder', 0, 'running', 0.2, False)),
        'bag': BagView('recording to trial', 0, 81_200_000_000, 0.2, False),
        'graph_age_s': 0.1, 'judged': True}
    return BridgeView(**{**given, **changed})


def texts(lines):
    """Return the lines by their labels; those without one belong to the label above."""
    found, label = {}, ''
    for line in lines:
        label = line.label or label
        found[label] = f'{found[label]}\n{line.text}' if label in found else line.text
    return found


def test_a_view_of_a_trial_in_order_says_everything():
    said = texts(lay_out(a_view(), 80, 23, title='live: trial', foot='Ctrl-C ends the trial'))
    assert said['TS'].startswith('087.3°   age 0.1 s, 10.0 Hz, stamp -0.02 s')
    assert said['TS - RS'].startswith('+0.19°')
    assert said['turn'] == 'rate of turn 3.0°/min to starboard'
    assert said['verdict'] == '… NONE YET\nnext look 12:40 UTC'
    assert said['now'] == '… nothing speaks against the comparison now'
    # 240 s of 960 s: a quarter of the bar.
    assert said['run'] == f'run 1: 2,345 differences in 4 min [{"=" * 6}{"." * 18}]'
    assert said['missing'] == '12 min more if it goes on like this'
    assert said['window'].startswith('mean +0.190°, sd 0.120°; norm for sd 0.316°')
    assert said['pairs'] == 'paired 99.9%; 2,345 pairs, 2 readings rejected'
    assert said['bag'] == 'bag: recording to trial; free disk 81.2 GB'
    assert said['alerts'] == 'none'
    assert said['nodes'] == 'compliance, recorder: OK\nCtrl-C ends the trial'


def test_no_line_of_a_trial_in_order_is_coloured_before_a_verdict():
    assert {line.tone for line in lay_out(a_view(), 80, 23)} == {Tone.NONE}
    begun = BridgeView(judged=True, validity=ValidityView('no pair has come', Tone.NONE))
    assert {line.tone for line in lay_out(begun, 80, 23)} == {Tone.NONE}


@pytest.mark.parametrize('rows', [5, 12, 18, 23, 60])
def test_a_view_fits_and_says_how_much_is_cut(rows):
    alerts = tuple(AlertView('warning', f'bad {i}', since_ns=T0_NS) for i in range(9))
    nodes = tuple(NodeView(f'n{i}', 2, 'broken', 0.1, False) for i in range(9))
    lines = lay_out(a_view(alerts=alerts, nodes=nodes), 80, rows, foot='Ctrl-C')
    assert len(lines) <= rows
    shown = [line for line in lines if 'bad' in line.text or 'broken' in line.text]
    if rows == 60:
        assert len(shown) == 18
    elif rows > 18:
        more, = [line.text for line in lines if line.text.endswith(' lines more')]
        assert more == f'and {18 - len(shown)} lines more' and lines[-1].text == 'Ctrl-C'


def test_a_verdict_and_an_alarm_have_their_colours():
    lamp = LampView('COMPLIANT', Tone.GOOD, T0_NS, 'look 2 of 5', 'COMPLIANT for slow errors')
    alert = AlertView('warning', 'Tested sensor silent', since_ns=T0_NS)
    lines = lay_out(a_view(lamp=lamp, alerts=(alert,)), 80, 23)
    verdict, = [line for line in lines if line.label == 'verdict']
    assert (verdict.text, verdict.tone) == ('✔ COMPLIANT', Tone.GOOD)
    alarmed, = [line for line in lines if line.label == 'alerts']
    assert alarmed.tone is Tone.BAD and 'not acknowledged' in alarmed.text
    assert 'last verdict: 2023-11-14 22:13 UTC, look 2 of 5' in texts(lines)['verdict']


def test_a_sparkline_shows_gaps_and_a_constant():
    assert draw_sparkline([], 3) == '   '
    assert draw_sparkline([(0.9, 5.0), (0.1, 5.0)], 3) == '▁ ▁'


def test_a_trend_has_no_cell_shorter_than_its_columns():
    trend = TrendView(tuple(TrendColumn(3.0 * i + 1.5, 0.0, float(i)) for i in range(20)))
    spark, words = draw_trend(trend, 200).split(' ', 1)
    assert len(spark) == 20 and words == '+0.00° .. +19.00° in 60 s'
    assert len(draw_trend(trend, 40)) <= 40


def test_a_line_of_text_says_what_is_known():
    assert one_line(a_view(), T0_NS) == (
        '22:13:20 TS 087.3°, RS 087.3°, TS - RS +0.19°; verdict NONE YET (next look 12:40 UTC); '
        'nothing speaks against the comparison now; run 1: 2,345 differences in 4 min, 12 min '
        'more if it goes on like this; mean +0.190°, sd 0.120°, norm for sd 0.316°; 600 '
        'differences in the window; paired 99.9%; bag: recording to trial; free disk 81.2 GB')
    assert one_line(BridgeView(), T0_NS, 'starting') == (
        '22:13:20 starting; neither TS nor RS heard yet; not known: nothing is heard')
