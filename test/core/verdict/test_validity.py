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

"""Findings that affect a verdict: situations once certified, each with outcome and words."""

from __future__ import annotations

from pathlib import Path
import re

import numpy as np
import pytest
from trials import find_finding, judge_headings

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.records import Motion
from heading_intercompare.core.validity.condition import (
    DOUBTFUL,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.verdict.validity import (
    CONDITION_WORDS,
    CONDITIONS,
    VOID_REASONS,
)
from heading_intercompare.core.verdict.verdict_document import Verdict

REFUSALS = Path(__file__).resolve().parents[3] / 'docs' / 'refusals.md'
#: Findings on all runs together, or on what is removed.
NOT_OF_EVERY_RUN = ('reduced_quality', 'drift_removed', 'mean_over_runs', 'left_out',
                    'norm_tests')
OFFSET = 'latency or clock offset'
N = 12_000
STEP_NS = 10 ** 8
STAMPS = np.arange(1, N + 1) * STEP_NS
T_S = STAMPS / 1e9
NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}


@pytest.fixture
def ship():
    """Return the heading of a ship that turns and yaws, degrees."""
    return 90.0 + 40.0 * np.sin(2.0 * np.pi * T_S / 600.0) + np.sin(2.0 * np.pi * T_S / 8.0)


@pytest.fixture
def pair(ship, rng):
    """Return the headings of a sound TS (0.1 deg) and of an RS (0.05 deg)."""
    return ship + 0.1 * rng.standard_normal(N), ship + 0.05 * rng.standard_normal(N)


def judged(ts_deg, rs_deg, stamps=STAMPS, rs_stamps=None, motion=None, **settings):
    """Return the verdict on two streams of headings."""
    return judge_headings(ts_deg, rs_deg, stamps, rs_stamps, motion=motion,
                          **{'norms': NORMS, **settings})


def effects(verdict, run=0):
    """Return the conditions of a run that do not simply hold, with their effect."""
    return {f.condition: f.effect for f in verdict.runs[run].validity
            if f.effect in (DOUBTFUL, VOID)}


def test_a_sound_sensor_is_certified_and_says_what_that_covers(pair):
    """1200 s: a twentieth is 60 s."""
    verdict = judged(*pair)
    assert effects(verdict) == {}
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == HOLDS
    assert verdict.headline.startswith(
        'COMPLIANT for errors that change within 60 s and not faster than 0.2 s, and that come at '
        'least three times in the run; slower errors are not covered; headings ')
    assert verdict.headline.endswith(
        'latitude not stated; the mean is not judged, for no norm is set for it')


def test_every_run_says_something_of_every_condition(pair):
    findings = judged(*pair).runs[0].validity
    assert [f.condition for f in findings] == [
        name for name in CONDITION_WORDS if name not in ('motion', *NOT_OF_EVERY_RUN)]
    assert all(f.evidence for f in findings)
    assert all(bool(f.words) == (f.effect in (DOUBTFUL, VOID)) for f in findings)


@pytest.mark.parametrize('condition', CONDITIONS, ids=lambda condition: condition.name)
def test_a_condition_declares_its_words_and_its_rows(condition):
    """Page, protocol, table and docs/refusals.md take them from there."""
    assert CONDITION_WORDS[condition.name] == condition.holds
    assert bool(condition.void) == bool(condition.void_when) == bool(condition.void_why)
    assert (f'void.{condition.name}' in VOID_REASONS) == bool(condition.void)
    assert condition.void or condition.doubtful_when
    rows = REFUSALS.read_text('utf-8')
    for words in filter(None, (condition.void_when, condition.doubtful_when)):
        assert f'| `{condition.name}` | {words} |' in rows


# --- void ---

def test_one_sensor_twice_is_no_comparison(pair):
    _, rs = pair
    verdict = judged(rs, rs)
    assert verdict.runs[0].reason == 'void.same_source'
    assert verdict.outcome is Outcome.INDETERMINATE
    assert verdict.headline.startswith('INDETERMINATE, VOID: ')
    # The figures are still shown.
    assert verdict.runs[0].guarded.outcome is Outcome.COMPLIANT


def same_source(verdict):
    """Return the finding of the run on one source."""
    return find_finding(verdict.runs[0], 'same_source')


def test_glitches_that_both_send_are_one_source(ship):
    """An RS without noise, and its copy, 0.5 s late."""
    rs = np.round(ship, 2)
    rs[[900, 2500, 4100, 6000]] += [3.0, -4.0, 5.0, 3.5]
    late = np.concatenate((rs[:5], rs[:-5]))
    verdict = judged(late, rs)
    assert verdict.runs[0].reason == 'void.same_source'
    assert 'follows 4 of 4 glitches of the RS, 0.5 s later' in same_source(verdict).evidence
    assert 'glitches' in VOID_REASONS['void.same_source']


def test_a_sensor_that_follows_no_glitch_of_the_rs_is_another(ship):
    rs = np.round(ship, 2)
    rs[[900, 2500, 4100, 6000]] += [3.0, -4.0, 5.0, 3.5]
    found = same_source(judged(np.round(ship + 0.02 * np.sin(T_S), 3), rs))
    assert found.effect == HOLDS
    assert found.evidence.startswith('the TS follows 0 of 4 glitches of the RS; ')


