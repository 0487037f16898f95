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

"""Readings that never came have a row of their own, in the run in which they were lost."""

from __future__ import annotations

import numpy as np
import pytest
from trials import find_finding

from heading_intercompare import Headings, Settings
from heading_intercompare.core.pairing.ledger import LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Losses

STEP_NS = 10 ** 8
RULE = Settings.from_mapping({'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1},
                              'pairing': {'method': 'interpolate'}})
TS_LOST, RS_LOST = LedgerKey.TS_LOST_ON_THE_WAY, LedgerKey.RS_LOST_ON_THE_WAY


def still(stamps):
    """Return readings at some stamps."""
    return Headings.as_sent(stamps, np.full(len(stamps), 90.0))


def noisy(rng, stamps, sigma_deg=0.1):
    """Return readings of a ship that turns, at some stamps."""
    t = np.asarray(stamps) / 1e9
    ship = 90.0 + 40.0 * np.sin(t / 100.0) + np.sin(2.0 * np.pi * t / 8.0)
    return Headings.as_sent(stamps, ship + sigma_deg * rng.standard_normal(len(t)))


def losses_of(run):
    """Return the finding on the losses of a run."""
    return find_finding(run, 'losses')


def test_lost_is_not_received_and_a_burst_is_rejected():
    share = LedgerSegment(None, {'ts_lost.on_the_way': 3, 'ts_lost.at_source': 2, 'gaps.ts': 5,
                                 'ts_rejected.burst': 4, 'ts_paired': 10, 'paired': 10})
    assert share.received('ts') == 14
    assert share.lost('ts') == {'on_the_way': 3, 'at_source': 2} and share.lost('rs') == {}


@pytest.mark.parametrize('told, gaps, lost', [(73_449, 3, 3), (2, 3, 2), (73_449, 0, 0)])
def test_no_more_readings_are_lost_at_the_source_than_the_stream_has_gaps(told, gaps, lost):
    """A kernel counts datagrams, whatever they held."""
    share = LedgerSegment(None, {'ts_lost.at_source': told, 'gaps.ts': gaps, 'ts_paired': 10})
    assert share.lost('ts') == {'at_source': told} and share.lost_at_source('ts') == lost


@pytest.mark.parametrize('told, effect', [(73_449, 'holds'), (27, 'holds')])
def test_garbage_of_others_loses_no_more_than_the_gaps(rng, told, effect):
    """1224 of 1251 readings came: "98 % of the TS lost", and void."""
    stamps = np.arange(1, 1252) * 10 ** 9
    ts, rs = noisy(rng, np.delete(stamps, slice(600, 627))), noisy(rng, stamps, 0.05)
    comparison = Intercomparison(RULE)
    comparison.update(ts, rs)
    comparison.lose(LedgerKey.TS_LOST_AT_SOURCE, Losses.of(
        [628 * 10 ** 9], [600 * 10 ** 9], [told]))
    comparison.finish()
    (run,) = comparison.verdict().runs
    assert run.n == 1224 and losses_of(run).effect == effect
    assert 'of the TS lost at the source 2.2 %' in losses_of(run).evidence


def test_a_sensor_whose_readings_were_dropped_is_doubtful(rng):
    """A fifth of them, and the driver says so."""
    stamps = np.arange(1, 1252) * 10 ** 9
    kept = rng.uniform(size=1251) > 0.2
    kept[[0, -1]] = True
    comparison = Intercomparison(RULE)
    comparison.update(noisy(rng, stamps[kept]), noisy(rng, stamps, 0.05))
    comparison.lose(LedgerKey.TS_LOST_AT_SOURCE, Losses.of(
        [700 * 10 ** 9], [690 * 10 ** 9], [int(np.count_nonzero(~kept))]))
    comparison.finish()
    (run,) = comparison.verdict().runs
    assert losses_of(run).effect == 'doubtful'


@pytest.mark.parametrize('key, effect', [
    (LedgerKey.TS_REPEATED, 'holds'), (LedgerKey.TS_OLD_NUMBER, 'doubtful')])
def test_lines_whose_first_copy_was_taken_are_not_missing(rng, key, effect):
    """A second network path loses none; an old number may stand for a lost line."""
    stamps = np.arange(1, 1252) * 10 ** 9
    comparison = Intercomparison(RULE)
    comparison.update(noisy(rng, stamps), noisy(rng, stamps, 0.05))
    comparison.lose(key, Losses.of(stamps[1:], stamps[:-1], np.ones(1250, int)))
    comparison.finish()
    (run,) = comparison.verdict().runs
    assert run.pairing.rejected.ts == {key.reason: 1250}
    assert losses_of(run).effect == effect


