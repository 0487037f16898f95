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

"""The kernel: its weights by hand, cubics, noise, motion, missing readings, and pieces."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.pairing.interpolation_kernel import (
    find_left,
    interpolate,
    interpolated_response,
    LARGEST_FACTOR,
    longest_step_ns,
)
from heading_intercompare.core.pairing.pairer import pair, Pairer
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

S = 1_000_000_000
T0 = 1_700_000_000 * S


def bridge(stamps, values, t, step_ns=S, **more):
    """Interpolate at stamps within steps that may be bridged."""
    stamps, t = np.asarray(stamps), np.asarray(t)
    return interpolate(stamps, np.asarray(values, float),
                       np.diff(stamps) <= longest_step_ns(step_ns), find_left(stamps, t), t,
                       step_ns, **more)


@pytest.mark.parametrize('n, weights, factor', [
    (8, [0.61152, -0.14671, 0.04232, -0.00712], 0.7946), (6, [0.59923, -0.11759, 0.01836], 0.7465),
    (4, [9 / 16, -1 / 16], 0.640625)])
def test_the_weights_in_the_middle_of_even_readings(n, weights, factor):
    """Each weight from the value that one reading of 1 deg among zeros gives; they mirror."""
    step_ns = S if n > 4 else S // 4
    found = [bridge(np.arange(1, n + 1) * step_ns, np.arange(n) == k, [(n + 1) * step_ns // 2],
                    step_ns) for k in range(n)]
    got = [float(one.heading_deg[0]) for one in found]
    assert got[n // 2:] == pytest.approx(weights, abs=5e-6)
    assert got[:n // 2] == pytest.approx(weights[::-1], abs=5e-6)
    assert found[0].side.tolist() == [n // 2]
    assert found[0].factor[0] == pytest.approx(sum(w * w for w in got), rel=1e-9)
    assert found[0].factor[0] == pytest.approx(factor, abs=1e-4)


@pytest.mark.parametrize('n, step_ns', [(4, S // 10), (8, S)])
@pytest.mark.parametrize('place', [0.1, 0.3, 0.5])
def test_the_response_is_that_of_the_weights(n, step_ns, place):
    """The transfer of the weights, from the value that one reading of 1 deg among zeros gives."""
    stamps = np.arange(1, n + 1) * step_ns
    at = n // 2 - 1 + place
    found = [bridge(stamps, np.arange(n) == k, [stamps[0] + round(at * step_ns)], step_ns)
             for k in range(n)]
    weights = np.array([float(one.heading_deg[0]) for one in found])
    share = np.linspace(0.05, 1.0, 20)
    power = np.abs((weights * np.exp(1j * np.pi * np.outer(share, np.arange(n)))).sum(axis=1)) ** 2
    assert interpolated_response(float(found[0].factor[0]), step_ns, share) == pytest.approx(
        power, abs=0.045)


@pytest.mark.parametrize('step_s, sides', [(0.1, {1, 2}), (0.5, {2, 3, 4}), (1.0, {3, 4})])
def test_cubics_are_exact_on_any_stamps(rng, step_s, sides):
    step_ns = round(step_s * 1e9)
    x = np.arange(400) + rng.uniform(-0.15, 0.15, 400)
    x = x[rng.uniform(size=400) > 0.05]

    def cubic(s):
        return 40.0 + 0.3 * s - 2e-3 * s ** 2 + 3e-6 * s ** 3

    stamps = S + np.round(x * step_ns).astype(np.int64)
    t = np.sort(rng.integers(stamps[0], stamps[-1], 500))
    found = bridge(stamps, cubic((stamps - S) / step_ns), t, step_ns)
    good = found.side > 1
    assert set(found.side.tolist()) - {0} <= sides and good.mean() > 0.6
    off = found.heading_deg - cubic((t - S) / step_ns)
    assert np.abs(off[good]).max() < 1e-9


def test_it_turns_with_the_circle():
    stamps = np.arange(1, 30) * S
    t = stamps[5:-5] + S // 3
    turning = (350.0 + 25.0 * np.arange(29)) % 360.0
    found = bridge(stamps, turning, t)
    assert np.abs(wrap180(found.heading_deg - (350.0 + 25.0 * (t / S - 1.0)))).max() < 1e-9


@pytest.mark.parametrize('period, eight, line', [
    (12.0, 5e-7, 6e-4), (6.0, 5e-6, 1e-2), (4.2, 1e-5, 4e-2), (3.3, 4e-4, 9e-2)])
def test_the_error_of_a_sine_by_readings_per_period(period, eight, line):
    """Variance added over the variance of the motion, phases anywhere."""
    stamps = np.arange(1, 4001) * S
    t = np.arange(10 * S, 3990 * S, S // 7 * 3)
    t = t[t % S != 0]

    def sine(ns):
        return np.sqrt(2.0) * np.sin(2.0 * np.pi * ns / S / period)

    for is_line, most in ((False, eight), (True, 1.2 * line)):
        found = bridge(stamps, sine(stamps), t, is_line=is_line)
        assert np.mean((found.heading_deg - sine(t)) ** 2) < most
    assert np.mean((found.heading_deg - sine(t)) ** 2) > 0.8 * line
    # The line is compared with the kernel, which it misses by its own error.
    assert found.apart_deg2[:, 2].mean() == pytest.approx(line, rel=0.2)


@pytest.mark.parametrize('jitter', [0.0, 0.2, 0.45])
def test_no_kernel_amplifies_white_noise_much(rng, jitter):
    stamps = S + np.round((np.arange(3000) + rng.uniform(-jitter, jitter, 3000)) * S
                          ).astype(np.int64)
    t = np.sort(rng.integers(stamps[5], stamps[-5], 3000))
    found = bridge(stamps, np.zeros(3000), t)
    assert found.factor.max() <= LARGEST_FACTOR
    assert found.factor[found.side > 0].mean() < 1.0


def test_a_gap_of_a_fast_sensor_is_bridged_and_one_of_a_slow_sensor_is_not():
    """One of ten readings a second missing; one of one a second; two readings to the line."""
    for step_ns, bridged in ((S // 10, True), (S, False)):
        stamps = np.delete(np.arange(1, 41), 20) * step_ns
        found = bridge(stamps, np.zeros(39), [20 * step_ns + step_ns // 2], step_ns)
        assert bool(found.side[0]) is bridged


@pytest.mark.parametrize('kernel', ['band_limited', 'line'])
@pytest.mark.parametrize('step_s', [0.1, 0.4, 1.0])
def test_the_bits_do_not_depend_on_the_pieces(rng, kernel, step_s):
    """Also not those of the solved systems and of the squares in the ledger."""
    settings = Settings.from_mapping({'pairing.kernel': kernel, 'runs.gap_s': 20.0})

    def sensor(phase):
        place = np.arange(1500) + phase + rng.uniform(-0.2, 0.2, 1500)
        place[700:] += 50.0 / step_s
        return Headings.of(T0 + np.round(place * step_s * 1e9).astype(np.int64),
                           rng.uniform(10.0, 20.0, 1500))[rng.uniform(size=1500) > 0.03]

    ts, rs = sensor(0.0), sensor(0.4)
    whole, ledger = pair(ts, rs, settings)
    assert len(whole) > 500
    for seed in range(3):
        sizes = np.random.default_rng(seed)
        pairer, found, at = Pairer(settings), [], [0, 0]
        while at[0] < len(ts) or at[1] < len(rs):
            n, m = sizes.integers(0, 90, 2)
            found.append(pairer.update(ts[at[0]:at[0] + n], rs[at[1]:at[1] + m]))
            at = [at[0] + n, at[1] + m]
        assert Pairs.concatenate([*found, pairer.flush()]) == whole
        assert pairer.ledger.segments == ledger.segments


def test_a_sensor_with_just_four_readings_a_second_is_fast():
    """By hand: 1 - (1 - f) 2^k / C(2k, k) in the middle, 1 - (1 - f) 4^k / C(2k, k) at the end."""
    frequency = np.array([0.5, 1.0])
    fast, slow = (interpolated_response(0.9, step_ns, frequency)
                  for step_ns in (250_000_000, 250_000_001))
    assert fast == pytest.approx([1.0 - 0.1 * 4 / 6, 1.0 - 0.1 * 16 / 6])
    assert slow == pytest.approx([1.0 - 0.1 * 256 / 12870, 1.0 - 0.1 * 65536 / 12870])