def test_equal_digits_are_one_sensor_also_without_noise(ship):
    both = np.round(ship, 2)
    verdict = judged(both, both)
    assert effects(verdict) == {'same_source': VOID}
    assert same_source(verdict).words == 'TS and RS write the same sequence of values'


def test_few_equal_digits_without_noise_are_doubted_not_void(ship):
    """Two sensors without error send such headings, and so does one sensor twice."""
    n = 250
    both = np.round(ship[:n], 2)
    found = same_source(judged(both, both, STAMPS[:n]))
    assert found.effect != HOLDS and 'too few to compare the sequences' in found.evidence


def test_a_coarse_sensor_is_not_taken_for_a_copy(ship, rng):
    """Its differences are only rounding, but it does not hold the noise of the RS."""
    verdict = judged(np.round(ship, 1), ship + 0.01 * rng.standard_normal(N))
    assert same_source(verdict).effect == NOT_TESTABLE
    assert 'is not found in the TS' in same_source(verdict).evidence
    assert 'which shows none of its own' in same_source(verdict).evidence


@pytest.mark.parametrize('turn', [90.0, -90.0, 180.0, -180.0, 178.0])
def test_a_turned_sensor_is_void_also_at_the_seam_of_the_wrap(pair, turn):
    ts, rs = pair
    verdict = judged(ts + turn, rs)
    assert verdict.runs[0].reason == 'void.convention'
    assert f'near {abs(turn):.0f}' in verdict.headline.replace('-', '')


@pytest.mark.slow
def test_a_sensor_that_counts_the_other_way_is_void(pair):
    ts, rs = pair
    for mirrored in (-ts, 90.0 - ts):
        verdict = judged(mirrored, rs)
        assert verdict.runs[0].reason == 'void.convention'
        assert verdict.headline == 'INDETERMINATE, VOID: TS turns against RS'


@pytest.mark.parametrize('yaw_deg', [0.1, 0.5])
def test_a_mirrored_sensor_on_a_steady_course_is_void(yaw_deg, rng):
    """Near 45 deg, where 90 - heading is near the heading; once rejected, or certified."""
    yaw = yaw_deg * np.sin(2.0 * np.pi * T_S / 8.0)
    noise = rng.standard_normal((2, N))
    verdict = judged(45.0 - yaw + 0.1 * noise[0], 45.0 + yaw + 0.05 * noise[1])
    assert verdict.runs[0].reason == 'void.convention'
    assert 'TS turns against RS' in verdict.headline
    sound = judged(45.0 + yaw + 0.1 * noise[0], 45.0 + yaw + 0.05 * noise[1])
    assert effects(sound) == {} and sound.outcome is Outcome.COMPLIANT


@pytest.mark.slow
def test_thirty_degrees_off_without_a_word_is_void_and_with_one_is_not(pair):
    ts, rs = pair
    verdict = judged(ts + 30.0, rs)
    assert verdict.runs[0].reason == 'void.mean_difference'
    assert 'the mean difference is 30.00 deg' in verdict.headline
    assert judged(ts + 30.0, rs, installation_offset_deg=30.0).outcome is Outcome.COMPLIANT
    assert judged(ts + 30.0, rs, detectors={'mean_max_deg': 31.0}).validity_effect == DOUBTFUL


@pytest.mark.slow
@pytest.mark.parametrize('stated, u_deg, effect', [
    (0.1, 0.0, VOID), (30.0, 0.0, VOID), (0.0, 0.1, VOID), (60.0, 0.1, HOLDS),
    (0.0, 19.9, VOID), (0.0, 20.1, DOUBTFUL), (-300.0, 0.0, HOLDS)])
def test_an_installation_angle_excuses_only_what_it_explains(pair, stated, u_deg, effect):
    """Mounted at 60 deg: void unless 3 standard uncertainties of the stated angle cover it."""
    ts, rs = pair
    verdict = judged(ts + 60.0, rs, installation_offset_deg=stated,
                     installation_offset_u_deg=u_deg)
    assert effects(verdict).get('mean_difference', HOLDS) == effect
    if effect == VOID:
        assert verdict.runs[0].reason == 'void.mean_difference'


@pytest.mark.parametrize('center, turn, effect', [
    (180.0, 0.0, VOID), (-180.0, 0.0, VOID), (180.0, 0.4, VOID), (180.0, 2.0, HOLDS),
    (0.0, 0.0, HOLDS), (90.0, 0.0, HOLDS)])
def test_differences_on_the_seam_of_the_wrap_are_void(pair, center, turn, effect):
    """The seam of 180 deg is at 0: half the differences are near 0, half near 360 deg."""
    ts, rs = pair
    verdict = judged(ts + turn, rs, wrap_center_deg=center)
    assert effects(verdict).get('convention', HOLDS) == effect
    if effect == VOID:
        assert verdict.runs[0].reason == 'void.convention'
        assert 'the differences lie on the seam of wrap_center_deg' in verdict.headline
    else:
        assert verdict.outcome is Outcome.COMPLIANT


def test_no_verdict_comes_from_the_seam_with_the_conventions_switched_off(pair):
    ts, rs = pair
    off = {'convention_tolerance_deg': 0.0, 'mean_max_deg': 180.0}
    assert judged(ts + 180.0, rs, detectors=off).runs[0].reason == 'void.convention'


