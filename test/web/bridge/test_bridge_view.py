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

"""Everything that the live page shows, message by message."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from heading_intercompare import Compliance
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_figures,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.messages.verdict_messages import encode_verdict
from heading_intercompare.web.bridge.bridge_records import Tone
from heading_intercompare.web.bridge.bridge_view import Bridge, BridgeView

S = 10 ** 9
T0 = 1_700_000_000 * S
NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.4}


def make(**names):
    return Bridge(Settings.from_mapping({**NORMS, **names}), limits_deg={'ts': 1.0})


def health(node, part='node', level=OK, message='running', started=1, namespace='', **values):
    return Status(f'{namespace}/{node}: {part}'.removeprefix('/'), level, message,
                  {key: str(value) for key, value in values.items()},
                  f'{namespace}/{node} {started}')


def alarm(name, state='active_unacknowledged', priority='warning'):
    return Status(f'compliance: {name}', WARN, f'words of {name}',
                  {'state': state, 'priority': priority, 'raised_ns': str(T0)})


def pairs(seconds, x_deg=0.1, start_s=0.0):
    stamps = T0 + np.arange(round(seconds * 10)) * (S // 10) + round(start_s * S)
    return Pairs.of(stamps, np.mod(359.95 + x_deg, 360.0) + np.zeros(len(stamps)),
                    np.full(len(stamps), 359.95))


def lit(bridge, now_s=0.0):
    """Let the graph be heard, with nothing wrong."""
    bridge.take_pairs(pairs(2.0), now_s)
    bridge.take_health([health('compliance')], now_s)
    return bridge


def compliant(runs=1, outcome=Outcome.COMPLIANT):
    return [Status('verdict', OK, 'the headline', {'outcome': str(outcome), 'validity': 'holds',
                                                   'runs': str(runs)})]


def test_before_anything_is_heard_the_page_says_so():
    view = make().view(0.0)
    assert view == BridgeView(trend=view.trend, trends=(view.trend,), rows=view.rows,
                              validity=view.validity, lamp=view.lamp)
    assert [row.title for row in view.rows] == ['Tested sensor', 'Reference']
    assert all(row.now.stale and row.difference_deg is None for row in view.rows)
    assert view.lamp.word == 'NONE YET' and view.lamp.tone is Tone.NONE
    assert view.validity.words == 'not known: the compliance node is not heard'
    assert view.graph_age_s is None and view.difference_stale and view.window.stale


def test_both_headings_and_their_signed_difference():
    bridge = make(installation_offset_deg=0.5)
    bridge.take_headings('ts', Headings.of([T0], [0.05]), T0, 10.0)
    bridge.take_headings('rs', Headings.of([T0], [359.95]), T0, 10.0)
    bridge.take_pairs(pairs(1.0), 10.0)
    view = bridge.view(10.5)
    assert (view.ts.heading_deg, view.rs.heading_deg) == (0.05, 359.95)
    assert view.difference_deg == pytest.approx(-0.4)
    assert view.difference_age_s == view.graph_age_s == 0.5


def test_what_grows_old_is_marked_and_not_shown_as_live():
    bridge = lit(make())
    bridge.take_headings('ts', Headings.of([T0], [5.0]), T0, 0.0)
    bridge.take_rolling(T0, [Status('rolling', OK, '', {'n': '5', 'std_deg': '0.1'})], 0.0)
    bridge.take_run(T0, [Status('run', OK, '', {'run': '1', 'n': '5'})], 0.0)
    young, old = bridge.view(1.0), bridge.view(4.0)
    for view, stale in ((young, False), (old, True)):
        assert view.ts.stale is view.difference_stale is view.window.stale is stale
        assert view.run.stale is view.trend.stale is view.nodes[0].stale is stale
    assert old.ts.heading_deg is None and old.ts.last_deg == 5.0
    assert old.difference_deg is None and old.last_difference_deg == pytest.approx(0.1)
    assert (old.window.age_s, old.run.age_s, old.nodes[0].age_s) == (4.0, 4.0, 4.0)
    assert not old.judged and old.validity.tone is Tone.DOUBT


def test_the_window_stands_beside_the_norm():
    """GK (5): 0.3² + 0.4² = 0.5²."""
    bridge = make()
    figures = {'n': 500, 'mean_deg': -0.02, 'std_deg': 0.2, 'limit_deg2': 0.25}
    bridge.take_rolling(*decode_statuses(encode_figures('rolling', figures, T0)), 1.0)
    window = bridge.view(1.0).window
    assert (window.n, window.mean_deg, window.std_deg) == (500, -0.02, 0.2)
    assert window.limit_deg == pytest.approx(0.5)


def test_figures_between_looks_colour_nothing_as_good_and_name_no_outcome(rng):
    """Data that would comply at once, and no verdict yet."""
    judge = Compliance(Settings.from_mapping({**NORMS, 'risk.min_duration_s': 10.0}))
    stamps = T0 + np.arange(6000) * S
    judge.update(Pairs.of(stamps, 90.0 + 0.05 * rng.standard_normal(6000), np.full(6000, 90.0)))
    bridge = lit(make())
    bridge.take_rolling(*decode_statuses(encode_figures('rolling', judge.rolling_figures(), T0)),
                        0.0)
    bridge.take_run(*decode_statuses(encode_figures('run', judge.run_figures(), T0)), 0.0)
    view = bridge.view(0.0)
    assert view.run.lacking == 'enough to accept if it goes on like this'
    assert view.lamp.word == 'NONE YET' and view.lamp.tone is Tone.NONE
    assert 'compliant' not in repr(view).lower() and 'Tone.GOOD' not in repr(view)


@pytest.mark.parametrize('marks, marked', [((), False), (('start',), True), (('stop',), True)])
def test_the_page_knows_whether_a_mark_was_set(rng, marks, marked):
    judge = Compliance(Settings.from_mapping(NORMS))
    stamps = T0 + np.arange(100) * S
    judge.update(Pairs.of(stamps[:50], np.full(50, 90.1), np.full(50, 90.0)))
    for kind in marks:
        judge.mark(kind, int(stamps[49]))
    judge.update(Pairs.of(stamps[50:], np.full(50, 90.1), np.full(50, 90.0)))
    bridge = lit(make())
    bridge.take_run(*decode_statuses(encode_figures('run', judge.run_figures(), T0)), 0.0)
    assert bridge.view(0.0).run.marked is marked


def test_the_lamp_takes_the_messages_that_compliance_publishes(rng):
    judge = Compliance(Settings.from_mapping({**NORMS, 'risk.min_duration_s': 10.0}))
    stamps = T0 + np.arange(6000) * S
    rs = 90.0 + 0.02 * rng.standard_normal(6000)
    judge.update(Pairs.of(stamps, rs + 0.05 * rng.standard_normal(6000), rs))
    judge.finish()
    verdict = judge.verdict()
    bridge = lit(make())
    bridge.take_verdict(*decode_statuses(encode_verdict(verdict, T0)), 0.0)
    lamp = bridge.view(0.0).lamp
    assert str(verdict.outcome).upper() in lamp.word and lamp.headline == verdict.headline
    assert lamp.given_ns == int(stamps[-1]) and lamp.what == 'end of run 1'


def test_the_lamp_is_good_only_while_nothing_speaks_against_the_comparison():
    bridge = lit(make())
    bridge.take_verdict(T0, compliant(), 0.0)
    assert bridge.view(0.0).lamp.tone is Tone.GOOD
    bridge.take_alarms([alarm('jump')], 0.0)
    seen = bridge.view(0.0)
    assert (seen.lamp.word, seen.lamp.tone) == ('COMPLIANT', Tone.DOUBT)
    assert seen.validity.words == 'no comparison now: words of jump'
    bridge.take_alarms([alarm('jump', 'normal')], 0.0)
    assert bridge.view(0.0).lamp.tone is Tone.GOOD
    assert bridge.view(10.0).lamp.tone is Tone.DOUBT


def test_a_rejection_stays_bad_when_nothing_is_heard():
    bridge = lit(make())
    bridge.take_verdict(T0, compliant(outcome=Outcome.NON_COMPLIANT), 0.0)
    assert bridge.view(1e6).lamp.tone is Tone.BAD


def test_alarms_stay_until_they_are_normal_and_the_gravest_is_first():
    bridge = lit(make())
    bridge.take_alarms([alarm('a', 'active_acknowledged'), alarm('b', 'rectified_unacknowledged'),
                        alarm('c', priority='caution'), alarm('d'), alarm('e', 'normal')], 0.0)
    found = bridge.view(1.0).alarms
    assert [one.name[-1] for one in found] == ['d', 'c', 'b', 'a']
    assert found[0].words == 'words of d' and found[0].raised_ns == T0
    assert [one.acknowledged for one in found] == [False, False, False, True]
    bridge.take_alarms([alarm('a', 'normal'), alarm('b', 'rectified_unacknowledged'),
                        alarm('c', priority='caution'), alarm('d', 'normal')], 0.0)
    assert [one.name[-1] for one in bridge.view(1.0).alarms] == ['c', 'b']


@pytest.mark.parametrize('owner, in_doubt, names', [
    ('', False, []), ('/compliance 5', False, []), ('/compliance 5', True, ['compliance: jump']),
    ('/ts_driver 5', False, ['compliance: jump'])])
def test_an_alarm_is_ended_by_its_own_node_while_nobody_else_may_have_sent_the_message(
        owner, in_doubt, names):
    bridge = make()
    bridge.take_alarms([replace(alarm('jump'), owner='/compliance 5')], 0.0)
    bridge.take_alarms([replace(alarm('jump', 'normal'), owner=owner)], 1.0, in_doubt=in_doubt)
    assert [seen.name for seen in bridge.view(1.0).alarms] == names


def test_a_message_holds_all_alarms_of_its_node_and_none_of_another():
    """A node that was started again does not know the nodes that its predecessor missed."""
    bridge = lit(make())
    bridge.take_alarms([alarm('recorder_silent')], 0.0)
    bridge.take_alarms([Status('synchronizer: ts_silent', WARN, '', {
        'state': 'active_unacknowledged'})], 0.0)
    assert len(bridge.view(0.0).alarms) == 2
    bridge.take_alarms([alarm('jump', 'normal')], 1.0)
    assert [shown.name for shown in bridge.view(1.0).alarms] == ['synchronizer: ts_silent']


def test_a_caution_makes_the_comparison_doubtful_not_void():
    bridge = lit(make())
    bridge.take_alarms([alarm('checksum', priority='caution')], 0.0)
    validity = bridge.view(0.0).validity
    assert validity.tone is Tone.DOUBT and 'with trouble' in validity.words


def test_an_alarm_that_is_over_but_not_acknowledged_does_not_speak_against_the_comparison():
    bridge = lit(make())
    bridge.take_alarms([alarm('jump', 'rectified_unacknowledged')], 0.0)
    seen = bridge.view(0.0)
    assert seen.validity.tone is Tone.NONE and len(seen.alarms) == 1


def test_the_run_says_what_it_lacks_and_when_the_next_look_is():
    bridge = lit(make())
    figures = {'run': 2, 'n': 900, 'span_s': 600.0, 'needed_s': 1560.0,
               'next_look_ns': T0 + 1620 * S}
    bridge.take_run(*decode_statuses(encode_figures('run', figures, T0)), 0.0)
    view = bridge.view(0.0)
    assert (view.run.number, view.run.n, view.run.span_s) == (2, 900, 600.0)
    assert view.run.lacking == '26 min more if it goes on like this'
    assert view.lamp.what == 'next look 22:40 UTC'
    bridge.take_run(T0, [Status('run', OK, '', {'run': '0', 'n': '0'})], 0.0)
    assert bridge.view(0.0).run.lacking == 'no run is in progress'


def test_nodes_with_their_worst_part():
    bridge = make()
    bridge.take_health([health('synchronizer'), health('synchronizer', 'pairing', ERROR, 'apart',
                                                       paired_share=0.97)], 0.0)
    bridge.take_health([health('recorder', 'bag', WARN, 'disk full', free_bytes=12_000_000)], 0.0)
    view = bridge.view(0.5)
    assert [(one.name, one.level, one.words) for one in view.nodes] == [
        ('recorder', WARN, 'bag: disk full'), ('synchronizer', ERROR, 'pairing: apart')]
    assert view.paired_share == 0.97
    assert (view.bag.words, view.bag.level, view.bag.free_bytes) == ('disk full', WARN, 12_000_000)
    late = bridge.view(5.0)
    assert late.paired_share is None and late.bag.stale and late.bag.level == WARN


def test_an_alarm_has_one_entry_and_not_another_beside_its_node():
    bridge = make()
    bridge.take_health([health('compliance', 'alarms', ERROR, 'jump: words of jump')], 0.0)
    bridge.take_alarms([alarm('jump')], 0.0)
    view = bridge.view(0.0)
    assert [(node.level, node.words) for node in view.nodes] == [(OK, 'running')]
    assert len(view.alerts) == 1


def test_a_restart_of_a_node_clears_the_troubles_of_the_former_one():
    bridge = make()
    bridge.take_health([health('compliance', 'run', ERROR, 'broken')], 0.0)
    bridge.take_health([health('compliance', started=2)], 1.0)
    assert [(one.level, one.words) for one in bridge.view(1.0).nodes] == [(OK, 'running')]


def test_nodes_of_another_graph_or_package_are_left_out():
    bridge = Bridge(Settings.from_mapping(NORMS), namespace='/ship1')
    bridge.take_health([health('compliance'), health('compliance', namespace='/ship2'),
                        Status('motor', ERROR, 'hot', {}, 'x'), Status('a: b', OK, '', {})], 0.0)
    assert bridge.view(0.0).nodes == () and bridge.view(0.0).graph_age_s is None
    bridge.take_health([health('compliance', namespace='/ship1')], 0.0)
    assert bridge.view(0.0).judged
    assert [one.name for one in bridge.view(0.0).nodes] == ['compliance']
    bridge = make()
    bridge.take_health([health('compliance', namespace='/ship2')], 0.0)
    assert bridge.view(0.0).nodes == ()


def test_the_mode_of_an_ahrs_if_there_is_one():
    bridge = make()
    assert bridge.view(0.0).mode is None
    bridge.take_health([health('sensor_simulator', 'ts', OK, 'gyrocompass, heading valid',
                               mode='GYROCOMPASS', validity='VALID')], 0.0)
    assert bridge.view(0.0).mode == 'TS: gyrocompass, heading valid'
    assert bridge.view(9.0).mode == 'TS: gyrocompass, heading valid, not heard'


def test_the_ledger_says_what_was_paired_and_rejected():
    bridge = make()
    segment = LedgerSegment(None, {LedgerKey.PAIRED: 90, LedgerKey.TS_INVALID: 3})
    bridge.take_ledger(LedgerMessage(Ledger.from_segments([segment], T0), False, 1), 0.0)
    view = bridge.view(0.0)
    assert (view.paired, view.rejected) == (90, 3)


def test_the_limits_stand_about_the_usual_difference_or_about_zero():
    bridge = lit(make(variant='B'))
    trend = bridge.view(0.0).trend
    assert (trend.center_deg, trend.limit_deg, trend.newest_ns) == (
        pytest.approx(0.1), 1.0, T0 + 19 * S // 10)
    assert trend.columns[-1].low_deg == pytest.approx(0.1)
    assert lit(make(variant='A')).view(0.0).trend.center_deg == 0.0


def test_a_fault_does_not_move_the_limits():
    """A step by 90 degrees for less than half of the trend, with and without an alarm."""
    for alarms in ([], [alarm('jump')]):
        bridge = make(variant='B')
        bridge.take_pairs(pairs(600.0), 0.0)
        bridge.take_health([health('compliance')], 0.0)
        assert bridge.view(0.0).trend.center_deg == pytest.approx(0.1)
        bridge.take_alarms(alarms, 0.0)
        bridge.take_pairs(pairs(400.0, 90.0, 600.0), 20.0)
        assert bridge.view(20.0).trend.center_deg == pytest.approx(0.1)
    bridge.take_pairs(pairs(700.0, 90.0, 1000.0), 40.0)
    assert bridge.view(40.0).trend.center_deg == pytest.approx(0.1), 'while the alert stands'
    bridge.take_alarms([alarm('jump', 'normal')], 60.0)
    bridge.take_pairs(pairs(10.0, 90.0, 1700.0), 60.0)
    bridge.take_health([health('compliance')], 60.0)
    assert bridge.view(60.0).trend.center_deg == pytest.approx(90.0)


def test_the_trend_names_the_stretches_without_a_comparison():
    bridge = lit(make())
    bridge.take_headings('ts', Headings.of([T0], [0.05]), T0, 0.0)
    bridge.take_alarms([alarm('jump')], 0.0)
    bridge.view(1.0), bridge.view(5.0)
    bridge.take_alarms([alarm('jump', 'normal')], 6.0)
    bridge.view(6.0)
    bridge.take_pairs(pairs(1.0, start_s=99.1), 100.0)
    (begin_s, end_s), = bridge.view(100.0).trend.doubtful
    assert (begin_s, end_s) == (pytest.approx(99.0), pytest.approx(95.0))


def test_a_trend_of_a_day_is_kept():
    bridge = make()
    for hour in range(24):
        bridge.take_pairs(pairs(2.0, 0.1 * hour, 3600.0 * hour), 0.0)
    trend = bridge.view(0.0).trend
    six, day = (columns for _, columns in trend.longer)
    assert [span_s for span_s, _ in trend.longer] == [21600.0, 86400.0]
    assert len(trend.columns) <= 2 and len(six) == 6 and len(day) == 24


def test_what_is_missing_waits_while_an_alert_stands():
    bridge = lit(make())
    figures = {'run': 2, 'n': 900, 'span_s': 600.0, 'needed_s': 2e7}
    bridge.take_run(*decode_statuses(encode_figures('run', figures, T0)), 0.0)
    assert 'more if it goes on' in bridge.view(0.0).run.lacking
    bridge.take_alarms([alarm('rotated')], 0.0)
    assert bridge.view(0.0).run.lacking == 'waits until the alert is over'


@pytest.mark.parametrize('std_deg, words', [
    (0.6, 'enough to reject if it goes on like this'),
    (0.4, 'enough to accept if it goes on like this')])
def test_enough_says_for_what(std_deg, words):
    bridge = lit(make())
    figures = {'run': 2, 'n': 900, 'span_s': 600.0, 'needed_s': 0.0, 'std_deg': std_deg,
               'limit_deg2': 0.25}
    bridge.take_run(*decode_statuses(encode_figures('run', figures, T0)), 0.0)
    assert bridge.view(0.0).run.lacking == words


def test_nothing_speaks_against_the_comparison_never_stands_beside_a_scatter_beyond_the_norm():
    bridge = lit(make())
    for std_deg, words in ((0.4, 'nothing speaks against the comparison now'),
                           (27.0, 'the scatter of the window is 54 times the norm')):
        figures = {'n': 500, 'mean_deg': 0.0, 'std_deg': std_deg, 'limit_deg2': 0.25}
        bridge.take_rolling(*decode_statuses(encode_figures('rolling', figures, T0)), 0.0)
        assert bridge.view(0.0).validity.words == words


def test_the_first_minute_counts_down_to_the_pairing():
    bridge = make(**{'pairing.method': 'auto', 'pairing.auto_s': 60.0})
    bridge.take_health([health('compliance')], 100.0)
    assert 'after 60 s of readings' in bridge.view(100.0).validity.words
    bridge.take_headings('ts', Headings.of([T0], [5.0]), T0, 100.0)
    bridge.take_health([health('compliance')], 118.0)
    seen = bridge.view(118.0).validity
    assert (seen.words, seen.tone) == ('choosing the pairing: 42 s more', Tone.NONE)
    bridge.take_health([health('compliance')], 170.0)
    assert bridge.view(170.0).validity.words == 'choosing the pairing: a moment more'


def test_the_judged_runs_are_listed_the_newest_first():
    bridge = lit(make())
    runs = [Status(f'run {number}', OK, 'why', {
        'outcome': outcome, 'validity': 'holds', 'n': '500', 'start_ns': str(T0 - 900 * S),
        'end_ns': str(T0), 'mean_deg': '0.1', 'std_deg': '0.2'})
            for number, outcome in ((1, 'compliant'), (2, 'non_compliant'))]
    bridge.take_verdict(T0, [*compliant(runs=2), *runs], 0.0)
    newest, oldest = bridge.view(0.0).runs
    assert (newest.number, newest.word, newest.tone) == (2, 'NON-COMPLIANT', Tone.BAD)
    assert (oldest.number, oldest.n, oldest.mean_deg, oldest.std_deg) == (1, 500, 0.1, 0.2)


def test_memory_is_bounded_whatever_others_say():
    bridge = make()
    for i in range(1000):
        bridge.take_health([health(f'n{i}', f'p{j}') for j in range(3)], 0.0)
        bridge.take_health([health('n0', f'q{i}', ERROR, 'x' * 5000)], 0.0)
        bridge.take_alarms([Status(f'n{i}: a', WARN, '', {'state': 'active'})], 0.0)
    bridge.take_alarms([alarm(f'a{i}') for i in range(1000)], 0.0)
    view = bridge.view(0.0)
    assert len(view.nodes) == 50 and len(view.alarms) == 200
    assert max(len(one.words) for one in view.nodes) <= 300


def test_a_node_that_ended_long_ago_is_forgotten_with_its_alarms():
    bridge = lit(make())
    bridge.take_alarms([alarm('jump')], 0.0)
    assert len(bridge.view(599.0).alarms) == 1
    view = bridge.view(601.0)
    assert view.nodes == () and view.alarms == ()