def test_what_was_rejected_as_a_burst_is_received():
    share = LedgerSegment(None, {'ts_rejected.burst': 4, 'ts_paired': 10, 'paired': 10})
    assert share.rejected('ts') == {'burst': 4}


def test_the_ledger_balances_with_losses_and_bursts():
    pairer = Pairer(RULE)
    pairer.update(still(np.arange(1, 11) * STEP_NS), still(np.arange(1, 11) * STEP_NS))
    pairer.lose(TS_LOST, Losses.of([5 * STEP_NS], [4 * STEP_NS], [7]))
    pairer.lose(LedgerKey.TS_BURST, Losses.of([6 * STEP_NS], [0], [3]))
    pairer.flush()
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
    assert pairer.ledger.total.received('ts') == 13
    assert pairer.ledger.total.lost('ts') == {'on_the_way': 7}


@pytest.mark.parametrize('when', ['before', 'after'])
def test_it_does_not_matter_whether_a_loss_is_told_before_or_after_the_readings(when):
    """Also when the ledger has forgotten single stamps, after minutes."""
    stamps = np.arange(1, 6001) * STEP_NS
    gap = Losses.of([2000 * STEP_NS], [1998 * STEP_NS], [1])
    pairer = Pairer(RULE)
    pairer.ledger.cut(2000 * STEP_NS)
    if when == 'before':
        pairer.lose(TS_LOST, gap)
    for lo in range(0, 6000, 500):
        pairer.update(still(stamps[lo:lo + 500]), still(stamps[lo:lo + 500]))
    if when == 'after':
        pairer.lose(TS_LOST, gap)
    pairer.flush()
    at = {s.start_ns: s.lost('ts') for s in pairer.ledger.segments}
    assert at[2000 * STEP_NS] == {'on_the_way': 1} and sum(map(len, at.values())) == 1


def test_a_loss_that_is_taken_back_leaves_no_row():
    pairer = Pairer(RULE)
    for count in (5, -5):
        pairer.lose(TS_LOST, Losses.of([STEP_NS], [0], [count]))
    assert pairer.ledger.total.counts == {}


@pytest.mark.parametrize('span_s, between', [(59.9, 0), (60.1, 7)])
def test_a_gap_that_ends_a_run_belongs_to_no_run(span_s, between):
    """`runs.gap_s` is 60 s. After a shorter gap, the first reading after it gets the loss."""
    first, second = np.arange(1, 101) * STEP_NS, np.arange(1, 101) * STEP_NS
    second = second + first[-1] + round(span_s * 1e9) - STEP_NS
    stamps = np.concatenate((first, second))
    comparison = Intercomparison(RULE)
    comparison.update(still(stamps), still(stamps))
    comparison.lose(TS_LOST, Losses.of([second[0]], [first[-1]], [7]))
    comparison.finish()
    ledger = comparison.pairer.ledger
    inside = [ledger.count_between(lo, hi) for lo, hi in (
        (int(first[0]), int(first[-1])), (int(second[0]), int(second[-1])))]
    if between:
        assert [share.lost('ts') for share in inside] == [{}, {}]
    else:
        whole = ledger.count_between(int(first[0]), int(second[-1]))
        assert whole.lost('ts') == {'on_the_way': 7}


@pytest.mark.parametrize('stream', ['ts', 'rs'])
@pytest.mark.parametrize('lost, effect, outcome', [
    (0.099, 'holds', 'compliant'), (0.11, 'doubtful', 'compliant'),
    (0.51, 'void', 'indeterminate')])
def test_losses_within_the_run_bind_the_verdict(rng, stream, lost, effect, outcome):
    """The pairs do not show them: the other sensor is interpolated across the gaps."""
    stamps = np.arange(1, 12_001) * STEP_NS
    comparison = Intercomparison(RULE)
    comparison.update(noisy(rng, stamps), noisy(rng, stamps, 0.05))
    gone = round(12_000 * lost / (1.0 - lost))
    key = LedgerKey.of_lost(stream, 'on_the_way')
    comparison.lose(key, Losses.of([6000 * STEP_NS], [5999 * STEP_NS], [gone]))
    comparison.finish()
    run, = comparison.verdict().runs
    assert (losses_of(run).effect, run.outcome.value) == (effect, outcome)
    assert getattr(run.pairing.lost, stream) == {'on_the_way': gone}
    if effect != 'holds':
        assert losses_of(run).words == (
            f'{100 * lost:.0f} % of the {stream.upper()} lost on the way')