def test_a_frozen_sensor_is_void_even_if_its_variance_would_be_rejected(pair):
    ts, rs = pair
    ts[4000:6000] = ts[4000]
    verdict = judged(ts, rs)
    assert verdict.runs[0].guarded.outcome is Outcome.NON_COMPLIANT
    assert verdict.runs[0].reason == 'void.frozen'
    assert 'the TS froze' in verdict.headline


def test_a_dead_sensor_alongside_is_void(rng):
    """One value with a decimal for more than an hour, the RS alive within 0.2 deg."""
    stamps = np.arange(1, 40_001) * STEP_NS
    rs = 123.4 + 0.05 * rng.standard_normal(stamps.size)
    verdict = judged(np.full(stamps.size, 123.4), rs, stamps)
    assert verdict.runs[0].reason == 'void.frozen'
    assert 'one value for an hour' in verdict.headline


def test_a_value_that_never_changes_gets_no_certificate_without_doubt(ship, rng):
    """At berth it is doubtful, because the RS shows little but noise; under way it is void."""
    rs = 90.1 + 0.05 * rng.standard_normal(N)
    verdict = judged(np.full(N, 90.1), rs)
    assert effects(verdict) == {'frozen': DOUBTFUL}
    assert 'DOUBTFUL: the TS never changed its value' in verdict.headline
    yaw = rs + 0.5 * np.sin(2.0 * np.pi * T_S / 8.0)
    verdict = judged(np.full(N, 90.1), yaw, norms={**NORMS, 'sigma_max_deg': 0.5})
    assert verdict.runs[0].reason == 'void.frozen'


@pytest.mark.parametrize('missing, effect', [(0.05, HOLDS), (0.3, DOUBTFUL), (0.6, VOID)])
def test_readings_that_no_partner_is_found_for_bind(pair, missing, effect):
    """The RS is silent for 12 s in every minute or two, longer than pairing.max_gap_s."""
    ts, rs = pair
    keep = (T_S % 60.0) >= 60.0 * missing
    verdict = judged(ts, rs[keep], rs_stamps=STAMPS[keep])
    assert effects(verdict).get('losses', HOLDS) == effect
    if effect == VOID:
        assert verdict.runs[0].reason == 'void.losses'


# --- doubtful ---

def test_one_bad_reading_is_named_and_not_called_a_slow_error(pair):
    """One of 12 000, 40 deg: 40^2 / 12000 = 0.133 deg2, three times the limit."""
    ts, rs = pair
    ts[5000] += 40.0
    verdict = judged(ts, rs)
    assert effects(verdict) == {'outliers': DOUBTFUL}
    run = verdict.runs[0]
    assert run.reason == 'outliers_decide'
    evidence = find_finding(run, 'outliers').evidence
    assert STAMPS[5000] == 500_100_000_000
    assert '+40 deg at 1970-01-01 00:08:20.100 UTC' in evidence
    assert 'without them the outcome is compliant' in evidence


def test_an_outlier_that_decides_nothing_does_not_bind(pair):
    ts, rs = pair
    ts[5000] += 1.5
    verdict = judged(ts, rs)
    assert effects(verdict) == {} and verdict.outcome is Outcome.COMPLIANT


def test_five_degrees_off_is_certified_but_doubtful(pair):
    """3 sigma_max = 0.6 deg."""
    ts, rs = pair
    verdict = judged(ts + 5.0, rs)
    assert verdict.outcome is Outcome.COMPLIANT and effects(verdict) == {
        'mean_difference': DOUBTFUL}
    assert verdict.headline.startswith('COMPLIANT, DOUBTFUL: the mean difference is 5.00 deg (for')


def test_two_constant_values_show_nothing():
    verdict = judged(np.full(N, 90.1), np.full(N, 90.0))
    assert effects(verdict) == {'standstill': DOUBTFUL}
    assert 'motion too small to tell' in verdict.headline


def test_a_skew_that_decides_gives_both_outcomes(ship, rng):
    """0.5 s at 0.555 deg/s rms of yaw adds 0.077 deg2 to 0.0125: above the limit of 0.05."""
    late = 90.0 + 40.0 * np.sin(2.0 * np.pi * (T_S - 0.5) / 600.0) + np.sin(
        2.0 * np.pi * (T_S - 0.5) / 8.0)
    verdict = judged(late + 0.1 * rng.standard_normal(N), ship + 0.05 * rng.standard_normal(N))
    assert verdict.outcome is Outcome.NON_COMPLIANT
    assert effects(verdict) == {'clocks': DOUBTFUL}
    assert f'a {OFFSET} of 0.50 s decides, without it compliant' in verdict.headline


def test_a_skew_that_decides_nothing_does_not_bind(ship, rng):
    late = 90.0 + 40.0 * np.sin(2.0 * np.pi * (T_S - 0.03) / 600.0) + np.sin(
        2.0 * np.pi * (T_S - 0.03) / 8.0)
    verdict = judged(late + 0.05 * rng.standard_normal(N), ship + 0.05 * rng.standard_normal(N))
    assert verdict.runs[0].skew.estimate.significant
    assert effects(verdict) == {} and verdict.outcome is Outcome.COMPLIANT


