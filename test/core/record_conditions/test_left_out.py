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

"""Whatever is left out of the runs is counted, and binds where the record says otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.decision.taken_out import AsRecorded, Stretch, TakenOut
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.record_conditions.left_out import judge_left_out
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS

N = 15_000
T_S = np.arange(1, N + 1) / 10.0
STAMPS = 1_800_000_000 * 10 ** 9 + np.arange(1, N + 1) * 10 ** 8
SHIP = 90.0 + 30.0 * np.sin(2.0 * np.pi * T_S / 900.0) + np.sin(2.0 * np.pi * T_S / 8.0)
NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}
BAD = 5000
#: Each leaves out the first 5100 of 15000 pairs, of which 5000 are 4 deg off.
WAYS = {
    'mark': ({}, [('start', 5100)], None),
    'table': ({}, [], [(int(STAMPS[5100]), int(STAMPS[-1]) + 1)]),
    'settling': ({'runs': {'stabilization_s': 510.0}}, [], None),
    'by hand': ({'exclusions': '2027-01-15 08:00:00, 2027-01-15 08:08:30.05, because'}, [], None),
    'short': ({'runs': {'min_duration_s': 600.0}}, [('start', 1), ('stop', 5100), ('start', 5101)],
              None)}


def judge(error_deg, rng, settings=(), marks=(), table=None, chunk=N):
    """Judge a record with marks before these pairs, in chunks."""
    ts = Headings.as_sent(STAMPS, (SHIP + error_deg) % 360.0)
    rs = Headings.as_sent(STAMPS, (SHIP + 0.05 * rng.standard_normal(N)) % 360.0)
    comparison = Intercomparison(Settings.from_mapping({'norms': NORMS, **dict(settings)}),
                                 table=table)
    lo = 0
    for kind, until in (*marks, ('', N)):
        for at in range(lo, until, chunk):
            part = slice(at, min(at + chunk, until))
            comparison.update(ts[part], rs[part])
        if kind:
            comparison.mark(kind, int(STAMPS[until - 1]))
        lo = until
    comparison.finish()
    return comparison.verdict()


def judge_days(first_error_deg, second_error_deg, rng, settings):
    """Judge the records of two days as two inputs of a campaign."""
    stamps = [STAMPS, STAMPS + 86_400 * 10 ** 9]
    ts = [Headings.as_sent(stamp_ns, (SHIP + error_deg) % 360.0)
          for stamp_ns, error_deg in zip(stamps, (first_error_deg, second_error_deg))]
    rs = [Headings.as_sent(stamp_ns, (SHIP + 0.05 * rng.standard_normal(N)) % 360.0)
          for stamp_ns in stamps]
    return analyze(ts, rs, Settings.from_mapping({'norms': NORMS, **settings}))


@pytest.fixture
def good(rng):
    """Return sound errors of the TS."""
    return 0.1 * rng.standard_normal(N)


@pytest.fixture
def bad(good):
    """Return the same, 4 deg off for the first 500 s."""
    return good + np.where(np.arange(N) < BAD, 4.0, 0.0)


def test_nothing_left_out_is_no_finding(bad, rng):
    verdict = judge(bad, rng)
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.campaign, 'left_out') is None and verdict.taken_out is None


@pytest.mark.parametrize('way', WAYS)
def test_no_way_of_leaving_out_makes_a_verdict_better_in_silence(bad, rng, way):
    verdict = judge(bad, rng, *WAYS[way])
    assert verdict.outcome is Outcome.COMPLIANT
    assert find_finding(verdict.campaign, 'left_out').effect == DOUBTFUL
    assert verdict.headline.startswith('COMPLIANT, DOUBTFUL: 34 % of the pairs are left out (')
    assert ', as recorded non-compliant' in verdict.headline


@pytest.mark.parametrize('way', WAYS)
def test_what_does_not_decide_is_said_and_counted(good, rng, way):
    verdict = judge(good, rng, *WAYS[way])
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == HOLDS
    assert '34 % of the pairs are left out' in verdict.headline
    assert verdict.headline.endswith('as recorded compliant')


@pytest.mark.parametrize('way', WAYS)
def test_every_pair_has_a_row(good, rng, way):
    verdict = judge(good, rng, *WAYS[way])
    analysed = sum(run.n for run in verdict.runs)
    assert analysed + sum(s.n for s in verdict.taken_out.stretches) == N
    assert verdict.taken_out.share == pytest.approx((N - analysed) / N)


def test_rows_between_marks_have_their_times(good, rng):
    verdict = judge(good, rng, (), [('start', 100), ('stop', 8000), ('start', 9000)])
    assert [(s.n, s.reason) for s in verdict.taken_out.stretches] == [
        (100, 'outside the marks'), (1000, 'outside the marks')]
    assert verdict.taken_out.stretches[1].start_ns == STAMPS[7999]
    assert verdict.taken_out.stretches[1].end_ns == STAMPS[9000]


def test_a_warm_up_that_the_data_show_may_be_left_out(good, rng):
    """By a mark, a stated time or `auto`: its reason is in the data."""
    warm = good + 3.0 * np.exp(-T_S / 60.0)
    for settings, marks in (((), [('start', 5000)]), ({'runs': {'stabilization_s': 300.0}}, ()),
                            ({'runs': {'stabilization_s': 'auto'}}, ())):
        verdict = judge(warm, rng, settings, marks)
        assert verdict.outcome is Outcome.COMPLIANT
        assert find_finding(verdict.campaign, 'left_out').effect == HOLDS


@pytest.mark.parametrize('chunk', [1000, 3777])
def test_chunks_do_not_change_what_is_left_out(bad, chunk):
    marks = [('start', 5100), ('stop', 9000), ('start', 9500)]
    whole, cut = (judge(bad, np.random.default_rng(7), (), marks, chunk=size)
                  for size in (N, chunk))
    assert cut.to_dict() == whole.to_dict()


def test_an_open_verdict_is_not_in_doubt(good, rng):
    """Two runs of five minutes are too short to certify; the record certifies."""
    verdict = judge(good, rng, (), [('start', 1), ('stop', 3000), ('start', 3500), ('stop', 6500)])
    assert verdict.outcome is Outcome.INDETERMINATE
    assert find_finding(verdict.campaign, 'left_out').effect == HOLDS


def test_a_drift_that_is_removed_is_named_with_its_size(good, rng):
    """A quarter of a degree in half a swing, and half a degree of a line."""
    swing = good + 0.25 * np.sin(2.0 * np.pi * T_S / 3000.0)
    verdict = judge(swing, rng, {'drift_order': 3})
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == DOUBTFUL
    assert 'a drift over 0.26 deg is removed (drift_order), with it left in indeterminate' in (
        verdict.headline)
    assert judge(good, rng, {'drift_order': 3}).validity_effect == HOLDS


def test_inputs_are_accounted_for_together(bad, good, rng):
    verdict = judge_days(good, bad, rng, {'runs': {'stabilization_s': 510.0}})
    assert verdict.taken_out.n == 2 * 5100
    assert find_finding(verdict.campaign, 'left_out').effect == DOUBTFUL


def test_an_input_without_anything_left_out_counts_in_the_record(bad, good, rng):
    """The second day is bad and stays in: the record is as bad as the runs."""
    verdict = judge_days(good, bad, rng, {
        'exclusions': '2027-01-15 08:00:00, 2027-01-15 08:05:00, because'})
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert find_finding(verdict.campaign, 'left_out').effect == HOLDS
    assert verdict.taken_out.share == pytest.approx(2999 / (2 * N))
    assert verdict.taken_out.as_recorded.n == 2 * N


@pytest.mark.parametrize('sensor_class, effect', [
    ('gyrocompass', HOLDS), ('gnss_compass', DOUBTFUL)])
def test_the_settling_time_of_a_class_may_be_left_out(sensor_class, effect):
    """Two swings of a quarter of an hour, no decay, before 40 h of a good sensor at 0.1 Hz."""
    n = 14_400
    rng = np.random.default_rng(5)
    stamps = STAMPS[0] + np.arange(n) * 10 ** 10
    ship = 90.0 + 30.0 * np.sin(2.0 * np.pi * np.arange(n) / 360.0)
    error = 0.05 * rng.standard_normal(n)
    error[60:150] += 10.0
    error[200:290] -= 10.0
    verdict = analyze(
        Headings.as_sent(stamps, (ship + error) % 360.0),
        Headings.as_sent(stamps, (ship + 0.03 * rng.standard_normal(n)) % 360.0),
        Settings.from_mapping({'norms': NORMS, 'runs': {'stabilization_s': 3600.0},
                               'risk': {'sensor_class': sensor_class}}))
    assert verdict.outcome is Outcome.COMPLIANT
    assert find_finding(verdict.campaign, 'left_out').effect == effect


@pytest.mark.parametrize('as_set, as_recorded, effect', [
    ('compliant', 'compliant', HOLDS), ('compliant', 'indeterminate', DOUBTFUL),
    ('compliant', 'non_compliant', DOUBTFUL), ('non_compliant', 'non_compliant', HOLDS),
    ('non_compliant', 'compliant', DOUBTFUL), ('non_compliant', 'indeterminate', HOLDS),
    ('indeterminate', 'compliant', HOLDS), ('indeterminate', 'non_compliant', HOLDS)])
def test_another_outcome_as_recorded_is_doubtful_unless_nothing_was_decided(
        as_set, as_recorded, effect):
    recorded = AsRecorded(Outcome(as_recorded), 'holds', '', 1000, None)
    left_out = TakenOut(500, 0.5, (Stretch(1, 2, 'dock', 500),), recorded)
    finding = judge_left_out(Outcome(as_set), left_out, by_hand=False)
    assert finding.effect == effect


@pytest.mark.parametrize('share, by_hand, is_said', [
    (0.009, False, False), (0.01, False, True), (0.009, True, True)])
def test_the_headline_names_a_hundredth_and_all_that_a_person_takes_out(share, by_hand, is_said):
    recorded = AsRecorded(Outcome.COMPLIANT, 'holds', '', 1000, None)
    left_out = TakenOut(9, share, (Stretch(1, 2, 'dock', 9),), recorded)
    assert bool(judge_left_out(Outcome.COMPLIANT, left_out, by_hand).words) == is_said
