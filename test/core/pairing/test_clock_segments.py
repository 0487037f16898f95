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

"""A clock that is set back opens a segment: the sensor is heard on, and no pair spans the step."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.pairing.arrival_order import find_elapsed
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Compliance, Intercomparison
from heading_intercompare.core.records import Pairs

S = 10 ** 9
T0 = 1_700_000_000 * S
N, STEP, LAST = 1200, 400, 600
TRUE_DEG = np.arange(N) * 0.05 % 360.0


def set_clock(hours: float, last: int | None = LAST):
    """Return the steps of a clock: ahead or behind from reading 400 on, up to another one."""
    return lambda stamps: stamps.__setitem__(
        slice(STEP, last), stamps[STEP:last] + round(hours * 3600) * S)


def keep_clock(stamps):
    """Leave a clock alone."""


CASES = {
    'TS an hour ahead for 20 s': (set_clock(1), keep_clock, (400, 600)),
    'TS an hour behind for 20 s': (set_clock(-1), keep_clock, (400, 600)),
    'RS an hour ahead for 20 s': (keep_clock, set_clock(1), (400, 600)),
    'RS an hour behind for 20 s': (keep_clock, set_clock(-1), (400, 600)),
    'both an hour behind': (set_clock(-1, None), set_clock(-1, None), (400, 800)),
    'both half a minute behind': (set_clock(-1 / 120, None), set_clock(-1 / 120, None),
                                  (400, 800)),
    'TS an hour behind for good': (set_clock(-1, None), keep_clock, (400,)),
}


def stamps_of(set_ts, set_rs):
    """Return the stamps of two sensors at 10 Hz, the RS 20 ms later."""
    ts = T0 + np.arange(N) * S // 10
    rs = ts + S // 50
    set_ts(ts)
    set_rs(rs)
    return ts, rs


def pair_in_chunks(ts, rs, size, *, late_ts=0, late_rs=0, clock=False, method='auto'):
    """Return the pairs and the pairer; a sensor may come some readings later than the other."""
    pairer = Pairer(Settings.from_mapping({'pairing.method': method}))
    chunks = []
    for lo in range(0, N + max(late_ts, late_rs) + size, size):
        readings = [Headings.of(stamps[max(0, lo - late):max(0, lo + size - late)],
                                TRUE_DEG[max(0, lo - late):max(0, lo + size - late)])
                    for stamps, late in ((ts, late_ts), (rs, late_rs))]
        chunks.append(pairer.update(*readings, lo * 0.1 if clock else None))
    chunks.append(pairer.flush())
    return Pairs.concatenate(chunks), pairer


@pytest.mark.parametrize('method', ['auto', 'interpolate', 'interpolate_ts', 'nearest'])
@pytest.mark.parametrize('name', CASES)
def test_a_clock_set_back_opens_a_segment_however_the_streams_are_cut(name, method):
    set_ts, set_rs, counts = CASES[name]
    ts, rs = stamps_of(set_ts, set_rs)
    whole, _ = pair_in_chunks(ts, rs, N, method=method)
    assert len(set(whole.segment.tolist())) == len(counts)
    for number, count in enumerate(counts):
        # The first reading of one sensor has none of the other around it.
        assert count - 2 <= int((whole.segment == number).sum()) <= count
    for size, late_ts, late_rs in ((600, 0, 0), (300, 20, 0), (7, 0, 20), (13, 20, 0)):
        pairs, pairer = pair_in_chunks(ts, rs, size, late_ts=late_ts, late_rs=late_rs,
                                       method=method)
        assert pairs == whole or method == 'nearest'
        assert np.abs(pairs.ts_deg - pairs.rs_deg).max() <= 0.011
        assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
        assert pairer.ledger.paired == len(pairs)


@pytest.mark.parametrize('name', CASES)
def test_a_live_clock_changes_nothing(name):
    set_ts, set_rs, _ = CASES[name]
    ts, rs = stamps_of(set_ts, set_rs)
    whole, recorded = pair_in_chunks(ts, rs, N)
    for late_ts, late_rs in ((0, 0), (20, 0), (0, 20)):
        pairs, live = pair_in_chunks(ts, rs, 7, late_ts=late_ts, late_rs=late_rs, clock=True)
        assert pairs == whole
        assert live.ledger.all_set_backs == recorded.ledger.all_set_backs


def test_steps_within_the_bound_of_a_jump_open_nothing():
    """As in nbp1700_replay, whose stamps go back by 0.93 s."""
    ts, rs = stamps_of(keep_clock, keep_clock)
    ts[400:] -= 930_000_000
    pairs, pairer = pair_in_chunks(ts, rs, 7)
    assert not pairer.ledger.closed and (np.diff(pairs.stamp_ns) > 0).all()


def test_two_senders_in_turn_open_nothing():
    ts, rs = stamps_of(keep_clock, keep_clock)
    ts[1::2] -= 3600 * S
    pairs, pairer = pair_in_chunks(ts, rs, 7)
    assert not pairer.ledger.closed and len(pairs) > 590


def test_the_elapsed_time_knows_a_silence_from_a_clock_that_was_ahead():
    stamps = T0 + np.array([0, 1, 2, 3600, 3601, 7201, 7202, 3602, 3603]) * S
    elapsed_ns, spans = find_elapsed(stamps, 10 * S)
    assert (elapsed_ns // S).tolist() == [0, 1, 2, 3600, 3601, 3601, 3602, 3602, 3603]
    assert spans == [(5, 7)]
    stray = T0 + np.array([0, 1, -3598, 3, 4]) * S
    assert (find_elapsed(stray, 10 * S)[0] // S).tolist() == [0, 1, 1, 1, 2]


def hourly(rng, steps):
    """Return 20 minutes of two sensors at 10 Hz, and the settings; `steps` changes the stamps."""
    n = 12_000
    ts = T0 + np.arange(n) * S // 10
    rs = ts.copy()
    steps(ts, rs)
    settings = Settings.from_mapping({'norms.sigma_max_deg': 0.3,
                                      'norms.sigma_ref_max_deg': 0.1})
    return (Headings.of(ts, 90.0 + 0.1 * rng.standard_normal(n)),
            Headings.of(rs, 90.0 + 0.05 * rng.standard_normal(n)), settings)


def ahead(ts, rs):
    """Set the clock of the TS an hour ahead for 20 s."""
    ts[6000:6200] += 3600 * S


def summer_time(ts, rs):
    """Set both clocks back by an hour."""
    ts[6000:] -= 3600 * S
    rs[6000:] -= 3600 * S


@pytest.mark.parametrize('steps', [ahead, summer_time])
def test_the_run_ends_at_the_step_and_the_next_one_is_judged(rng, steps):
    ts, rs, settings = hourly(rng, steps)
    verdict = analyze(ts, rs, settings)
    before, after = verdict.runs
    assert (before.clock_segment, after.clock_segment) == (None, 1)
    assert before.n_input == 6000 and after.n_input in (5800, 6000)
    assert 'was set back by 3600.0 s' in before.headline and 'the run ends there' in next(
        finding.evidence for finding in before.validity if finding.condition == 'clocks')
    assert 'set back' not in after.headline
    first = 6200 if steps is ahead else 6000
    alone, = analyze(ts[first:], rs[first:], settings).runs
    assert (after.outcome, after.n_input, after.mean_deg, after.validity_effect) == (
        alone.outcome, alone.n_input, alone.mean_deg, alone.validity_effect)
    assert before.pairing.ts_received + after.pairing.ts_received == 12_000


def test_the_rows_of_a_table_count_in_every_segment(rng):
    ts, rs, settings = hourly(rng, summer_time)
    first_ns = int(ts.stamp_ns[6000])
    table = [(T0 + 60 * S, T0 + 540 * S), (first_ns + 60 * S, first_ns + 540 * S)]
    comparison = Intercomparison(settings, table=sorted(table))
    comparison.update(ts, rs)
    comparison.finish()
    runs = comparison.verdict().runs
    assert [(run.clock_segment, run.n_input) for run in runs] == [(None, 4800), (1, 4800)]


def test_a_judgement_goes_on_after_a_restart_in_a_later_segment(rng):
    ts, rs, settings = hourly(rng, summer_time)
    pairer, whole, first = Pairer(settings), Compliance(settings), Compliance(settings)
    chunks = [pairer.update(ts[lo:lo + 700], rs[lo:lo + 700]) for lo in range(0, 12_000, 700)]
    chunks.append(pairer.flush())
    for chunk in chunks:
        whole.update(chunk)
    for chunk in chunks[:-3]:
        first.update(chunk)
    state = type(first.keep()).from_text(first.keep().to_text())
    assert first.segment == 1 and state.n_judged == 1
    second = Compliance(settings)
    pairs = Pairs.concatenate(chunks[:-3])
    second.go_on(state, pairs[pairs.segment == 1])
    for chunk in chunks[-3:]:
        second.update(chunk)
    for compliance in (whole, second):
        compliance.finish()
    assert second.verdict(pairer.ledger) == whole.verdict(pairer.ledger)


@pytest.mark.parametrize('at', [400, 900])
def test_stamps_at_random_and_of_another_century_cost_no_more_than_themselves(rng, at):
    """Their steps would add up beyond 64 bits, and to millions of minutes."""
    ts, rs = stamps_of(keep_clock, keep_clock)
    ts[at:at + 100] = rng.integers(1, 2 ** 62, 100)
    pairer = Pairer(Settings())
    pairs = pairer.update(Headings.as_sent(ts, TRUE_DEG), Headings.of(rs, TRUE_DEG))
    pairs += pairer.flush()
    assert 1090 <= len(pairs) <= 1100 and not pairer.ledger.closed
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