@pytest.mark.slow
@pytest.mark.parametrize('late_s', [0.7, 1.0, 1.3])
def test_the_alternative_that_a_headline_gives_is_that_of_the_aligned_run(late_s, rng):
    """RS headings made up at the ends of the run once called these indeterminate."""
    t = T_S + 200.0

    def heading(at_s):
        return 90.0 + 40.0 * np.sin(2.0 * np.pi * at_s / 600.0) + np.sin(
            2.0 * np.pi * at_s / 8.0)

    pair = (heading(t - late_s) + 0.1 * rng.standard_normal(N),
            heading(t) + 0.05 * rng.standard_normal(N))
    assert f'a {OFFSET} of {late_s:.2f} s decides, without it compliant' in judged(*pair).headline
    assert judged(*pair, alignment={'skew': 'apply'}).outcome is Outcome.COMPLIANT


# --- a slow part ---

@pytest.mark.slow
def test_a_drift_gets_no_certificate_and_a_negligible_slope_does(pair):
    ts, rs = pair
    ramp = np.linspace(-0.5, 0.5, N)
    drifting, hardly = judged(ts + 0.5 * ramp, rs), judged(ts + 0.02 * ramp, rs)
    assert drifting.outcome is Outcome.INDETERMINATE
    assert hardly.outcome is Outcome.COMPLIANT and effects(hardly) == {}


# --- least duration ---

def test_seven_seconds_certify_nothing(pair):
    ts, rs = pair
    verdict = judged(ts[:600], rs[:600], STAMPS[:600], pairing={'method': 'interpolate'})
    assert (verdict.outcome, verdict.runs[0].reason) == (
        Outcome.INDETERMINATE, 'insufficient_duration')


@pytest.mark.slow
def test_the_slowest_error_stated_asks_for_twenty_times_its_length(pair):
    """1199.9 s hold 20 times 59.9 s, not 20 times 61 s."""
    told = judged(*pair, risk={'slowest_error_s': 59.9}).headline
    assert told.startswith('COMPLIANT for errors that change within 60 s')
    assert '; the slowest stated is 60 s; headings ' in told
    refused = judged(*pair, risk={'slowest_error_s': 61.0})
    assert refused.runs[0].reason == 'insufficient_duration'
    assert judged(*pair, risk={'sensor_class': 'gnss_compass'}).runs[0].reason == \
        'insufficient_duration'


# --- several runs ---

@pytest.mark.slow
def test_a_void_run_leaves_the_campaign_open_unless_another_is_rejected(pair, rng):
    ts, rs = pair
    good, void = (Headings.as_sent(STAMPS, ts), Headings.as_sent(STAMPS, rs)), (
        Headings.as_sent(STAMPS, ts + 30.0), Headings.as_sent(STAMPS, rs))
    bad = Headings.as_sent(STAMPS, rs + 0.5 * rng.standard_normal(N)), Headings.as_sent(STAMPS, rs)
    settings = Settings.from_mapping({'norms': NORMS})

    def of(*inputs):
        return analyze([ts for ts, _ in inputs], [rs for _, rs in inputs], settings)

    assert of(good, good).outcome is Outcome.COMPLIANT
    opened = of(good, void)
    assert (opened.outcome, opened.campaign.reason) == (Outcome.INDETERMINATE, 'a_run_void')
    assert 'run 2: the mean difference is 30.00 deg' in opened.headline
    assert of(bad, void).outcome is Outcome.NON_COMPLIANT


@pytest.mark.slow
def test_a_campaign_with_a_doubtful_run_is_doubtful(pair):
    ts, rs = pair
    settings = Settings.from_mapping({'norms': NORMS})
    verdict = analyze([Headings.as_sent(STAMPS, ts), Headings.as_sent(STAMPS, ts + 5.0)],
                      [Headings.as_sent(STAMPS, rs)] * 2, settings)
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == DOUBTFUL
    assert 'run 2: the mean difference is 5.00 deg' in verdict.headline


# --- looks ---

@pytest.mark.slow
def test_a_good_start_does_not_certify_a_bad_sensor(ship, rng):
    """0.3 of the norm for 5 min, 3 times the norm for 55 min, plan 3600 s; once COMPLIANT."""
    t = np.arange(1, 36_001) * 0.1
    heading = 90.0 + 40.0 * np.sin(2.0 * np.pi * t / 600.0)
    sigma = np.where(t <= 300.0, 0.06, 0.6)
    rs = heading + 0.05 * rng.standard_normal(t.size)
    verdict = judged(heading + sigma * rng.standard_normal(t.size), rs,
                     np.arange(1, 36_001) * STEP_NS, sequential={'plan_s': 3600.0},
                     risk={'min_duration_s': 50.0})
    assert verdict.runs[0].looks[0].outcome is Outcome.COMPLIANT
    assert verdict.outcome is Outcome.NON_COMPLIANT


@pytest.mark.slow
def test_a_rejection_at_a_look_stays(ship, rng):
    """3 times the norm for 10 min, then so good that the whole hour would hardly be rejected."""
    t = np.arange(1, 36_001) * 0.1
    heading = 90.0 + 40.0 * np.sin(2.0 * np.pi * t / 600.0)
    sigma = np.where(t <= 600.0, 0.4, 0.05)
    verdict = judged(heading + sigma * rng.standard_normal(t.size),
                     heading + 0.02 * rng.standard_normal(t.size),
                     np.arange(1, 36_001) * STEP_NS, sequential={'plan_s': 3600.0},
                     risk={'min_duration_s': 50.0})
    run = verdict.runs[0]
    assert run.guarded.outcome is not Outcome.NON_COMPLIANT
    assert (run.outcome, run.reason) == (Outcome.NON_COMPLIANT, 'rejected_at_a_look')


