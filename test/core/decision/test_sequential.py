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

"""Doubling looks: their times and risks, and independence of chunks."""

from __future__ import annotations

from dataclasses import replace
import math

import numpy as np
import pytest

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import decide, gather_evidence
from heading_intercompare.core.decision.sequential import (
    find_standing,
    Looks,
    LookVerdict,
    risk_at_the_end,
)
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Norms, Risk, Sequential, Settings
from heading_intercompare.core.statistics.cells import Cells

ANY = Risk(min_duration_s=0.0)
"""Risks that allow runs of any length."""


def test_seven_looks_at_ten_hours_by_hand():
    """36000 s / 64 = 562.5 s is the first."""
    looks = Looks(36_000.0, 7, Risk(min_duration_s=500.0))
    assert [look.span_ns / 1e9 for look in looks.plan] == \
        [562.5, 1125.0, 2250.0, 4500.0, 9000.0, 18_000.0, 36_000.0]


def test_no_look_comes_before_the_least_duration_of_a_run():
    """600 s by default: of seven looks at ten hours the first is dropped, with its share."""
    plan = Looks(36_000.0, 7, Risk()).plan
    assert [look.span_ns / 1e9 for look in plan] == [1125.0 * 2 ** k for k in range(6)]
    assert [look.risk.alpha_consumer for look in plan] == pytest.approx([0.005] * 5 + [0.025])
    slow = Looks(36_000.0, 7, Risk(slowest_error_s=900.0)).plan
    assert [look.span_ns / 1e9 for look in slow] == [18_000.0, 36_000.0]
    (only,) = Looks(3600.0, 7, Risk(sensor_class='gyrocompass')).plan
    assert only.risk.alpha_consumer == 0.05 and only.span_ns == 3600 * 10 ** 9


@pytest.mark.parametrize('risk, first_s', [
    (Risk(), 600.0), (Risk(min_duration_s=60.0), 60.0), (Risk(slowest_error_s=90.0), 1800.0),
    (Risk(sensor_class='gyrocompass'), 46_000.0), (ANY, 600.0)])
def test_open_looks_begin_at_the_least_duration_of_a_run_and_double(risk, first_s):
    looks = Looks('open', 5, risk)
    assert [look.span_ns / 1e9 for look in looks.plan] == [first_s * 2 ** k for k in range(4)]
    assert (looks.number, looks.is_planned) == (5, False)


def test_seven_open_looks_by_hand():
    """Six looks have 1 / 12 of each risk; an end after three of them has 9 / 12."""
    looks = Looks('open', 7, Risk(alpha_producer=0.12))
    assert {look.risk.alpha_producer for look in looks.plan} == {0.01}
    assert [looks.risk_at_the_end(span_s).alpha_producer
            for span_s in (0.0, 599.9, 600.0, 2399.0, 2400.0, 1e9)] == pytest.approx(
        [0.12, 0.12, 0.11, 0.10, 0.09, 0.06])


@pytest.mark.parametrize('span_s', [0.0, 600.0, 5000.0, 19_200.0, 1e7])
@pytest.mark.parametrize('looks', [2, 3, 7, 20])
def test_whenever_a_run_ends_its_open_looks_and_its_end_share_the_risk(looks, span_s):
    risk = Risk(alpha_consumer=0.04, alpha_producer=0.1, count_share=0.2)
    settings = Settings(risk=risk, sequential=Sequential('open', looks))
    shares = [look.risk for look in Looks('open', looks, risk).take_due(span_s)]
    shares.append(risk_at_the_end(settings, span_s))
    assert sum(share.alpha_consumer for share in shares) == pytest.approx(0.04, rel=1e-14)
    assert sum(share.alpha_producer for share in shares) == pytest.approx(0.1, rel=1e-14)
    assert risk_at_the_end(settings).alpha_consumer == pytest.approx(0.02)
    assert {share.count_share for share in shares} == {0.2}


@pytest.mark.parametrize('plan_s', [3600.0, 100.0, None])
def test_the_risk_at_a_planned_end_does_not_depend_on_when_it_comes(plan_s):
    settings = Settings(sequential=Sequential(plan_s))
    at_the_end = risk_at_the_end(settings)
    assert at_the_end.alpha_consumer == (0.025 if plan_s == 3600.0 else 0.05)
    assert {risk_at_the_end(settings, span_s) for span_s in (0.0, 700.0, 1e6)} == {at_the_end}


def test_the_next_open_look_is_known_until_the_last_is_taken():
    looks, following = Looks('open', 3, ANY), []
    for span_s in (0.0, 600.0, 1200.0):
        looks.take_due(span_s)
        following.append(looks.next_span_ns)
    assert following == [600 * 10 ** 9, 1200 * 10 ** 9, None]