@pytest.mark.parametrize('parts, effect', [((0.04, 0.05), 'holds'), ((0.06, 0.06), 'doubtful')])
def test_what_is_lost_and_what_is_rejected_add_up(rng, parts, effect):
    stamps = np.arange(1, 12_001) * STEP_NS
    ts = noisy(rng, stamps)
    lost, rejected = (round(12_000 * part) for part in parts)
    heading = ts.heading_deg.copy()
    heading[5 * np.arange(1, rejected + 1)] = np.nan
    comparison = Intercomparison(RULE)
    comparison.update(Headings.as_sent(stamps, heading), noisy(rng, stamps, 0.05))
    comparison.lose(LedgerKey.TS_LOST_AT_SOURCE, Losses.of([6000 * STEP_NS], [0], [lost]))
    comparison.finish()
    found = losses_of(comparison.verdict().runs[0])
    assert found.effect == effect
    assert 'of the TS lost at the source or rejected' in found.evidence


@pytest.mark.parametrize('how', ['marks', 'table'])
@pytest.mark.parametrize('early', ['ts', 'rs'])
@pytest.mark.parametrize('size', [700, 40_000])
def test_a_sensor_that_starts_earlier_and_goes_on_later_is_no_loss(rng, how, early, size):
    """The run is open while the one sends; the other sends a third of that time."""
    long = np.arange(1, 36_001) * STEP_NS
    short = long[12_000:24_000]
    stamps = {'ts': long, 'rs': short} if early == 'ts' else {'ts': short, 'rs': long}
    rule = Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 0.1},
        'pairing': {'method': 'interpolate' if early == 'ts' else 'interpolate_ts'}})
    table = [(int(long[0]), int(long[-1]) + 1)] if how == 'table' else None
    comparison = Intercomparison(rule, table=table)
    if how == 'marks':
        comparison.mark('start', 0)
        comparison.mark('stop', int(long[-1]))
    readings = {s: noisy(rng, stamps[s], sigma) for s, sigma in (('ts', 0.1), ('rs', 0.05))}
    for lo in range(0, 36_000, size):
        hi = long[min(lo + size, 36_000) - 1]
        part = {s: readings[s][(stamps[s] >= long[lo]) & (stamps[s] <= hi)] for s in readings}
        comparison.update(**part)
    comparison.lose(LedgerKey.of_lost(early, 'on_the_way'),
                    Losses.of([100 * STEP_NS, 30_000 * STEP_NS], [0, 0], [9000, 9000]))
    comparison.finish()
    run, = comparison.verdict().runs
    assert run.n == 12_000
    assert losses_of(run).effect == 'holds', losses_of(run)


@pytest.mark.slow
@pytest.mark.parametrize('size, share, effect', [
    (1, 0.2, 'doubtful'), (7, 0.05, 'holds'), (7, 0.6, 'void'),
    (12_000, 0.05, 'holds'), (12_000, 0.2, 'doubtful'), (12_000, 0.6, 'void')])
def test_readings_without_a_stamp_count_in_the_run_in_which_they_came(rng, size, share, effect):
    """They fell before all runs, so an RS that stamps 4 of 10 readings was without doubt."""
    stamps = np.arange(1, 12_001) * STEP_NS
    unstamped = rng.permutation(12_000) < round(12_000 * share)
    unstamped[0] = False
    if size < 12_000:
        stamps, unstamped = stamps[:1500], unstamped[:1500]
    rs = noisy(rng, stamps, 0.05)
    rs = Headings.as_sent(np.where(unstamped, 0, stamps), rs.heading_deg)
    ts = noisy(rng, stamps)
    comparison = Intercomparison(RULE)
    for lo in range(0, len(stamps), size):
        comparison.update(ts[lo:lo + size], rs[lo:lo + size])
    comparison.finish()
    run, = comparison.verdict().runs
    ledger = comparison.pairer.ledger
    assert ledger.segments[0].counts == {} and ledger.balance() == {'ts': 0, 'rs': 0}
    assert run.pairing.rejected.rs == {'no_stamp': int(unstamped.sum())}
    assert losses_of(run).effect == effect