def test_a_burst_of_some_seconds_is_named_where_it_decides(ship, rng):
    """Five seconds of 20 degrees in 1200 s."""
    ts, rs = ship + 0.1 * rng.standard_normal(N), ship + 0.05 * rng.standard_normal(N)
    ts[6000:6050] += 20.0
    verdict = judged(ts, rs)
    assert effects(verdict) == {'outliers': DOUBTFUL}
    assert verdict.headline == 'INDETERMINATE, DOUBTFUL: 1 isolated outlier decides'


PLAN = {'plan_s': 1200.0, 'looks': 2}
SOON = {'sequential': PLAN, 'risk': {'min_duration_s': 60.0}}


def test_the_doubt_of_a_look_that_rejected_stays_in_the_headline(ship, rng):
    """0.3 deg and a sixth of the readings lost in the first half; then 0.05 deg and none."""
    ts = ship + np.where(T_S <= 620.0, 0.3, 0.05) * rng.standard_normal(N)
    rs = ship + 0.05 * rng.standard_normal(N)
    kept = (T_S > 620.0) | (rng.random(N) > 1.0 / 6.0)
    run = judged(ts[kept], rs[kept], STAMPS[kept], **SOON).runs[0]
    look = run.looks[0]
    assert (look.outcome.value, look.validity_effect) == ('non_compliant', DOUBTFUL)
    assert re.match('NON-COMPLIANT, DOUBTFUL: 1[5-9] % lost', look.headline)
    assert run.reason == 'rejected_at_a_look'
    assert re.match('NON-COMPLIANT at look 1 of 2, after 10 min, DOUBTFUL: 1[5-9] % lost .*; at '
                    'the end (INDETERMINATE|COMPLIANT)', run.headline)
    assert run.validity_effect == DOUBTFUL


@pytest.mark.slow
def test_an_acceptance_that_is_withdrawn_is_said_to_be(ship, rng):
    ts = ship + np.where(T_S <= 620.0, 0.05, 0.3) * rng.standard_normal(N)
    run = judged(ts, ship + 0.02 * rng.standard_normal(N), **SOON).runs[0]
    assert run.looks[0].outcome.value == 'compliant'
    assert run.outcome.value != 'compliant'
    assert run.headline.endswith('; look 1 accepted, which is withdrawn')


# --- the parts ---

def test_every_void_reason_belongs_to_a_condition():
    assert {reason.partition('.')[2] for reason in VOID_REASONS} < set(CONDITION_WORDS)


# --- clocks that drift, a sensor that is too slow ---

@pytest.mark.parametrize('slope_s_per_h', [1.0, 5.0])
def test_clocks_that_drift_apart_are_void_where_that_decides(slope_s_per_h, rng):
    """Two hours: the skew grows by 2 and by 10 s."""
    t = np.arange(1, 36_000) * 0.2

    def heading(at_s):
        return 90.0 + 40.0 * np.sin(2.0 * np.pi * at_s / 600.0) + np.sin(2.0 * np.pi * at_s / 8.0)

    late = slope_s_per_h * (t / 3600.0 - 1.0)
    verdict = judged(heading(t - late) + 0.1 * rng.standard_normal(t.size),
                     heading(t) + 0.05 * rng.standard_normal(t.size),
                     np.round(t * 1e9).astype(np.int64))
    assert verdict.runs[0].reason == 'void.clocks'
    assert f'the clocks drift apart by {slope_s_per_h:.0f} s/h' in verdict.headline


def yawing(rng, rs_hz, ts_hz, method, yaw_deg, period_s, kernel='band_limited'):
    """Return the verdict on a TS of 0.02 deg and an RS of 0.02 deg of a ship that yaws."""
    def heading(at_s):
        return 90.0 + yaw_deg * np.sin(2.0 * np.pi * at_s / period_s) + 0.02 * at_s

    t, r = np.arange(1, 1200 * ts_hz) / ts_hz, np.arange(0, 1200 * rs_hz) / rs_hz + 0.3
    return judged(heading(t) + 0.02 * rng.standard_normal(t.size),
                  heading(r) + 0.02 * rng.standard_normal(r.size),
                  np.round(t * 1e9).astype(np.int64), np.round(r * 1e9).astype(np.int64),
                  norms={'sigma_max_deg': 0.1, 'sigma_ref_max_deg': 0.02},
                  pairing={'method': method, 'kernel': kernel})


@pytest.mark.parametrize('rs_hz, yaw_deg, period_s', [(0.5, 1.0, 8.0), (1.0, 2.0, 6.0)])
def test_a_slow_reference_rejects_no_sound_sensor(rs_hz, yaw_deg, period_s, rng):
    """
    A TS of a fifth of its norm, rejected before in half of the runs and in nearly all.

    With the TS put onto the stamps of the RS it is certified, and with the RS interpolated by
    eight readings. With the line the error of that is seen and makes the run void.
    """
    for method in ('auto', 'interpolate'):
        found = yawing(rng, rs_hz, 10, method, yaw_deg, period_s)
        assert found.outcome is Outcome.COMPLIANT and effects(found) == {}
    forced = yawing(rng, rs_hz, 10, 'interpolate', yaw_deg, period_s, kernel='line')
    assert forced.runs[0].guarded.outcome is not Outcome.COMPLIANT
    assert forced.runs[0].reason == 'void.interpolation'
    assert 'the slower sensor is too slow for the motion' in forced.headline


