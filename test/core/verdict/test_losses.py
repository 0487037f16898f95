# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Lost readings bind the verdict, at a look as at the end."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.verdict.losses import judge_losses
from heading_intercompare.core.verdict.validity import DOUBTFUL, HOLDS, NOT_TESTABLE, VOID

STEP_NS = 10 ** 8


@pytest.mark.parametrize('share, effect', [
    (0.1, HOLDS), (0.1001, DOUBTFUL), (0.5, DOUBTFUL), (0.5001, VOID)])
def test_losses_bind_above_their_limits_not_at_them(share, effect):
    found = judge_losses([('lost', share), ('without partner', 0.01)], Settings())
    assert found.effect == effect


def test_losses_of_a_single_pair_cannot_be_told():
    assert judge_losses([], Settings()).effect == NOT_TESTABLE


@pytest.mark.parametrize('kept, expected', [
    (0.95, 'compliant'), (0.3, 'indeterminate')])
def test_a_look_judges_the_gaps_between_the_pairs(rng, kept, expected):
    """Of an hour, only a share of the first 15 min is kept, and all of the rest."""
    stamps = np.arange(1, 36_001) * STEP_NS
    stamps = stamps[(stamps > 900 * 10 ** 9) | (rng.random(stamps.size) < kept)]
    t = stamps / 1e9
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    ts, rs = (Headings.of(stamps, ship + s * rng.standard_normal(stamps.size))
              for s in (0.1, 0.05))
    verdict = analyze(ts, rs, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1},
        'sequential': {'plan_s': 3600.0, 'looks': 3}}))
    run = verdict.runs[0]
    first, second = run.looks[:2]
    assert first.outcome.value == expected
    assert first.reason == ('void.losses' if kept < 0.5 else 'upper_bound_within_acceptance_limit')
    assert second.outcome.value == 'compliant'
    assert run.outcome.value == 'compliant'


@pytest.mark.parametrize('at, who, effect', [
    (7000, 'ts', 'void'), (7000, 'rs', 'void'), (35_900, 'ts', 'holds')])
def test_a_stamp_of_the_future_locks_the_stream_and_that_counts(rng, at, who, effect):
    """One of 36 000 readings, stamped tomorrow, makes the stamps of all later ones too early."""
    stamps = np.arange(1, 36_001) * STEP_NS
    ship = 90.0 + 40.0 * np.sin(stamps / 1e11)
    late = stamps.copy()
    late[at] += 86_400 * 10 ** 9
    heading = {s: ship + sigma * rng.standard_normal(stamps.size)
               for s, sigma in (('ts', 0.1), ('rs', 0.05))}
    streams = {s: Headings.of(late if s == who else stamps, h) for s, h in heading.items()}
    run = analyze(streams['ts'], streams['rs'], Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}})).runs[0]
    (found,) = (f for f in run.validity if f.condition == 'losses')
    assert found.effect == effect
    if effect == 'void':
        assert found.words == f'81 % of the {who.upper()} rejected'


def test_readings_rejected_between_runs_are_not_lost_from_a_run(rng):
    """At berth, after the stop mark, a TS that flags itself as invalid for an hour."""
    stamps = np.arange(1, 50_001) * STEP_NS
    ship = 90.0 + 40.0 * np.sin(stamps / 1e11)
    ts = ship + 0.1 * rng.standard_normal(stamps.size)
    ts[14_000:] = np.nan
    rs = ship + 0.05 * rng.standard_normal(stamps.size)
    run = analyze(Headings.of(stamps, ts), Headings.of(stamps, rs), Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1}})).runs[0]
    assert next(f for f in run.validity if f.condition == 'losses').effect == HOLDS
@pytest.mark.parametrize('twin', ['TS', 'RS'])
def test_a_sound_sensor_that_sends_two_sentences_a_reading_is_certified(twin, rng):
    """HDT and THS 5 ms apart: void before, with 90 % lost."""
    t = np.arange(1, 12_001) * 0.1
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    streams = []
    for name, sigma in (('TS', 0.1), ('RS', 0.05)):
        heading, at = ship + sigma * rng.standard_normal(t.size), t
        if name == twin:
            heading, at = np.repeat(heading, 2), np.sort(np.concatenate((t, t + 0.005)))
        streams.append(Headings.of(np.rint(at * 1e9).astype(np.int64), heading))
    verdict = analyze(*streams, Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    losses = next(f for f in verdict.runs[0].validity if f.condition == 'losses')
    assert (losses.effect, verdict.outcome.value) == (HOLDS, 'compliant')