@pytest.mark.parametrize('looks', [2, 3, 7, 20])
def test_the_shares_add_up_to_the_risk(looks):
    risk = Risk(alpha_consumer=0.04, alpha_producer=0.1, count_share=0.2, min_duration_s=0.0)
    plan = Looks(1000.0, looks, risk).plan
    assert sum(look.risk.alpha_consumer for look in plan) == pytest.approx(0.04, rel=1e-14)
    assert sum(look.risk.alpha_producer for look in plan) == pytest.approx(0.1, rel=1e-14)
    assert plan[-1].risk.alpha_consumer == 0.02
    assert {look.risk.count_share for look in plan} == {0.2}


def test_each_look_is_taken_once_and_at_its_time():
    looks = Looks(80.0, 4, ANY)
    taken = [[look.index for look in looks.take_due(span)]
             for span in (0.0, 9.999999999, 10.0, 10.0, 45.0, 79.0, 80.0, 500.0)]
    assert taken == [[], [], [0], [], [1, 2], [], [3], []]
    assert looks.taken == 4


@pytest.mark.parametrize('size', [1, 7, 100, 5000])
def test_a_look_sees_the_same_samples_in_whatever_chunks(size, rng):
    start = 1_400_000_000 * 10 ** 9
    stamps = start + np.cumsum(np.append(0, rng.integers(10 ** 8, 10 ** 9, 4999)))
    for looks, end in ((Looks(2000.0, 5, ANY), 5),
                       (Looks('open', 6, Risk(min_duration_s=125.0)), 5)):
        seen = [(lo + stop, look.index) for lo in range(0, stamps.size, size)
                for stop, look in looks.cuts(start, stamps[lo:lo + size])]
        expected = [(int(np.argmax(stamps - start >= 2000 * 10 ** 9 // 2 ** (4 - k))) + 1, k)
                    for k in range(end)]
        assert seen == expected


def test_an_empty_chunk_reaches_no_look():
    assert Looks(10.0, 2, Risk()).cuts(0, np.empty(0, np.int64)) == []


@pytest.mark.parametrize('plan_s, looks, words', [
    (0.0, 7, 'sequential.plan_s = 0.0'), (math.nan, 7, 'sequential.plan_s = nan'),
    (10.0, 1, 'sequential.looks = 1')])
def test_a_plan_that_is_none_is_refused(plan_s, looks, words):
    with pytest.raises(SettingsError, match=words):
        Looks(plan_s, looks, Risk())


def test_a_risk_too_small_to_be_shared_is_refused():
    for plan_s in (10.0, 'open'):
        with pytest.raises(SettingsError, match='risk.alpha_producer = 5e-06: .* 12e-06'):
            Looks(plan_s, 7, replace(ANY, alpha_producer=5e-6))


@pytest.mark.slow
def test_looking_often_keeps_the_risk_of_white_errors(rng):
    """
    A TS at its limit is certified by any of five looks in at most 5 % of runs.

    400 runs; the bound is six standard errors of a rate of 0.05 above it.
    """
    limits = Limits.of(Norms(sigma_max_deg=1.0, sigma_ref_max_deg=0.0))
    accepted = 0
    for _ in range(400):
        x = rng.standard_normal(3200)
        for look in Looks(3200.0, 5, ANY).take_due(3200.0):
            n = look.span_ns // 10 ** 9
            evidence = gather_evidence(Cells.of(x[:n]), n_plus=0, n_plus_plus=0, span_s=float(n),
                                       mean_deg=0.0)
            if decide(evidence, limits, look.risk).outcome is Outcome.COMPLIANT:
                accepted += 1
                break
    assert accepted / 400 < 0.05 + 6.0 * math.sqrt(0.05 * 0.95 / 400)


def said(*outcomes):
    """Return looks with these results, in order."""
    return [LookVerdict(k + 1, 7, 100.0 * (k + 1), outcome, 'data_limited')
            for k, outcome in enumerate(outcomes)]


GOOD, BAD, OPEN = Outcome.COMPLIANT, Outcome.NON_COMPLIANT, Outcome.INDETERMINATE


@pytest.mark.parametrize('outcomes, look, outcome, reason', [
    ((GOOD,), 1, GOOD, 'data_limited'), ((OPEN, GOOD), 2, GOOD, 'data_limited'),
    ((GOOD, GOOD), 2, GOOD, 'data_limited'), ((GOOD, OPEN), 2, OPEN, 'not_confirmed'),
    ((GOOD, OPEN, GOOD), 3, GOOD, 'data_limited'), ((BAD,), 1, BAD, 'data_limited'),
    ((OPEN, BAD, GOOD, OPEN), 2, BAD, 'data_limited'),
    ((GOOD, BAD), 2, BAD, 'data_limited')])
def test_a_rejection_stays_and_an_acceptance_waits_to_be_confirmed(outcomes, look, outcome,
                                                                   reason):
    found = find_standing(said(*outcomes))
    assert (found.look, found.outcome, found.reason) == (look, outcome, reason)


@pytest.mark.parametrize('outcomes', [(), (OPEN,), (OPEN, OPEN)])
def test_nothing_stands_while_no_look_has_decided(outcomes):
    assert find_standing(said(*outcomes)) is None
