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

"""The words of the page."""

from __future__ import annotations

import pytest

from heading_intercompare.web.bridge.bridge_records import (
    AlertView,
    BagView,
    LampView,
    NodeView,
    RunView,
    Tone,
    TrendView,
    WaitingAction,
    WindowView,
)
from heading_intercompare.web.bridge.bridge_view import BridgeView
from heading_intercompare.web.bridge.sensors_panel import SensorRow
from heading_intercompare.web.bridge.view_texts import (
    alert_words,
    big_difference,
    mark_words,
    node_words,
    stamp_words,
    tell,
    tile_state,
    waiting_words,
)
from heading_intercompare.web.figures.stream_watch import SensorView

T0 = 1_700_000_000 * 10 ** 9


def test_before_anything_is_heard_no_place_shows_a_figure():
    said = tell(BridgeView())
    assert said['ts_heading'].text == said['rs_heading'].text == said['difference'].text == '– –'
    assert said['ts_state'].text == 'not heard yet'
    assert said['difference_state'].text == 'no pair yet'
    assert said['lamp'].text == '… NONE YET' and said['run'].text == 'no run'
    assert said['graph'].text == 'nothing heard from the graph yet'


_SIZE = '11.0 h with 396,000 differences'


@pytest.mark.parametrize('kind, number, marked, words', [
    ('start', 3, False, 'the first start takes all before it out of the record: '
     f'run 3, {_SIZE}, and each earlier run would not count'),
    ('start', 0, False, 'the first start takes all before it out of the record: '
     'each earlier run would not count'),
    ('start', 3, True, f'run 3 would end here, after {_SIZE}, and be judged as it is'),
    ('stop', 3, False, f'run 3 would end here, after {_SIZE}, and be judged as it is'),
    ('start', 0, True, 'no run is in progress'), ('stop', 0, False, 'no run is in progress')])
def test_the_first_tap_says_what_would_not_count(kind, number, marked, words):
    """The page promised that the run be judged as it is; the first start discarded 11 hours."""
    run = RunView(number=number, n=396_000, span_s=39_600.0, age_s=0.5, marked=marked)
    assert mark_words(kind, run) == words
    assert mark_words(kind, RunView()).startswith('it is not known whether')


@pytest.mark.parametrize('what, operator, left_s, words', [
    ('start', '', 42.1, 'The run starts at 22:13:20 UTC, in 43 s: '),
    ('stop', 'Ma[te', 60.0, 'The run ends at 22:13:20 UTC, in 60 s, asked by Ma te: '),
    ('stop', '', 0.0, 'The run ends at 22:13:20 UTC, in 0 s: ')])
def test_a_waiting_action_says_when_and_what_would_not_count(what, operator, left_s, words):
    run = RunView(number=3, n=396_000, span_s=39_600.0, age_s=0.5)
    action = WaitingAction(what, operator, 7.0, 1_700_000_000_000_000_000)
    assert waiting_words(action, left_s, run) == words + mark_words(what, run)


def test_a_live_sensor_shows_heading_age_rate_and_offset():
    said = tell(BridgeView(ts=SensorView(7.25, 7.25, 0.1, 10.0, -0.04, 3.0, False)))
    assert said['ts_heading'].text == '007.2°'
    assert said['ts_state'].text == 'age 0.1 s, 10.0 Hz, stamp -0.04 s'


def test_a_silent_sensor_shows_a_dash_and_says_stale():
    said = tell(BridgeView(rs=SensorView(None, 7.25, 12.0, None, -8000.0, None, True)))
    assert said['rs_heading'].text == '– –'
    assert said['rs_state'] == ('STALE: last 007.2°, 12 s ago', Tone.BAD)


@pytest.mark.parametrize('turn, words', [
    (None, 'rate of turn not known'), (12.0, 'rate of turn 12.0°/min to starboard'),
    (-12.0, 'rate of turn 12.0°/min to port'), (0.1, 'rate of turn 0.1°/min ')])
def test_the_rate_of_turn_names_its_side(turn, words):
    assert tell(BridgeView(turn_deg_min=turn))['turn'].text == words


def test_a_stale_difference_window_run_trend_and_bag_say_so():
    view = BridgeView(last_difference_deg=0.1, difference_age_s=9.0,
                      window=WindowView(5, 0.0, 0.1, 0.2, 9.0, True),
                      run=RunView(1, 5, 4.0, 60.0, None, 'x', 9.0, True),
                      trend=TrendView((), 1800.0, T0, 0.0, None, 9.0, True),
                      bag=BagView('recording', 1, 10 ** 10, 9.0, True))
    said = tell(view)
    for key in ('difference_state', 'window', 'lacking', 'trend', 'bag'):
        assert 'STALE' in said[key].text and said[key].tone is not Tone.NONE, key
        assert '9.0 s' in said[key].text, key
    assert 'free disk 10.0 GB' in said['bag'].text