# --- skews of all sizes, and clocks that step ---

def late_pair(rng, late_s, yaw_period_s=8.0):
    """Return headings of a sound TS that is late, and of the RS, of a ship that turns and yaws."""
    def heading(at_s):
        return 90.0 + 40.0 * np.sin(2.0 * np.pi * at_s / 600.0) + np.sin(
            2.0 * np.pi * at_s / yaw_period_s)

    return (heading(T_S - late_s) + 0.1 * rng.standard_normal(N),
            heading(T_S) + 0.05 * rng.standard_normal(N))


@pytest.mark.slow
@pytest.mark.parametrize('late_s, yaw_period_s', [(1.3, 6.0), (-1.7, 6.0), (1.9, 8.0),
                                                  (1.9, 15.0)])
def test_no_skew_within_the_range_rejects_a_sound_sensor(late_s, yaw_period_s, rng):
    """From a fifth of the yaw period on, these were once rejected without a doubt."""
    ts, rs = late_pair(rng, late_s, yaw_period_s)
    verdict = judged(ts, rs)
    assert effects(verdict) == {'clocks': DOUBTFUL}
    assert f'a {OFFSET} of {late_s:.2f} s decides, without it compliant' in verdict.headline
    assert judged(ts, rs, alignment={'skew': 'apply'}).outcome is Outcome.COMPLIANT


@pytest.mark.slow
@pytest.mark.parametrize('late_s, yaw_period_s', [(2.1, 6.0), (2.1, 8.0), (3.0, 6.0),
                                                  (-3.0, 15.0), (10.0, 8.0)])
def test_a_skew_beyond_the_range_is_named(late_s, yaw_period_s, rng):
    ts, rs = late_pair(rng, late_s, yaw_period_s)
    verdict = judged(ts, rs)
    assert effects(verdict) == {'clocks': DOUBTFUL}
    assert (f'the TS may be {"late" if late_s > 0.0 else "early"} by about {abs(late_s):.1f} s, '
            'beyond alignment.skew_range_s, without that compliant') in verdict.headline
    estimate = verdict.runs[0].skew.estimate
    assert (estimate.kind, estimate.well_determined) == ('beyond', False)
    aligned = judged(ts, rs, alignment={'skew': 'apply'})
    assert effects(aligned) == {} and aligned.outcome is Outcome.COMPLIANT
    (said,) = (w for w in aligned.runs[0].warnings if 'aligned: ' in w)
    assert float(said.split()[1]) == pytest.approx(late_s, abs=0.02)


@pytest.mark.parametrize('step_s', [1.0, 5.0, -30.0])
def test_a_clock_that_steps_is_named_and_void(step_s, rng):
    ts, rs = late_pair(rng, np.where(T_S > 700.0, step_s, 0.0))
    verdict = judged(ts, rs)
    assert verdict.runs[0].reason == 'void.clocks'
    assert f'the {OFFSET} changes by {step_s:.2g} s at 1970-01-01 00:11:40' in verdict.headline


def sea(rng, n=40):
    """Return the heading as a function of time (s), of a ship that yaws in a swell and turns."""
    hz, phase = rng.normal(0.11, 0.015, n), rng.uniform(0.0, 2.0 * np.pi, n)

    def heading(at_s):
        return 90.0 + 30.0 * np.sin(at_s / 140.0) + np.sqrt(2.0 / n) * np.sin(
            2.0 * np.pi * hz * np.asarray(at_s)[:, np.newaxis] + phase).sum(axis=1)
    return heading


def apart_pair(rng, late_s, noise_deg=0.1):
    """Return the headings of a TS whose clock is apart, and of the RS, in a swell."""
    heading = sea(rng)
    return (heading(T_S - late_s) + noise_deg * rng.standard_normal(N),
            heading(T_S) + 0.05 * rng.standard_normal(N))


@pytest.mark.parametrize('late_s', [79.5, 89.1, -300.0, 400.0])
def test_clocks_that_lie_apart_are_void_and_named(late_s, rng):
    """Such a sound sensor was rejected, without a word of clocks."""
    verdict = judged(*apart_pair(rng, late_s))
    assert effects(verdict) == {'clocks': VOID}
    assert verdict.runs[0].reason == 'void.clocks'
    slow = 'RS' if late_s > 0.0 else 'TS'
    assert verdict.headline.startswith(
        f'INDETERMINATE, VOID: the clock of the {slow} lags by about {abs(late_s):.1f} s '
        f'(alignment.skew_s = {late_s:.1f} mends it), without that ')
    (assumption,) = (a for a in verdict.runs[0].assumptions if a.id == 'b')
    assert assumption.state == 'violated'
    mended = judged(*apart_pair(rng, late_s), alignment={'skew_s': late_s})
    assert effects(mended) == {}


def test_a_known_latency_is_part_of_the_setting_that_mends_clocks(rng):
    verdict = judged(*apart_pair(rng, 120.0), alignment={'skew_s': 20.0})
    assert 'lags by about 100.0 s (alignment.skew_s = 120.0 mends it)' in verdict.headline


