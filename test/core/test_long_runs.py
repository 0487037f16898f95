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

"""Long runs: what averages and stretches show is what all pairs show."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from scipy.signal import lfilter
from trials import find_finding, judge_pairs

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics import blocking
from heading_intercompare.core.timing import skew_instrument
from heading_intercompare.core.typed_reader import make_plain

SETTINGS = Settings.from_mapping({
    'norms.sigma_max_deg': 0.6, 'norms.sigma_ref_max_deg': 0.1, 'pairing.method': 'nearest'})
N, STEP_NS = 300_000, 10 ** 7
OUTLIER, GLITCH = 188_500, 92_000

#: Relative tolerance of figures from averages, and of those from other readings than before.
AVERAGED, OTHER_READINGS = 2e-3, 0.25


def made_up(fault=None):
    """Return 50 min at 100 Hz of a ship that yaws and turns four times, with many errors."""
    rng = np.random.default_rng(16)
    stamp_ns = 10 ** 18 + STEP_NS * np.arange(N) + rng.integers(0, 10 ** 5, N)
    t = np.arange(N) * STEP_NS / 1e9
    true_deg = 350.0 + 0.5 * t + 2.0 * np.sin(2.0 * np.pi * t / 9.0)
    keep = math.exp(-1.0 / 2000.0)
    slow = lfilter([0.2 * math.sqrt(1.0 - keep ** 2)], [1.0, -keep], rng.standard_normal(N))
    late_s = 0.02
    ts = (true_deg - late_s * np.gradient(true_deg, t) + slow + rng.normal(0.0, 0.05, N)
          + 0.3 * np.sin(np.radians(true_deg)) + 0.4 * t / t[-1])
    rs = true_deg + rng.normal(0.0, 0.05, N)
    if fault is not None:
        ts, rs = FAULTS[fault](rng, t, ts, rs)
    else:
        ts[OUTLIER] += 8.0
        rs[GLITCH:GLITCH + 2] += 5.0
    keep = np.ones(N, bool)
    keep[120_000:123_000] = False
    return Pairs.of(stamp_ns[keep], wrap360(ts[keep]), wrap360(rs[keep]))


def freeze(rng, t, ts, rs):
    """Stop the TS for three minutes."""
    ts[200_000:218_000] = ts[200_000]
    return ts, rs


FAULTS = {
    'frozen': freeze,
    'vibration': lambda rng, t, ts, rs: (ts + 0.5 * np.sin(2.0 * np.pi * 31.0 * t), rs),
    'mirrored': lambda rng, t, ts, rs: (90.0 - ts, rs),
    'half a turn off': lambda rng, t, ts, rs: (ts + 180.0, rs),
    'copy': lambda rng, t, ts, rs: (rs + rng.normal(0.0, 0.002, t.size), rs),
    'rounded': lambda rng, t, ts, rs: (np.rint(ts), np.rint(10.0 * rs) / 10.0),
    'warm-up': lambda rng, t, ts, rs: (ts + 3.0 * np.exp(-t / 200.0), rs),
    'late': lambda rng, t, ts, rs: (np.interp(t - 0.7, t, ts), rs),
    'clocks drift': lambda rng, t, ts, rs: (np.interp(0.9995 * t, t, ts), rs),
    'step': lambda rng, t, ts, rs: (ts + 1.5 * (t > 1700.0), rs),
}


def judge_both_ways(pairs):
    """Return the run judged as a long one, and with all diagnostics on all pairs."""
    averaged = judge_pairs(pairs, SETTINGS).runs[0]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocking, '_MOST', 1 << 40)
        patch.setattr(skew_instrument, '_MANY', 1 << 40)
        return averaged, judge_pairs(pairs, SETTINGS).runs[0]


@pytest.fixture(scope='module')
def both():
    return judge_both_ways(made_up())


def leaves(value, path=''):
    """Return the figures and words of a verdict by their paths."""
    if isinstance(value, dict):
        return {k: v for key in value for k, v in leaves(value[key], f'{path}.{key}').items()}
    if isinstance(value, list):
        return {k: v for at, one in enumerate(value)
                for k, v in leaves(one, f'{path}[{at}]').items()}
    return {path: value}


def test_the_words_and_counts_are_the_same(both):
    """Only the normality of the sensors is tested on fewer readings."""
    found, expected = (leaves(make_plain(run)) for run in both)
    # The least noise of the RS comes from other readings.
    for one in (found, expected):
        for path in ('.assumptions[3].evidence', '.validity[6].evidence'):
            one[path] = re.sub(r'[\d.]+', 'x', one[path])
    other = {path for path in expected
             if not isinstance(expected[path], float) and found[path] != expected[path]}
    assert found.keys() == expected.keys()
    assert other == {f'.normality.{sensor}_{kind}.n' for sensor in ('ts', 'rs')
                     for kind in ('first_difference', 'moving_average')}
    assert found['.normality.ts_first_difference.n'] == 16 * (16_384 - 2)


def test_the_figures_are_the_same(both):
    found, expected = (leaves(make_plain(run)) for run in both)
    floats = [path for path, value in expected.items() if isinstance(value, float)]
    others = {path for path in floats if '_difference.' in path or '_average.' in path
              or 'reference_noise' in path}
    exact = [path for path in floats if path.split('.')[1] in (
        'variance_deg2', 'mean_deg', 'guarded', 'variance_criterion', 'total_error', 'pairing',
        'circular_mean_deg', 'skew') or '.allan.deviation_deg' in path]
    assert len(floats) > 200 and len(exact) > 60
    for path in floats:
        # A narrow window has a limit in samples; averages show less of the compass; a few large
        # values decide how many others a shape is worth.
        if path in ('.drift.line.tau_samples', '.heading_dependence.empty_arc_deg') or (
                'normality' in path and path in others and 'std_deg' not in path):
            continue
        near = OTHER_READINGS if path in others else AVERAGED
        assert found[path] == pytest.approx(expected[path], rel=near, abs=1e-4), path
    # The drift is judged by averages, so its bound moves by a millionth.
    assert all(found[path] == pytest.approx(expected[path], rel=1e-5) for path in exact)


def test_rare_things_are_found_wherever_they_are(both):
    """An outlier and a glitch of the RS lie between two stretches."""
    spans = [range(part.start, part.stop) for part in blocking.pick_stretches(N - 3000)]
    assert not any(GLITCH in span or OUTLIER - 3000 in span for span in spans)
    averaged, _ = both
    outliers = find_finding(averaged, 'outliers')
    assert '2 isolated' in outliers.evidence
    assert averaged.correlation.stamps.silences == 1


@pytest.mark.parametrize('fault', FAULTS)
def test_a_fault_is_found_either_way(fault):
    """A vibration, which averages do not show, leaves few independent differences."""
    def describe(run):
        return (run.outcome, run.skew.estimate.kind, run.drift.order.order,
                [(found.condition, found.effect) for found in run.validity],
                [(one.id, one.state) for one in run.assumptions])

    averaged, expected = judge_both_ways(made_up(fault))
    assert describe(averaged) == describe(expected)
    assert averaged.correlation.n_effective_variance == pytest.approx(
        expected.correlation.n_effective_variance, rel=1e-9)