def test_the_lamp_says_what_it_rests_on_in_words():
    lamp = LampView('COMPLIANT', Tone.GOOD, T0, 'look 2 of 3', 'the headline')
    run = RunView(1, 5, 4.0, 60.0, T0 + 10 ** 11, 'long', 0.0, False)
    said = tell(BridgeView(lamp=lamp, run=run))
    assert said['lamp'] == ('✔ COMPLIANT', Tone.GOOD)
    assert said['lamp_given'].text == 'last verdict: 2023-11-14 22:13 UTC, look 2 of 3'
    assert said['lacking'].text == 'long, next look 22:15 UTC'


def test_tones_have_a_sign_and_a_word_each():
    """Colours are never the only carrier of meaning."""
    signs = {tell(BridgeView(lamp=LampView('X', tone)))['lamp'].text[0] for tone in Tone}
    assert len(signs) == len(Tone)


def test_alerts_and_nodes_in_words():
    alert = AlertView('warning', 'Tested sensor frozen', since_ns=T0,
                      consequences=('Tested sensor differs from the others',))
    quiet = AlertView('caution', 'Messages were lost', acknowledged=True, active=False)
    said = alert_words(alert)
    assert said == ('WARNING: Tested sensor frozen; follows: Tested sensor differs from the '
                    'others (not acknowledged, since 22:13 UTC)', Tone.BAD)
    assert alert_words(quiet) == ('CAUTION: Messages were lost (over)', Tone.DOUBT)
    nodes = (NodeView('a', 0, 'running', 0.1, False), NodeView('b', 2, 'no', 9.0, True))
    lines = node_words(BridgeView(nodes=nodes))
    assert [line.text for line in lines] == ['a: OK, running', 'b: STALE, heard 9.0 s ago']


@pytest.mark.parametrize('alert, words', [
    (AlertView('warning', 'x', since_ns=T0, age_s=12.2), 'for 12 s'),
    (AlertView('warning', 'x', since_ns=T0, age_s=300.0), 'for 5 min'),
    (AlertView('warning', 'x', since_ns=T0), 'since 22:13 UTC'),
    (AlertView('warning', 'x', since_ns=T0, age_s=9.0, active=False), 'over, raised 22:13 UTC'),
    (AlertView('warning', 'x'), '')])
def test_how_long_an_alert_has_been_standing(alert, words):
    assert stamp_words(alert) == words


LIVE = SensorView(7.25, 7.25, 0.1, 10.0, -0.04, 3.0, False)


@pytest.mark.parametrize('row, no_reference, words, tone', [
    (SensorRow('ts', now=LIVE), False, 'sound', Tone.NONE),
    (SensorRow('ts'), False, 'not heard yet', Tone.NONE),
    (SensorRow('ts', now=SensorView(None, 7.25, 4.0)), False, '✖ silent 4.0 s', Tone.BAD),
    (SensorRow('ts', now=LIVE, state='frozen'), False, '✖ frozen', Tone.BAD),
    (SensorRow('ts', now=LIVE, named=True), False, '✖ differs', Tone.BAD),
    (SensorRow('ts', now=LIVE), True, '! no reference', Tone.DOUBT),
    (SensorRow('rs', True, now=LIVE), True, 'sound', Tone.NONE),
    (SensorRow('ts', now=SensorView(None, 7.0, 0.1, stale=False, flagged=True)), False,
     '! flags itself invalid', Tone.DOUBT)])
def test_the_state_of_a_sensor_in_a_word(row, no_reference, words, tone):
    assert tile_state(row, no_reference) == (words, tone)


@pytest.mark.parametrize('x_deg, words', [
    (0.004, '+0.00°'), (-0.004, '+0.00°'), (-9.99, '-9.99°'), (9.996, '+10.0°'),
    (-99.94, '-99.9°'), (179.9, '+180°'), (-179.99, '-180°')])
def test_a_large_difference_has_fewer_digits_so_that_it_is_never_cut_off(x_deg, words):
    assert tell(BridgeView(difference_deg=x_deg))['difference'].text == words
    assert big_difference(x_deg) == words


@pytest.mark.parametrize('heading_deg, words', [(359.96, '000.0°'), (0.0, '000.0°'),
                                                (359.94, '359.9°')])
def test_a_heading_that_rounds_to_360_is_north(heading_deg, words):
    said = tell(BridgeView(ts=SensorView(heading_deg, heading_deg, 0.1, 10.0, 0.0, 0.0, False)))
    assert said['ts_heading'].text == words