@pytest.mark.parametrize('late_s, effect', [(79.5, VOID), (30.0, DOUBTFUL)])
def test_clocks_that_lie_apart_give_no_certificate_either(late_s, effect, rng):
    """Readings of different times hide that both come from one sensor."""
    verdict = judged(*apart_pair(rng, late_s), norms={'sigma_max_deg': 60.0,
                                                      'sigma_ref_max_deg': 0.1})
    assert effects(verdict) == {'clocks': effect}
    assert f'about {late_s:.1f} s' in verdict.headline


def test_a_bad_sensor_is_not_excused_by_clocks_that_lie_apart(rng):
    verdict = judged(*apart_pair(rng, 150.0, 0.6))
    assert effects(verdict) == {} and verdict.outcome is Outcome.NON_COMPLIANT
    assert any('clock offset of about 150.' in w for w in verdict.runs[0].warnings)


def test_sound_sensors_are_not_called_mirrored_by_clocks_that_lie_apart(rng):
    for late_s in (93.0, 97.5):
        found = judged(*apart_pair(rng, late_s)).runs[0].validity
        assert 'turns with RS' in next(f for f in found if f.condition == 'convention').evidence


def test_motion_that_repeats_itself_says_so(rng):
    """A weave of 600 s and a yaw of 8 s: 89.1 s and 510.9 s the other way are the same."""
    verdict = judged(*late_pair(rng, 89.1))
    assert effects(verdict) == {'clocks': VOID}
    assert ('the clock of the RS lags by about 89.1 s (alignment.skew_s = 89.1 mends it, or '
            in verdict.headline) and ': the motion repeats itself)' in verdict.headline


@pytest.mark.parametrize('off', [{'skew': 'off'}, {'clock_range_s': 0.0},
                                 {'clock_range_s': 100.0}])
def test_nothing_is_said_beyond_what_was_searched(off, rng):
    verdict = judged(*apart_pair(rng, 150.0), alignment=off)
    assert effects(verdict) == {}
    (assumption,) = (a for a in verdict.runs[0].assumptions if a.id == 'b')
    assert assumption.state == 'not_testable'
    assert ('nor was one found up to 100 s' in assumption.evidence) == ('100' in str(off))


@pytest.mark.parametrize('slope_s_per_h, step_s', [(5.0, 0.0), (0.0, 2.0)])
def test_clocks_that_lie_apart_and_are_unsteady_are_named_in_full(slope_s_per_h, step_s, rng):
    verdict = judged(*apart_pair(rng, 120.0 + slope_s_per_h * T_S / 3600.0
                                 + np.where(T_S > 700.0, step_s, 0.0)))
    assert verdict.runs[0].reason == 'void.clocks'
    assert 'the clock of the RS lags by about 12' in verdict.headline
    assert ('the clocks drift apart by 5' if slope_s_per_h
            else f'the {OFFSET} changes by 2 s at 1970-01-01 00:11:40') in verdict.headline


@pytest.mark.parametrize('sigma_deg, late_s', [(0.5, 0.0), (0.5, 3.0), (2.0, 0.5)])
def test_a_bad_sensor_is_not_excused_by_a_skew(sigma_deg, late_s, rng):
    ts, rs = late_pair(rng, late_s)
    verdict = judged(ts + sigma_deg * rng.standard_normal(N), rs)
    assert effects(verdict) == {} and verdict.outcome is Outcome.NON_COMPLIANT


# --- the motion of the ship ---

