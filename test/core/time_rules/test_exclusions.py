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

"""Stretches taken out by hand: the table, and that no verdict gets better in silence."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import (
    analyze,
    Compliance,
    Headings,
    Intercomparison,
    join,
    pair,
    Settings,
    SettingsError,
    Verdict,
)
from heading_intercompare.core.kept_state import KeptState
from heading_intercompare.core.time_rules.exclusions import (
    Exclusion,
    find_excluded,
    read_exclusions,
)

START_S = 1_700_000_000
BASE = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, risk_min_duration_s=600.0)


def excluding(*rows):
    """Return settings that take out rows of (start_s, end_s, reason) after the start."""
    return replace(BASE, exclusions='; '.join(
        f'{(START_S + a) * 10 ** 9}, {(START_S + b) * 10 ** 9}, {why}' for a, b, why in rows))


@pytest.fixture
def readings(rng):
    """Return a function: readings of 6000 s, with more noise between two seconds."""
    def make(bad=(2000, 2300), bad_deg=3.0):
        stamps = (START_S + np.arange(6000)) * 10 ** 9
        true = 180.0 + 170.0 * np.sin(np.arange(6000) / 40.0)
        x = rng.normal(0.05, 0.15, 6000)
        # Bad by noise, so that no detector of its own has a say.
        x[bad[0]:bad[1]] += rng.normal(0.0, bad_deg, bad[1] - bad[0])
        return Headings.of(stamps, true + x), Headings.of(stamps, true)
    return make


@pytest.mark.parametrize('text', [
    '2026-05-01T10:00Z, 2026-05-01T10:20:00.5Z, RS in dock mode, by order',
    'start, end, reason\n2026-05-01 10:00, 2026-05-01T10:20:00.5, RS in dock mode, by order\n',
    '1777629600000000000,1777630800500000000,RS in dock mode, by order;'])
def test_a_row_has_start_end_and_reason(text):
    """10:00 UTC on 2026-05-01 is 1 777 629 600 s."""
    assert read_exclusions(text) == (Exclusion(
        1_777_629_600 * 10 ** 9, 1_777_630_800_500_000_000, 'RS in dock mode, by order'),)


def test_no_table_takes_out_nothing():
    assert read_exclusions(None) == read_exclusions('') == read_exclusions(' ;\n') == ()
    assert find_excluded(np.array([1, 2]), ()).tolist() == [-1, -1]


@pytest.mark.parametrize('text, why', [
    ('1, 2', r"row 1: '1, 2': must be start, end, reason; a stretch is taken out only with its"),
    ('1, 2, ', 'row 1: .*only with its reason'),
    ('1, 2, a; 9, 8, b', 'row 2: end 8 is not after start 9'),
    ('1, 1, a', 'row 1: end 1 is not after start 1'),
    ('1, 5, a; 4, 8, b', 'row 2: .* overlaps .*; join them to one row'),
    ('noon, 5, a', "row 1: 'noon' is neither ISO UTC"),
    ('2026-13-01T10:00, 5, a', "row 1: '2026-13-01T10:00' is neither ISO UTC"),
    ('1, 99999999999999999999, a', "row 1: '99999999999999999999' is neither ISO UTC"),
    ('1, 2, ' + 'x' * 201, 'row 1: the reason has 201 characters'),
])
def test_a_wrong_row_is_one_clear_line(text, why):
    with pytest.raises(SettingsError, match='^exclusions, ' + why) as caught:
        replace(BASE, exclusions=text)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('text', ['1970-01-01T00:00Z', '2000-02-29T23:59:59.123456789Z',
                                  '2026-12-31T12:34:56Z', '2100-03-01T00:00', '2024-08-31T01:02'])
def test_the_calendar_is_that_of_numpy(text):
    (row,) = read_exclusions(f'{text}, 2150-01-01T00:00Z, why')
    assert row.start_ns == np.datetime64(text.rstrip('Z'), 'ns').astype(np.int64)


def test_a_day_that_does_not_exist_is_no_time():
    for text in ('2100-02-29T00:00Z', '2026-04-31T00:00Z', '2026-01-01T24:00Z',
                 '2026-01-01T10:60', '2026-00-10T00:00', '2026-01-00T00:00',
                 '2026-01-01T10:00:60'):
        with pytest.raises(ValueError, match=f"row 1: '{text}' is neither"):
            read_exclusions(f'{text}, 2150-01-01T00:00Z, why')


def test_rows_that_touch_do_not_overlap_and_an_end_does_not_belong():
    rows = read_exclusions('20, 30, b; 10, 20, a')
    assert [row.reason for row in rows] == ['a', 'b']
    assert find_excluded(np.array([9, 10, 19, 20, 29, 30]), rows).tolist() == [-1, 0, 0, 1, 1, -1]


def test_a_better_verdict_is_doubtful_and_says_what_it_would_be(readings):
    ts, rs = readings(bad=(1000, 4600), bad_deg=1.0)
    verdict = analyze(ts, rs, excluding((1000, 4600, 'RS in dock mode')))
    recorded = analyze(ts, rs, BASE)
    assert recorded.outcome.value == 'non_compliant' and verdict.outcome.value == 'compliant'
    assert verdict.validity_effect == 'doubtful'
    assert verdict.headline.startswith(
        'COMPLIANT, DOUBTFUL: 60 % of the pairs are left out (RS in dock mode), as recorded '
        'non-compliant')
    assert verdict.taken_out.as_recorded.outcome is recorded.outcome
    assert verdict.taken_out.as_recorded.n == recorded.runs[0].n


def test_the_judgement_is_that_of_the_rest(readings):
    """The figures are those of the differences that stay; the ledger counts the others."""
    ts, rs = readings()
    run = analyze(ts, rs, excluding((2000, 2300, 'dock'), (100, 200, 'tug'))).runs[0]
    x = pair(ts, rs, BASE)[0]
    t = (x.stamp_ns // 10 ** 9) - START_S
    rest = ((t < 2000) | (t >= 2300)) & ((t < 100) | (t >= 200))
    kept = (x.ts_deg - x.rs_deg)[rest]
    assert run.variance_deg2 == pytest.approx(np.var(kept, ddof=1), rel=1e-9)
    assert (run.n_input, run.n, run.taken_out.n) == (6000, 5600, 400)
    assert run.taken_out.share == pytest.approx(400 / 6000)
    assert [(one.reason, one.n) for one in run.taken_out.stretches] == [('tug', 100),
                                                                       ('dock', 300)]
    assert run.n_input == run.n + run.n_invalid + run.n_stabilization + run.taken_out.n


def test_what_is_taken_out_is_not_lost_and_does_not_count_as_time(readings):
    ts, rs = readings(bad=(0, 0))
    run, whole = (analyze(ts, rs, settings).runs[0]
                  for settings in (excluding((1000, 4000, 'half of it')), BASE))
    losses = [find_finding(one, 'losses') for one in (run, whole)]
    assert losses[0] == losses[1] and losses[0].effect == 'holds'
    assert whole.coverage.longest_s / run.coverage.longest_s == pytest.approx(2.0, rel=0.01)
    short = analyze(ts, rs, replace(excluding((300, 5800, 'nearly all')))).runs[0]
    assert short.outcome.value == 'indeterminate' and short.reason == 'insufficient_duration'


def test_the_same_outcome_is_also_said(readings):
    ts, rs = readings(bad=(0, 0))
    verdict = analyze(ts, rs, excluding((1000, 1060, 'a tug alongside')))
    assert verdict.outcome.value == 'compliant' and verdict.validity_effect == 'holds'
    assert verdict.headline.endswith(
        '; 1 % of the pairs are left out (a tug alongside), as recorded compliant')
    finding = find_finding(verdict.campaign, 'left_out')
    assert finding.effect == 'holds' and finding.evidence.startswith('60 pairs, ')


def test_a_worse_verdict_says_what_is_left_out(readings):
    ts, rs = readings(bad=(0, 0))
    verdict = analyze(ts, rs, excluding((100, 5990, 'nearly all of it')))
    assert verdict.outcome.value == 'indeterminate'
    assert verdict.headline.endswith(
        '; 98 % of the pairs are left out (nearly all of it), as recorded compliant')


def test_all_taken_out_is_indeterminate(readings):
    ts, rs = readings(bad=(0, 0))
    verdict = analyze(ts, rs, excluding((-10, 7000, 'all of it')))
    assert (verdict.outcome.value, verdict.runs[0].n) == ('indeterminate', 0)
    assert '; 100 % of the pairs are left out' in verdict.headline


def test_an_exclusion_outside_of_the_record_leaves_out_nothing(readings):
    ts, rs = readings(bad=(0, 0))
    verdict, plain = analyze(ts, rs, excluding((9000, 9100, 'later'))), analyze(ts, rs, BASE)
    assert verdict.taken_out is None
    assert verdict.headline == plain.headline and verdict.runs == plain.runs


def test_several_runs_say_both_together(readings):
    disturbed, sound = readings(), readings(bad=(0, 0))
    later = [Headings.of(h.stamp_ns + 100_000 * 10 ** 9, h.heading_deg) for h in sound]
    verdict = analyze([disturbed[0], later[0]], [disturbed[1], later[1]],
                      excluding((2000, 2300, 'dock')))
    assert verdict.outcome.value == 'compliant' and verdict.runs[1].taken_out is None
    assert verdict.headline.startswith(
        'COMPLIANT, DOUBTFUL: 2.5 % of the pairs are left out (dock), as recorded indeterminate')
    assert verdict.taken_out.n == 300


def test_it_is_the_same_in_chunks_and_after_a_restart(readings):
    ts, rs = readings()
    settings = excluding((2000, 2300, 'dock'), (4000, 4100, 'tug'))
    whole = Intercomparison(settings)
    whole.update(ts, rs)
    whole.finish()
    pairs = pair(ts, rs, settings)[0]
    first = Compliance(settings)
    for lo in range(0, 3000, 7):
        first.update(pairs[lo:min(lo + 7, 3000)])
    second = Compliance(settings)
    second.go_on(KeptState.from_text(first.keep().to_text()), pairs[:3000])
    second.update(pairs[3000:])
    second.finish()
    third = Compliance(settings)
    third.go_on(KeptState.from_text(second.keep().to_text()), pairs[:0])
    assert third.verdict().to_dict() == second.verdict().to_dict()
    verdicts = [second.verdict(), whole.verdict()]
    assert verdicts[0].runs[0].variance_deg2 == pytest.approx(
        verdicts[1].runs[0].variance_deg2, rel=1e-12)
    assert verdicts[0].runs[0].taken_out == verdicts[1].runs[0].taken_out
    assert verdicts[0].taken_out == verdicts[1].taken_out


def test_a_look_at_a_run_does_not_hide_what_is_left_out(readings):
    ts, rs = readings(bad=(300, 5000), bad_deg=1.0)
    settings = replace(excluding((300, 5000, 'dock')), sequential=replace(
        BASE.sequential, plan_s=12_000.0))
    verdict = analyze(ts, rs, settings)
    assert verdict.runs[0].looks and verdict.taken_out.n == 4700
    assert verdict.taken_out.as_recorded.outcome.value == 'non_compliant'


def test_the_document_holds_it_and_reads_it_back(readings):
    ts, rs = readings()
    verdict = analyze(ts, rs, excluding((2000, 2300, 'RS in dock mode')))
    mapping = verdict.to_dict()
    assert mapping['taken_out']['stretches'] == [{
        'start_ns': (START_S + 2000) * 10 ** 9, 'end_ns': (START_S + 2300) * 10 ** 9,
        'reason': 'RS in dock mode', 'n': 300}]
    assert mapping['taken_out']['as_recorded']['outcome'] == 'indeterminate'
    assert Verdict.from_dict(mapping).to_dict() == mapping
    plain = analyze(ts, rs, BASE).to_dict()
    assert 'taken_out' not in plain and plain['settings']['exclusions'] is None
    assert all('taken_out' not in run for run in plain['runs'])


def test_without_a_run_nothing_is_left_out():
    verdict = join([], excluding((0, 10, 'dock')))
    assert verdict.outcome.value == 'indeterminate' and verdict.taken_out is None
