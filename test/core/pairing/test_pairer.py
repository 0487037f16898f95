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

"""Pairing: by hand, against a slow independent pairing, and by properties of the streams."""

from __future__ import annotations

from collections import Counter
import json

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.pairing import pairer as pairing
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.direction import usual_step_ns
from heading_intercompare.core.pairing.interpolation_kernel import longest_step_ns
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment, REASONS
from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

S = 1_000_000_000
METHODS = ['auto', 'interpolate', 'interpolate_ts', 'nearest']


def rules(method='interpolate', jump_s=100.0, **more):
    """Return settings; no step of the short streams here is a jump."""
    names = {'gap_s': 'runs.gap_s', 'skew_s': 'alignment.skew_s'}
    mapping = {names.get(k, f'pairing.{k}'): v for k, v in more.items()}
    return Settings.from_mapping({'pairing.method': method, 'pairing.jump_s': jump_s, **mapping})


def headings(*rows):
    return Headings.as_sent([s for s, _ in rows] or np.empty(0, int), [h for _, h in rows])


# Stamps on a coarse grid make ties, duplicates and steps backwards common.
stamps = st.integers(-2, 60).map(lambda k: k * S // 4)
values = st.one_of(st.floats(0.0, 360.0), st.sampled_from([np.nan, np.inf, -1.0, 400.0, 360.0]))
streams = st.lists(st.tuples(stamps, values), max_size=40).map(lambda rows: headings(*rows))
sorted_streams = st.lists(st.tuples(st.integers(1, 4000), st.floats(0.0, 359.9)), max_size=60) \
    .map(lambda rows: headings(*sorted((t * S // 50, h) for t, h in rows)))


def slow_accepted(stream):
    """Return the accepted readings and the reasons of the others, one by one."""
    kept, reasons, last = [], Counter(), None
    for stamp, heading in zip(stream.stamp_ns.tolist(), stream.heading_deg.tolist()):
        if stamp <= 0:
            reasons['no_stamp'] += 1
        elif not np.isfinite(heading):
            reasons['invalid'] += 1
        elif not 0.0 <= heading <= 360.0:
            reasons['out_of_range'] += 1
        elif last is not None and stamp <= last:
            reasons['stamp_not_increasing'] += 1
        else:
            kept.append((stamp, heading % 360.0))
            last = stamp
    return kept, reasons


def slow_weights(s, side):
    """Return the weights of readings at places s, in steps from the stamp: P.4 as it stands."""
    band = {2: 1.6, 3: 1.6, 4: 1.8}[side]
    m = len(s)
    left, right = np.zeros((m + 4, m + 4)), np.zeros(m + 4)
    for k in range(m):
        for j in range(m):
            left[k, j] = np.sinc(band * (s[k] - s[j]) / np.pi) + 1e-5 * (k == j)
        for p in range(4):
            left[k, m + p] = left[m + p, k] = (s[k] / side) ** p
        right[k] = np.sinc(band * s[k] / np.pi)
    right[m] = 1.0
    return np.linalg.solve(left, right)[:m]


def slow_interpolate(ts, rs, max_gap_ns, kernel='line'):
    """Interpolate each TS reading on its own: nearest readings, one kernel after the other."""
    result = []
    step_ns = usual_step_ns(np.array([r[0] for r in rs])) or 0
    longest_ns = min(max_gap_ns, longest_step_ns(step_ns))
    sides = (1,) if kernel == 'line' else (2, 1) if step_ns <= S // 4 else (
        (4, 3, 2) if step_ns <= S // 2 else (4, 3))
    for t, h in ts:
        at = [r for r in rs if r[0] == t]
        if at:
            result.append((t, h, at[0][1]))
            continue
        for side in sides:
            used = [r for r in rs if r[0] < t][-side:] + [r for r in rs if r[0] > t][:side]
            near = [r[0] for r in used]
            if len(used) < 2 * side or near[side - 1] > t or max(np.diff(near)) > longest_ns:
                continue
            s = [(r - t) / step_ns for r in near]
            c = [1.0 - (t - near[0]) / (near[1] - near[0]), (t - near[0]) / (near[1] - near[0])] \
                if side == 1 else slow_weights(s, side)
            if side > 1 and sum(w * w for w in c) > 1.2:
                continue
            turned = np.cumsum([0.0, *(float(wrap180(b[1] - a[1]))
                                       for a, b in zip(used, used[1:]))])
            result.append((t, h, used[0][1] + float(np.dot(c, turned))))
            break
    return result


def slow_nearest(ts, rs, tolerance_ns):
    result = []
    for t, h in ts:
        if not rs:
            continue
        r = min(rs, key=lambda r: (abs(r[0] - t), r[0]))
        back = min(ts, key=lambda q: (abs(q[0] - r[0]), q[0]))
        if back[0] == t and abs(r[0] - t) <= tolerance_ns:
            result.append((t, h, r[1]))
    return result


#: Streams of about 0.1 to 1.5 s a reading, with jitter and gaps.
steady_streams = st.builds(
    lambda step, jitter, missing, n, seed: steady(step, jitter, missing, n, seed),
    st.sampled_from([0.1, 0.25, 0.4, 1.0, 1.5]), st.floats(0.0, 0.45), st.floats(0.0, 0.3),
    st.integers(2, 50), st.integers(0, 1000))


def steady(step_s, jitter, missing, n, seed):
    """Return readings of a sensor with a usual step."""
    random = np.random.default_rng(seed)
    places = np.arange(1, n + 1) + jitter * random.uniform(-1.0, 1.0, n) + random.uniform()
    kept = random.uniform(size=n) >= missing
    stamps = np.round(places[kept] * step_s * 1e9).astype(np.int64)
    return Headings.as_sent(stamps, random.uniform(0.0, 30.0, stamps.size))


@pytest.mark.slow
@pytest.mark.parametrize('kernel', ['line', 'band_limited'])
@given(ts=st.one_of(streams, steady_streams), rs=st.one_of(streams, steady_streams))
def test_interpolated_pairs_are_those_of_the_slow_way(kernel, ts, rs):
    pairs, _ = pair(ts, rs, rules(max_gap_s=1.5, kernel=kernel))
    slow = slow_interpolate(slow_accepted(ts)[0], slow_accepted(rs)[0], round(1.5 * S), kernel)
    assert pairs.stamp_ns.tolist() == [t for t, _, _ in slow]
    assert np.abs(wrap180(pairs.rs_deg - [r for _, _, r in slow])).max(initial=0.0) < 1e-7
    assert pairs.ts_deg.tolist() == [h for _, h, _ in slow]


@pytest.mark.slow
@given(streams, streams)
def test_a_ts_put_onto_the_rs_is_the_rs_put_onto_the_ts_with_names_exchanged(ts, rs):
    pairs, ledger = pair(ts, rs, rules('interpolate_ts', max_gap_s=1.5))
    other, exchanged = pair(rs, ts, rules('interpolate', max_gap_s=1.5))
    assert pairs == Pairs(other.stamp_ns, other.rs_deg, other.ts_deg, other.lag_ns,
                          other.ts_variance_factor, other.rs_variance_factor, other.segment)
    counts, others = ledger.total.counts, exchanged.total.counts
    assert counts.get('rs_used', 0) == others.get('ts_paired', 0) == len(pairs)
    assert counts.get('ts_paired', 0) + counts.get('ts_used', 0) == others.get('rs_used', 0)
    assert counts.get('rs_unbridged', 0) == others.get('ts_unbridged', 0)


@pytest.mark.slow
@given(streams, streams, st.sampled_from([0.0, 0.25, 1.0, 5.0]))
def test_nearest_pairs_are_those_of_the_slow_way(ts, rs, tolerance_s):
    pairs, _ = pair(ts, rs, rules('nearest', tolerance_s=tolerance_s))
    slow = slow_nearest(slow_accepted(ts)[0], slow_accepted(rs)[0], round(tolerance_s * S))
    got = list(zip(pairs.stamp_ns.tolist(), pairs.ts_deg.tolist(), pairs.rs_deg.tolist()))
    assert got == slow


@pytest.mark.slow
@pytest.mark.parametrize('method', METHODS)
@given(ts=streams, rs=streams)
def test_the_ledger_accounts_for_every_reading(method, ts, rs):
    pairs, ledger = pair(ts, rs, rules(method, tolerance_s=0.5))
    assert ledger.balance() == {'ts': 0, 'rs': 0}
    counts = ledger.total.counts
    assert counts.get('paired', 0) == len(pairs)
    assert 'ts_pending' not in counts and 'rs_pending' not in counts
    for name, stream in (('ts', ts), ('rs', rs)):
        kept, reasons = slow_accepted(stream)
        for reason, n in reasons.items():
            assert counts[f'{name}_rejected.{reason}'] == n
        booked = sum(n for key, n in counts.items()
                     if key.startswith(f'{name}_') and 'rejected' not in key)
        assert booked == len(kept)


@pytest.mark.slow
@pytest.mark.parametrize('method', METHODS)
@given(ts=sorted_streams, rs=sorted_streams, data=st.data())
def test_chunks_and_order_of_arrival_do_not_matter(method, ts, rs, data):
    # Streams of up to 80 s: several stretches, each watched for 4 s.
    some = rules(method, tolerance_s=0.3, gap_s=5.0, auto_s=4.0)
    whole, ledger = pair(ts, rs, some)
    pairer = Pairer(some)
    chunks, at = [], {'ts': 0, 'rs': 0}
    streams_ = {'ts': ts, 'rs': rs}
    while at['ts'] < len(ts) or at['rs'] < len(rs):
        name = data.draw(st.sampled_from([s for s in at if at[s] < len(streams_[s])]))
        n = data.draw(st.integers(1, 15))
        chunk = streams_[name][at[name]:at[name] + n]
        at[name] += n
        chunks.append(pairer.update(**{name: chunk}))
        assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}
    chunks.append(pairer.flush())
    assert Pairs.concatenate(chunks) == whole
    assert pairer.ledger.segments == ledger.segments


@pytest.mark.slow
@pytest.mark.parametrize('method', METHODS)
@given(ts=sorted_streams, rs=sorted_streams, turn=st.integers(0, 359))
def test_a_constant_added_to_both_headings_leaves_the_differences(method, ts, rs, turn):
    # Headings on a binary grid, so that the addition itself is exact.
    ts, rs = (Headings.as_sent(s.stamp_ns, np.round(s.heading_deg * 1024) / 1024 % 360)
              for s in (ts, rs))
    plain = subtract(pair(ts, rs, rules(method, tolerance_s=0.3))[0])
    turned = [Headings.as_sent(s.stamp_ns, (s.heading_deg + turn) % 360) for s in (ts, rs)]
    x = subtract(pair(*turned, rules(method, tolerance_s=0.3))[0])
    assert np.array_equal(x.stamp_ns, plain.stamp_ns)
    assert np.abs(wrap180(x.x_deg - plain.x_deg)).max(initial=0.0) < 1e-11


@pytest.mark.parametrize('broken', ['nothing', 'gap', 'same stamp', 'missing TS', 'missing RS'])
@pytest.mark.parametrize('method', ['interpolate', 'interpolate_ts'])
def test_streams_that_alternate_are_paired_as_any_others(rng, monkeypatch, method, broken):
    """To the bit, with the same ledger, whatever is wrong in one of ten chunks."""
    n = 1000
    ts_ns = S + 10 ** 7 * np.arange(n) + rng.integers(0, 10 ** 6, n)
    rs_ns = ts_ns + rng.integers(2 * 10 ** 6, 8 * 10 ** 6, n)
    if broken == 'gap':
        ts_ns[550:] += 30 * S
        rs_ns[550:] += 30 * S
    if broken == 'same stamp':
        rs_ns[549] = ts_ns[550]
    ts, rs = (Headings.as_sent(t, rng.uniform(0.0, 360.0, n)) for t in (ts_ns, rs_ns))
    if broken.startswith('missing'):
        kept = np.arange(n) != 550
        ts, rs = (ts[kept], rs) if broken == 'missing TS' else (ts, rs[kept])
    settings = rules(method)

    def paired():
        pairer = Pairer(settings)
        found = [pairer.update(ts[lo:lo + 100], rs[lo:lo + 100]) for lo in range(0, n, 100)]
        return Pairs.concatenate([*found, pairer.flush()]), pairer.ledger.segments

    fast, segments = paired()
    used = []

    def search(stamp_ns, t_ns):
        used.append(t_ns)
        return np.searchsorted(stamp_ns, t_ns, side='right') - 1

    monkeypatch.setattr(pairing, 'find_left', search)
    slow, expected = paired()
    assert used and fast == slow and segments == expected
    assert len(fast) > 990


def test_interpolation_across_north_by_hand():
    """RS 350° at 1 s and 20° at 2 s: a third of the way is 350 + 30/3 = 360 = 0°."""
    pairs, _ = pair(headings((S + S // 3, 1.0)), headings((S, 350.0), (2 * S, 20.0)),
                    rules('auto', kernel='line'))
    assert wrap180(pairs.rs_deg) == pytest.approx([0.0], abs=1e-6)
    assert pairs.rs_variance_factor == pytest.approx([5 / 9], rel=1e-6)
    assert pairs.lag_ns.tolist() == [0]


def test_a_gap_is_not_interpolated_over_but_its_ends_pair():
    rs = headings((1 * S, 10.0), (5 * S, 10.0))
    pairs, ledger = pair(headings((1 * S, 1.0), (3 * S, 1.0), (5 * S, 1.0)), rs, rules())
    assert pairs.stamp_ns.tolist() == [1 * S, 5 * S]
    assert pairs.rs_variance_factor.tolist() == [1.0, 1.0]
    assert ledger.total.counts['ts_unbridged'] == 1


@pytest.mark.parametrize('method', ['interpolate', 'interpolate_ts'])
def test_a_bracket_of_just_the_longest_gap_is_used_and_a_longer_one_is_not(method):
    for gap_ns, n in ((3 * S, 1), (3 * S + 1, 0)):
        bracket, inside = headings((S, 10.0), (S + gap_ns, 10.0)), headings((2 * S, 10.0))
        ts, rs = (inside, bracket) if method == 'interpolate' else (bracket, inside)
        assert len(pair(ts, rs, rules(method, kernel='line', max_gap_s=3.0))[0]) == n


@pytest.mark.parametrize('lag_ns', [S // 2, -S // 2])
def test_a_lag_counts_without_its_sign(lag_ns):
    ts, rs = headings((10 * S, 1.0)), headings((10 * S + lag_ns, 2.0))
    (lag,) = pair(ts, rs, rules('nearest', tolerance_s=0.5))[0].lag_ns.tolist()
    assert lag == lag_ns
    assert len(pair(ts, rs, rules('nearest', tolerance_s=0.499))[0]) == 0


def test_a_ts_put_onto_the_rs_by_hand():
    """TS 350 and 20 degrees at 1 and 2 s: at 4/3 s 360 = 0 degrees; at 2 s the reading itself."""
    ts = headings((S, 350.0), (2 * S, 20.0), (3 * S, 30.0), (5 * S, 50.0))
    rs = headings((S // 2, 5.0), (S + S // 3, 5.0), (2 * S, 6.0), (6 * S, 7.0))
    pairs, ledger = pair(ts, rs, rules('interpolate_ts', kernel='line'))
    assert pairs.stamp_ns.tolist() == rs.stamp_ns[1:3].tolist()
    assert wrap180(pairs.ts_deg) == pytest.approx([0.0, 20.0], abs=1e-6)
    assert pairs.rs_deg.tolist() == [5.0, 6.0]
    assert pairs.ts_variance_factor == pytest.approx([5 / 9, 1.0], rel=1e-6)
    assert pairs.rs_variance_factor.tolist() == [1.0, 1.0] and pairs.lag_ns.tolist() == [0, 0]
    assert ledger.total.counts == {
        'paired': 2, 'ts_used': 1, 'ts_paired': 1, 'ts_unpaired': 2, 'rs_used': 2, 'rs_unused': 2,
        'bridged.2': 1, 'bridged.step': 10 ** 6, 'gaps.ts': 1, 'gaps.rs': 4,
        'changes.compared': 1, 'step.ts.100': 3, 'step.rs.100': 2}


def test_nothing_is_extrapolated():
    pairs, ledger = pair(headings((S, 1.0), (4 * S, 1.0)), headings((2 * S, 1.0), (3 * S, 1.0)))
    assert len(pairs) == 0
    assert ledger.total.counts == {'ts_unpaired': 2, 'rs_unused': 2}
    pairs, ledger = pair(headings((5 * S // 2, 1.0)), headings((2 * S, 1.0), (3 * S, 1.0)))
    assert len(pairs) == 0
    assert ledger.total.counts == {'ts_unbridged': 1, 'rs_unused': 2}


def test_ties_go_to_the_earlier_and_the_tolerance_is_inclusive():
    ts = headings((10 * S, 1.0))
    rs = headings((9 * S, 2.0), (11 * S, 3.0))
    pairs, _ = pair(ts, rs, rules('nearest', tolerance_s=1.0))
    assert pairs.rs_deg.tolist() == [2.0] and pairs.lag_ns.tolist() == [-S]
    assert len(pair(ts, rs, rules('nearest', tolerance_s=0.999))[0]) == 0


def test_known_skew_is_taken_from_the_ts_stamps():
    ts, rs = headings((3 * S, 1.0)), headings((S, 10.0), (2 * S, 20.0))
    pairs, _ = pair(ts, rs, Settings.from_mapping({'alignment.skew_s': 1.5,
                                                   'pairing.kernel': 'line'}))
    assert pairs.stamp_ns.tolist() == [3 * S // 2] and pairs.rs_deg.tolist() == [15.0]


def begun(**more):
    """Return a pairer that has taken the readings of 8, 9 and 10 s of both sensors, at 0 s."""
    pairer = Pairer(rules(**more))
    first = headings((8 * S, 0.0), (9 * S, 0.1), (10 * S, 0.0))
    assert len(pairer.update(first, first, now_s=0.0)) == 3
    return pairer


def test_live_a_reading_waits_no_longer_than_allowed():
    pairer = begun(max_wait_s=5.0, silent_wait_s=0.0)
    pairer.update(ts=headings((12 * S, 1.0)), rs=headings((11 * S, 1.0)), now_s=100.0)
    assert pairer.ledger.total.counts['ts_pending'] == 1
    pairer.update(ts=headings((17 * S, 1.0)), now_s=104.9)
    assert pairer.ledger.total.counts['ts_pending'] == 2
    pairer.update(now_s=105.1)
    assert pairer.ledger.total.counts['ts_unpaired'] == 1
    assert len(pairer.update(rs=headings((13 * S, 1.0)), now_s=105.2)) == 0
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}


@pytest.mark.parametrize('chunk', [1, 3])
@pytest.mark.parametrize('pause_s', [0.0, 0.3, 30.0])
def test_a_pause_of_both_sensors_costs_no_pair(chunk, pause_s):
    ts = headings(*((k * S // 10, 1.0) for k in range(10, 300)))
    rs = headings(*((k * S, 2.0) for k in range(1, 30)))
    whole, _ = pair(ts, rs, rules(max_wait_s=5.0))
    pairer, found, now_s = Pairer(rules(max_wait_s=5.0)), [], 0.0
    for lo in range(0, 290, 10 * chunk):
        # A paused replay, or one so slow that the RS is silent for longer than the wait.
        now_s += pause_s
        found.append(pairer.update(ts=ts[lo:lo + 10 * chunk], now_s=now_s))
        now_s += pause_s
        found.append(pairer.update(rs=rs[lo // 10:lo // 10 + chunk], now_s=now_s))
    found.append(pairer.flush())
    assert Pairs.concatenate(found) == whole
    # Not in the first and last two steps, which have fewer than three readings on either side.
    assert len(whole) == 281 - 4 * 9


def test_live_no_bracket_reaches_over_a_dropped_reading():
    pairer = begun(kernel='line', max_wait_s=1.0, silent_wait_s=0.0)
    pairer.update(ts=headings((11 * S, 0.1)), rs=headings((11 * S, 0.1)), now_s=0.0)
    pairer.update(rs=headings((12 * S, 90.0)), now_s=0.0)
    pairer.update(rs=headings((13 * S, 0.0), (14 * S, 0.1)), now_s=2.1)
    pairs = pairer.update(ts=headings((23 * S // 2, 0.0), (13 * S, 0.1)), now_s=2.1)
    assert pairs + pairer.flush() == Pairs.of([13 * S], [0.1], [0.0])


def lagging_s(stamp_s, lag_s):
    """Return how late readings come: ever later from 40 s on, then so for 30 s, then in time."""
    grown_s = 40.0 + lag_s
    late_s = np.where(stamp_s < grown_s + 30.0, stamp_s - 40.0, grown_s + 30.0 - stamp_s + lag_s)
    return np.clip(late_s, 0.0, lag_s)


def pair_as_they_come(both, arrive_s, settings):
    """Return the pairs of two streams by their arrival, the pairer, and most pending readings."""
    pairer, chunks, most, taken = Pairer(settings), [], 0, {'ts': 0, 'rs': 0}
    for now_s in np.arange(1.0, 200.0):
        upto = {name: int(np.searchsorted(arrive_s[name], now_s)) for name in both}
        chunks.append(pairer.update(**{name: both[name][taken[name]:upto[name]] for name in both},
                                    now_s=float(now_s)))
        taken, counts = upto, pairer.ledger.total.counts
        most = max(most, *(counts.get(f'{name}_pending', 0) for name in both))
    chunks.append(pairer.flush())
    return Pairs.concatenate(chunks), pairer, most


def arrivals_s(both, late, lag_s):
    """Return when the readings of two streams come; one of them lags."""
    stamps_s = {name: stream.stamp_ns / S for name, stream in both.items()}
    return stamps_s | {late: stamps_s[late] + lagging_s(stamps_s[late], lag_s)}


def yawing(step_s, first_s, end_s=180.0):
    stamp_s = np.arange(first_s, end_s, step_s)
    return Headings.as_sent(np.round(stamp_s * S).astype(np.int64),
                            50.0 + 3.0 * np.sin(stamp_s / 4.0))


@pytest.mark.parametrize('lag_s', [3.0, 10.0, 30.0])
@pytest.mark.parametrize('late', ['ts', 'rs'])
@pytest.mark.parametrize('method', METHODS)
def test_a_sensor_that_lags_and_is_heard_is_waited_for(method, late, lag_s):
    """At overload 3972 of 25 000 readings had no partner, for one driver lagged by over 5 s."""
    settings = rules(method)
    both = {'ts': yawing(0.1, 0.02), 'rs': yawing(0.2, 0.033)}
    whole, ledger = pair(both['ts'], both['rs'], settings)
    pairs, pairer, _ = pair_as_they_come(both, arrivals_s(both, late, lag_s), settings)
    assert pairs == whole and len(pairs) > 850
    assert pairer.ledger.total.counts == ledger.total.counts


@pytest.mark.parametrize('method', METHODS)
def test_a_sensor_that_lags_too_far_is_waited_for_so_long_and_no_longer(method):
    """A lag of 50 s where 20 s are allowed: some 20 s of the TS wait at most, or the choice's."""
    settings = rules(method, silent_wait_s=20.0, auto_s=20.0)
    both = {'ts': yawing(0.1, 0.02), 'rs': yawing(0.1, 0.033)}
    pairs, pairer, most = pair_as_they_come(both, arrivals_s(both, 'rs', 50.0), settings)
    assert 600 < len(pairs) < 1700 and most < 300
    assert pairer.ledger.total.counts['ts_unpaired'] > 100
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}


@pytest.mark.parametrize('stepped', ['ts', 'rs'])
@pytest.mark.parametrize('method', METHODS)
def test_a_clock_set_back_waits_for_a_sensor_that_lags(method, stepped):
    """The clock goes back by an hour at 80 s, where the other sensor is 20 s behind."""
    both = {'ts': yawing(0.1, 0.02), 'rs': yawing(0.2, 0.033)}
    arrive_s = arrivals_s(both, 'rs' if stepped == 'ts' else 'ts', 20.0)
    for name, stream in both.items():
        moved_ns = stream.stamp_ns + 3600 * S
        moved_ns[(stream.stamp_ns > 80 * S) & (name == stepped)] -= 3600 * S
        both[name] = Headings.as_sent(moved_ns, stream.heading_deg)
    whole, _ = pair(both['ts'], both['rs'], rules(method))
    pairs, pairer, _ = pair_as_they_come(both, arrive_s, rules(method))
    assert pairs == whole and len(pairs) > 350 and pairer.segment == 1


def test_memory_is_bounded_when_one_sensor_is_silent():
    pairer = Pairer(rules(max_wait_s=5.0))
    stamps_ = np.arange(1, 2001, dtype=np.int64) * S
    for k in range(0, 2000, 10):
        chunk = Headings.as_sent(stamps_[k:k + 10], np.zeros(10))
        pairer.update(rs=chunk, now_s=float(k))
    assert pairer.ledger.total.counts['rs_pending'] <= 80
    assert pairer.ledger.total.counts['rs_unused'] >= 1920


@pytest.mark.parametrize('late', ['ts', 'rs'])
@pytest.mark.parametrize('from_s, to_s, lost', [(0, 8, 0), (0, 50, 0), (40, 90, 0), (40, 140, 1)])
@pytest.mark.parametrize('method', ['interpolate', 'nearest'])
def test_what_a_sensor_has_sent_while_it_could_not_be_reached_is_paired(
        late, from_s, to_s, lost, method):
    """At 20 times its speed, a connection that took 5.1 s cost 207 of 1200 pairs."""
    both = headings(*((k * S // 2, 1.0) for k in range(1, 4001)))
    pairer, found, kept = Pairer(rules(method=method)), [], [0]
    for second in range(200):
        sent = 20 * second + 20
        pieces = [sent]
        if from_s <= second < to_s:
            pieces = kept[-1:]
        elif second == to_s:
            # What was kept comes in pieces, over two seconds.
            pieces = [*np.linspace(kept[-1], sent, 8, dtype=int)]
        for at, upto in enumerate(pieces):
            found.append(pairer.update(**{late: both[kept[-1]:upto]}, now_s=second + at / 4))
            kept.append(upto)
        other = 'rs' if late == 'ts' else 'ts'
        found.append(pairer.update(**{other: both[sent - 20:sent]}, now_s=second + 2.0))
    found.append(pairer.flush())
    assert bool(4000 - len(Pairs.concatenate(found))) is bool(lost)
    assert pairer.ledger.balance() == {'ts': 0, 'rs': 0}


def test_a_sensor_that_is_heard_again_is_waited_for_as_before():
    pairer = begun(max_wait_s=5.0, max_gap_s=3.0)
    for second in range(100, 140):
        # The RS is heard, but has nothing at the stamps of the TS.
        pairer.update(ts=headings(((10 * second) * S, 1.0)),
                      rs=headings(((10 * second + 5) * S, 1.0)), now_s=float(second))
    assert pairer.ledger.total.counts['ts_unbridged'] >= 30


def test_a_silence_of_the_pairs_divides_the_ledger():
    ts = headings(*((k * S, 1.0) for k in (1, 2, 50, 100, 101)))
    rs = headings(*((k * S, 1.0) for k in (1, 2, 3, 99, 100, 101)))
    _, ledger = pair(ts, rs, rules(gap_s=60.0))
    before, first, between, second, behind = ledger.segments
    assert [s.start_ns for s in ledger.segments] == [None, S, 2 * S + 1, 100 * S, 101 * S + 1]
    assert (before.counts, behind.counts) == ({}, {})
    assert first.counts == {'paired': 2, 'ts_paired': 2, 'rs_used': 2}
    assert between.counts == {'ts_unpaired': 1, 'rs_unused': 2, 'gaps.rs': 95}
    assert second.counts == {'paired': 2, 'ts_paired': 2, 'rs_used': 2}
    # What lies between two runs belongs to the one before, but not to what it lost.
    assert ledger.shares([S, 100 * S])[0].counts['ts_unpaired'] == 1
    assert ledger.count_between(S, 2 * S).counts == first.counts


@pytest.mark.parametrize('last, fate', [(30, 'ts_unbridged'), (31, 'ts_unpaired')])
def test_what_is_lost_within_a_run_is_told_from_what_came_before_and_after(last, fate):
    """
    RS from 10 to 40 s, with a gap from 20 s on, into which 9 or 10 TS readings fall.

    A gap of more than ten usual steps is a silence, in which the TS has no partner.
    """
    ts = headings(*((k * S, 1.0) for k in range(1, 61)))
    rs = headings(*((k * S, 1.0) for k in range(10, 41) if not 20 < k < last))
    for size in (1, 7, 60):
        pairer = Pairer(rules(max_gap_s=3.0))
        for lo in range(0, 60, size):
            pairer.update(ts[lo:lo + size], rs[lo:lo + size])
        pairer.flush()
        inside = pairer.ledger.count_between(10 * S, 40 * S).counts
        assert (inside[fate], inside['ts_paired']) == (last - 21, 52 - last)
        assert inside['gaps.rs'] == last - 21
        assert pairer.ledger.total.counts['ts_unpaired'] == 29 + (fate == 'ts_unpaired') * 10


def test_a_ledger_survives_its_segments():
    _, ledger = pair(headings((S, 1.0), (100 * S, 1.0)), headings((S, 1.0), (100 * S, 2.0)),
                     rules(gap_s=60.0))
    again = Ledger.from_segments(ledger.segments, ledger.newest_ns)
    assert again.segments == ledger.segments
    assert again.shares([S, 100 * S]) == ledger.shares([S, 100 * S])
    assert again.balance() == {'ts': 0, 'rs': 0}


def test_a_mark_divides_readings_that_were_counted_before_it_came():
    pairer = Pairer(rules())
    stream = headings(*((k * S, 1.0) for k in range(1, 31)))
    pairer.update(stream, stream)
    pairer.ledger.cut(21 * S)
    assert [s.counts.get('paired', 0) for s in pairer.ledger.segments] == [0, 20, 10]


def test_an_empty_stream_gives_no_pairs():
    assert len(pair(Headings.empty(), Headings.empty())[0]) == 0


def test_the_keys_of_the_ledger_are_their_words():
    """The keys as in topics and bags; each has one sensor, and at most one reason."""
    assert [str(key) for key in LedgerKey] == [key.value for key in LedgerKey]
    assert json.dumps({LedgerKey.TS_USED: 1}) == '{"ts_used": 1}'
    assert {LedgerKey.PAIRED: 3}['paired'] == 3
    assert {(key.stream, key.reason) for key in LedgerKey if key.reason} == {
        (stream, reason) for stream in ('ts', 'rs') for reason in REASONS}
    segment = LedgerSegment(None, {'ts_used': 1, 'paired': 2, 'rs_rejected.no_stamp': 4})
    assert [*segment.counts] == [LedgerKey.TS_USED, LedgerKey.PAIRED, LedgerKey.RS_NO_STAMP]
    assert (segment.received('ts'), segment.received('rs')) == (1, 4)
    assert (segment.rejected('ts'), segment.rejected('rs')) == ({}, {'no_stamp': 4})


@pytest.mark.parametrize('key', ['ts_lost', 'ts_rejected', 'ts_rejected.late', ''])
def test_an_unknown_key_of_the_ledger_is_refused(key):
    with pytest.raises(ValueError, match='is not a valid LedgerKey'):
        LedgerSegment(None, {key: 1})


def test_old_segments_are_joined_and_nothing_is_lost():
    """Cuts at 10, 20, 30 s; of 0 to 39 s, joined before 20 s, the first segment has 0 to 19."""
    ledger = Ledger()
    stamps = np.arange(40) * S
    for cut_s in (10, 20, 30):
        ledger.cut(cut_s * S)
    ledger.receive('ts', stamps)
    ledger.add(LedgerKey.TS_UNPAIRED, stamps[:25])
    ledger.settle(200 * S)
    ledger.add(LedgerKey.TS_PAIRED, stamps[25:])
    ledger.forget_before(20 * S)
    assert [(s.start_ns, s.received('ts')) for s in ledger.segments] == [
        (None, 20), (20 * S, 10), (30 * S, 10)]
    assert ledger.balance() == {'ts': 0, 'rs': 0}
    ledger.forget_before(20 * S)
    ledger.forget_before(5 * S)
    assert len(ledger.segments) == 3
    ledger.add(LedgerKey.of_rejected('ts', 'stamp_not_increasing'), stamps[3:4])
    assert ledger.segments[0].rejected('ts') == {'stamp_not_increasing': 1}
    ledger.forget_before(1000 * S)
    assert [s.start_ns for s in ledger.segments] == [None, 30 * S]


@pytest.mark.slow
@given(step_s=st.integers(1, 40), chunk=st.integers(1, 50), dead=st.integers(0, 300))
def test_segments_at_cuts_of_the_clock_do_not_depend_on_chunks(step_s, chunk, dead):
    """The RS is silent for a while, so that cuts pass without a pair."""
    stamps = np.arange(0, 1200, step_s) * S
    ts, rs = Headings.as_sent(stamps, stamps % 7 * 0.1), Headings.as_sent(stamps, stamps % 5 * 0.1)
    rs = rs[(rs.stamp_ns < 500 * S) | (rs.stamp_ns >= (500 + dead) * S)]
    rule = Settings.from_mapping({'runs.every_h': 0.05, 'runs.gap_s': 400.0,
                                  'pairing.max_gap_s': 60.0, 'pairing.method': 'interpolate'})
    whole = pair(ts, rs, rule)[1]
    pairer = Pairer(rule)
    cuts = []
    for lo in range(0, len(ts), chunk):
        made = pairer.update(ts=ts[lo:lo + chunk])
        cuts += made.stamp_ns.tolist()
        span = stamps[lo:lo + chunk]
        made = pairer.update(rs=rs[(rs.stamp_ns >= span[0]) & (rs.stamp_ns <= span[-1])])
        cuts += made.stamp_ns.tolist()
    cuts += pairer.flush().stamp_ns.tolist()
    starts = [at // (180 * S) * (180 * S) for at in cuts]
    runs = sorted({*starts[1:]} - {starts[0]})
    assert pairer.ledger.shares([0, *runs]) == whole.shares([0, *runs])
    for begin, end in zip([0, *runs], [*runs, 1200 * S]):
        last = max(at for at in cuts if at < end)
        assert pairer.ledger.count_between(begin, last) == whole.count_between(begin, last)