def sailing(ship, speed_kn=10.0, drift_deg=4.0):
    """Return the course over ground and the rate of turn of a ship, once a second."""
    rows = slice(None, None, 10)
    rate = np.gradient(np.unwrap(ship, period=360.0), T_S)[rows]
    return (Motion.of_courses(STAMPS[rows], ship[rows] + drift_deg, np.full(N // 10, speed_kn))
            + Motion.of_rates(STAMPS[rows], rate))


def legged(ship):
    """Return a ship that goes straight, turns by 120 degrees, and goes straight again."""
    return ship - 40.0 * np.sin(2.0 * np.pi * T_S / 600.0) + np.interp(
        T_S, [550.0, 650.0], [0.0, 120.0])


def of_motion(verdict):
    """Return the finding of the first run on the motion of the ship."""
    return find_finding(verdict.runs[0], 'motion')


def test_without_motion_no_finding_and_no_key(pair):
    run = judged(*pair).to_dict()['runs'][0]
    assert 'motion' not in run and 'motion' not in {f['condition'] for f in run['validity']}
    assert judged(*pair, motion=Motion.empty()).to_dict()['runs'][0] == run


def test_sound_headings_keep_their_verdict_to_the_bit_beside_the_motion(pair, ship):
    alone, beside = judged(*pair), judged(*pair, motion=sailing(ship))
    assert [f.condition for f in beside.runs[0].validity] == [
        name for name in CONDITION_WORDS if name not in NOT_OF_EVERY_RUN]
    assert of_motion(beside).effect == HOLDS and beside.runs[0].motion.kind == 'agrees'
    theirs, ours = (verdict.to_dict() for verdict in (alone, beside))
    run = ours['runs'][0]
    run['validity'] = [f for f in run['validity'] if f['condition'] != 'motion']
    del run['motion']
    assert ours == theirs


def test_both_sensors_off_together_are_void_though_their_difference_is_sound(pair, ship):
    ts, rs = (each - ship + legged(ship) for each in pair)
    motion = sailing(legged(ship))
    assert judged(ts, rs, motion=motion).outcome is Outcome.COMPLIANT
    verdict = judged(ts + 180.0, rs + 180.0, motion=motion)
    assert judged(ts + 180.0, rs + 180.0).outcome is Outcome.COMPLIANT
    assert verdict.runs[0].reason == 'void.motion' and 'void.motion' in VOID_REASONS
    assert verdict.headline.startswith(
        'INDETERMINATE, VOID: TS and RS both point 176 deg off the course over ground (mounted '
        'backwards, or the ship goes astern)')


def test_the_motion_says_which_of_two_sensors_is_wrong(pair, ship):
    ts, rs = (each - ship + legged(ship) for each in pair)
    for change, words in ((lambda: (ts + 180.0, rs), 'the TS points'),
                          (lambda: (ts, rs + 180.0), 'the RS points')):
        verdict = judged(*change(), motion=sailing(legged(ship)))
        assert effects(verdict)['convention'] == effects(verdict)['motion'] == VOID
        assert words in verdict.headline and verdict.runs[0].reason == 'void.motion'


def test_a_rejected_ts_that_contradicts_the_motion_stays_rejected(pair, ship, rng):
    """Of 60 deg off the course for half of the time nobody acquits a sensor that is too noisy."""
    ts, rs = (each - ship + legged(ship) for each in pair)
    ts = ts + 60.0 * (T_S > 700.0) + 3.0 * rng.standard_normal(N)
    verdict = judged(ts, rs, motion=sailing(legged(ship)), detectors={'mean_max_deg': 180.0})
    assert judged(ts, rs, detectors={'mean_max_deg': 180.0}).outcome is Outcome.NON_COMPLIANT
    if effects(verdict)['motion'] == DOUBTFUL:
        assert verdict.outcome is Outcome.NON_COMPLIANT
    assert 'the TS' in of_motion(verdict).words


def test_an_rs_that_contradicts_the_motion_rejects_nobody(pair, ship, rng):
    ts, rs = (each - ship + legged(ship) for each in pair)
    verdict = judged(-ts, -rs + 3.0 * rng.standard_normal(N), motion=sailing(legged(ship)))
    assert verdict.runs[0].reason == 'void.motion'
    assert verdict.outcome is Outcome.INDETERMINATE


def test_a_short_contradiction_is_a_doubt_and_decides_nothing(pair, ship):
    ts, rs = (each - ship + legged(ship) for each in pair)
    motion = sailing(legged(ship))
    turned = np.where(motion.stamp_ns > STAMPS[-2500], np.radians(90.0), 0.0)
    east = motion.east_m_s * np.cos(turned) + motion.north_m_s * np.sin(turned)
    north = motion.north_m_s * np.cos(turned) - motion.east_m_s * np.sin(turned)
    verdict = judged(ts, rs, motion=Motion.of_velocities(motion.stamp_ns, east, north))
    assert effects(verdict) == {'motion': DOUBTFUL}
    assert verdict.outcome is Outcome.COMPLIANT and verdict.validity_effect == DOUBTFUL
    assert 'COMPLIANT, DOUBTFUL: TS and RS both do not follow the course' in verdict.headline


def test_the_check_can_be_switched_off(pair, ship):
    ts, rs = pair
    motion = sailing(ship)
    off = judged(ts + 180.0, rs + 180.0, motion=motion, **{'motion.compare': False})
    assert off.outcome is Outcome.COMPLIANT and off.runs[0].motion is None


def test_the_known_installation_offset_is_removed_from_the_ts_alone(pair, ship):
    ts, rs = (each - ship + legged(ship) for each in pair)
    verdict = judged(ts + 90.0, rs, motion=sailing(legged(ship)), installation_offset_deg=90.0)
    assert of_motion(verdict).effect == HOLDS
    assert verdict.runs[0].motion.ts.off_deg == pytest.approx(-4.0, abs=0.1)


def test_a_slow_ship_is_not_testable(pair, ship):
    slow = sailing(ship, speed_kn=1.0).velocities()
    verdict = judged(*pair, motion=slow)
    assert of_motion(verdict).effect == 'not_testable' and of_motion(verdict).evidence


def test_the_motion_of_a_run_is_that_within_it(pair, ship):
    """Two runs, parted by a silence; the second goes backwards."""
    ts, rs = (each - ship + legged(ship) for each in pair)
    motion = sailing(legged(ship))
    keep = (T_S < 500.0) | (T_S > 700.0)
    wrong = 180.0 * (T_S > 700.0)
    verdict = judged((ts + wrong)[keep], (rs + wrong)[keep], STAMPS[keep], motion=motion)
    assert [run.motion.kind for run in verdict.runs] == ['agrees', 'contradicts']
    assert [run.motion.n_velocities for run in verdict.runs] == [500, 500]


def test_a_verdict_with_motion_comes_back_from_its_json(pair, ship):
    verdict = judged(*pair, motion=sailing(legged(ship)))
    assert Verdict.from_dict(verdict.to_dict()).to_dict() == verdict.to_dict()
