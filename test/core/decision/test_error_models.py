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

"""Coverage factors: golden table, quadrature, Monte Carlo, symmetries."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from heading_intercompare.core.decision.error_models import (
    coverage_factor,
    density,
    ERROR_MODELS,
    tail,
    ts_factor,
)

RATIOS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0)

# Two-sided quantiles, computed with mpmath at 40 digits; columns are RATIOS.
GOLDEN = """
NN 0.9    1.644853626951 = = = = =
NN 0.95   1.959963984540 = = = = =
NN 0.99   2.575829303549 = = = = =
NN 0.997  2.967737925342 = = = = =
NN 0.9973 2.999976992703 = = = = =
UN 0.9    1.558845726812 1.552866303842 1.560816953236 1.598331243591 1.637423975752 1.645111361556
UN 0.95   1.645448267190 1.650782837966 1.706984871462 1.810203756780 1.917423545366 1.955309062054
UN 0.99   1.714730299493 1.781529024718 1.945945486949 2.186788880023 2.442537405317 2.555937014314
UN 0.997  1.726854655146 1.846554248530 2.079798453311 2.409491839590 2.765085910575 2.934434187625
UN 0.9973 1.727374270388 1.851551989389 2.090392092909 2.427384913509 2.791296549644 2.965449208466
NU 0.9    1.644853626951 1.644855928221 1.644921443391 1.645111361556 1.637423975752 1.598331243591
NU 0.95   1.959963984540 1.959955743540 1.959645188927 1.955309062054 1.917423545366 1.810203756780
NU 0.99   2.575829303549 2.575783239126 2.574175206334 2.555937014314 2.442537405317 2.186788880023
NU 0.997  2.967737925342 2.967653573708 2.964784249243 2.934434187625 2.765085910575 2.409491839590
NU 0.9973 2.999976992703 2.999888937131 2.996899769105 2.965449208466 2.791296549644 2.427384913509
UU 0.9    1.558845726812 1.551109471978 1.569051194718 1.630969684697 1.674893073542 1.630969684697
UU 0.95   1.645448267190 1.652067126640 1.724685551391 1.833892059168 1.901767185278 1.833892059168
UU 0.99   1.714730299493 1.786799602824 1.932386515959 2.104700984722 2.204540768505 2.104700984722
UU 0.997  1.726854655146 1.836098234338 2.008384327380 2.203790007724 2.315325664133 2.203790007724
UU 0.9973 1.727374270388 1.839161955953 2.013107301029 2.209948011958 2.322210522170 2.209948011958
"""


def golden_rows():
    for line in GOLDEN.split('\n'):
        if line:
            model, p, first, *rest = line.split()
            for ratio, cell in zip(RATIOS, (first, *rest)):
                yield model, ratio, float(p), float(first if cell == '=' else cell)


def draws(model, ratio, n, rng):
    """Return normalised differences."""
    def part(letter):
        half = math.sqrt(3.0)
        return rng.standard_normal(n) if letter == 'N' else rng.uniform(-half, half, n)
    return (part(model[0]) + ratio * part(model[1])) / math.hypot(1.0, ratio)


def test_coverage_factors_agree_with_the_golden_table():
    rows = list(golden_rows())
    assert len(rows) == 120
    for model, ratio, p, expected in rows:
        assert coverage_factor(model, ratio, p) == pytest.approx(expected, rel=0, abs=1e-12), \
            (model, ratio, p)


def test_triangle_by_hand():
    """Equal half-widths w: q = 2 w (1 - sqrt(1 - P)); P = 0.75 gives q = w, K = w / sqrt 2."""
    assert coverage_factor('UU', 1.0, 0.75) == pytest.approx(math.sqrt(1.5), rel=1e-15)


def test_plateau_of_the_trapezoid_by_hand():
    """w2 = w1/2 and P = 0.4 lies on the plateau: q = 0.4 w1, K = 0.4 sqrt 3 / sqrt 1.25."""
    expected = 0.4 * math.sqrt(3.0) / math.sqrt(1.25)
    assert coverage_factor('UU', 0.5, 0.4) == pytest.approx(expected, rel=1e-15)
    assert tail('UU', 0.5, expected) == pytest.approx(0.6, rel=1e-14)


@pytest.mark.parametrize('model', ERROR_MODELS)
@pytest.mark.parametrize('ratio', [0.003, 0.07, 0.4, 0.87, 1.0, 1.9, 35.0])
@pytest.mark.parametrize('p', [0.5, 0.95, 0.999999])
def test_tail_at_the_coverage_factor_is_one_minus_p(model, ratio, p):
    k = coverage_factor(model, ratio, p)
    assert tail(model, ratio, k) == pytest.approx(1.0 - p, rel=1e-9)


@pytest.mark.parametrize('model', ['UN', 'NU'])
@pytest.mark.parametrize('ratio', [0.05, 0.3, 0.8, 0.9, 2.5, 12.0])
def test_mixed_tail_agrees_with_quadrature(model, ratio):
    """P(|u + v| > q) is the mean of 2 Q((q - u) / sigma) over the uniform part u."""
    ts, rs = 1.0 / math.hypot(1.0, ratio), ratio / math.hypot(1.0, ratio)
    sigma, w = (rs, math.sqrt(3) * ts) if model == 'UN' else (ts, math.sqrt(3) * rs)
    for k in (0.0, 0.5, 1.5, 2.5, 4.0):
        edges = [u for u in (k - 6.0 * sigma, k, k + 6.0 * sigma) if -w < u < w]
        expected = quad(lambda u, k=k: norm.sf((k - u) / sigma) / w, -w, w, points=edges or None,
                        epsabs=0.0, epsrel=1e-12, limit=400)[0]
        assert tail(model, ratio, k) == pytest.approx(expected, rel=1e-10)


def test_the_two_forms_of_the_mixed_tail_meet():
    """Closed form and sum change over at w = 2 sigma, that is ratio 2 / sqrt 3 of NU."""
    border = 2.0 / math.sqrt(3.0)
    for k in (0.1, 1.0, 3.0, 6.0):
        below, above = tail('NU', border * (1 - 1e-13), k), tail('NU', border * (1 + 1e-13), k)
        assert below == pytest.approx(above, rel=1e-10)


@pytest.mark.parametrize('model', ERROR_MODELS)
@pytest.mark.parametrize('ratio', [0.0, 0.1, 0.5, 1.0, 3.0])
def test_share_of_draws_within_the_coverage_factor_is_p(model, ratio, rng):
    """Six standard errors of a share: false alarm 2e-9 for each of 40 comparisons."""
    n = 200_000
    deviations = np.abs(draws(model, ratio, n, rng))
    for p in (0.9, 0.997):
        share = np.mean(deviations <= coverage_factor(model, ratio, p))
        assert abs(share - p) < 6.0 * math.sqrt(p * (1.0 - p) / n)


@pytest.mark.parametrize('model', ERROR_MODELS)
@pytest.mark.parametrize('ratio', [0.0, 1e-9, 0.2, 1.0, 4.0, 1e9])
def test_density_has_area_and_variance_one_and_is_the_slope_of_the_tail(model, ratio):
    z = np.linspace(-9.0, 9.0, 360_001)
    f = density(model, ratio, z)
    step = z[1] - z[0]
    assert f.min() >= 0.0
    assert f.sum() * step == pytest.approx(1.0, abs=3e-5)
    assert (f * z * z).sum() * step == pytest.approx(1.0, abs=1e-4)
    k = np.array([0.31, 1.11, 1.61])
    slope = (tail(model, ratio, k - 1e-6) - tail(model, ratio, k + 1e-6)) / 4e-6
    assert slope == pytest.approx(density(model, ratio, k), abs=1e-8)


@pytest.mark.parametrize('ratio', [1e-3, 0.1, 0.3, 0.9, 1.0, 1.2, 7.0, 1e3])
@pytest.mark.parametrize('p', [0.6, 0.95, 0.9973])
def test_exchanging_the_sensors_inverts_the_ratio(ratio, p):
    swapped = {'NN': 'NN', 'UN': 'NU', 'NU': 'UN', 'UU': 'UU'}
    for model, other in swapped.items():
        assert coverage_factor(model, ratio, p) == \
            pytest.approx(coverage_factor(other, 1.0 / ratio, p), rel=1e-13)


@pytest.mark.parametrize('p', [0.6, 0.997, 0.999999])
@pytest.mark.parametrize('tiny', [0.0, 1e-300, 1e-170, 1e-100, 1e-12])
def test_a_negligible_part_leaves_the_other_distribution(p, tiny):
    huge = math.inf if tiny == 0.0 else 1.0 / tiny
    normal, uniform = -norm.ppf((1.0 - p) / 2.0), p * math.sqrt(3.0)
    for model, at_tiny, at_huge in (('NN', normal, normal), ('UN', uniform, normal),
                                    ('NU', normal, uniform), ('UU', uniform, uniform)):
        assert coverage_factor(model, tiny, p) == pytest.approx(at_tiny, rel=1e-5)
        assert coverage_factor(model, huge, p) == pytest.approx(at_huge, rel=1e-5)


@pytest.mark.parametrize('model', ERROR_MODELS)
@pytest.mark.parametrize('p', [0.7, 0.95, 0.9973])
def test_the_limit_in_degrees_rises_with_the_reference_noise(model, p):
    """K may fall with the ratio, K sqrt(1 + ratio^2) may not (Birnbaum 1948)."""
    ratios = np.linspace(0.0, 3.0, 121)
    limits = [coverage_factor(model, r, p) * math.hypot(1.0, r) for r in ratios]
    assert np.all(np.diff(limits) >= -1e-13)


def test_factor_of_the_ts_alone():
    assert ts_factor('NU', 0.95) == pytest.approx(1.959963984540, abs=1e-12)
    assert ts_factor('UU', 0.95) == pytest.approx(0.95 * math.sqrt(3.0), rel=1e-15)


@pytest.mark.parametrize('given, words', [
    (('XY', 0.5, 0.9), "model = 'XY'"), (('NN', -0.1, 0.9), 'ratio = -0.1'),
    (('NN', math.nan, 0.9), 'ratio = nan'), (('UU', 0.5, 1.0), 'p = 1.0'),
    (('UU', 0.5, 0.0), 'p = 0.0'), (('UU', 0.5, math.nan), 'p = nan')])
def test_a_parameter_outside_its_range_is_refused(given, words):
    with pytest.raises(ValueError, match=words):
        coverage_factor(*given)
