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

"""
The assumptions (a) to (j) of GK, each compared with the data of a run.

An assumption that two sensors cannot test is reported as not testable, never as met.
"""

from __future__ import annotations

from dataclasses import dataclass
import math

from heading_intercompare.core.conditions.one_source import OneSource
from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.statistics.drift import Order, Slope
from heading_intercompare.core.statistics.normality import Shape
from heading_intercompare.core.statistics.stationarity import Homogeneity, Stationarity
from heading_intercompare.core.statistics.variance_uncertainty import Spread
from heading_intercompare.core.statistics.warm_up import WarmUp
from heading_intercompare.core.timing.time_skew import Skew

from .deviation import HeadingDependence

MET, VIOLATED, NOT_TESTABLE = 'met', 'violated', 'not_testable'

STATEMENTS = {
    'a': 'There are many readings, also counted as independent ones',
    'b': 'TS and RS are read at the same instants',
    'c': 'The stabilisation period is left out',
    'd': 'The RS has no systematic error, and its norm is close to its true standard deviation',
    'e': 'The installation offset is known, or small compared with the norm',
    'f': 'The difference is a drift plus a stationary process',
    'g': 'The process is ergodic: every run shows the same form',
    'h': 'Mean and variance are constant within the run',
    'i': 'The errors of TS and RS are uncorrelated',
    'j': 'The errors follow the distributions of the model',
}
"""The assumptions of GK, in this package's words."""

SIGNIFICANT = 0.01
"""An assumption is violated if data that meet it would look this bad with a lower probability."""

DEPENDENT = 0.001
"""The same for a dependence on the heading, because the test on few blocks rejects too often."""

SKEW_SHARE = 0.05
"""Largest share of the variance from a skew at which readings count as simultaneous."""

ENOUGH = 15.0
"""Fewest effectively independent differences that count as many."""

SLOW_RATIO, SLOW_SHARE = 2.0, 0.05
"""A slow error looks like a change if the four lowest half-periods of a record exceed both: this
multiple of the power of the middle ones, and this share of the variance."""

SMALL_OFFSET = 1.0 / 3.0
"""A mean difference is small up to this share of sigma_max."""


@dataclass(frozen=True, slots=True)
class Assumption:
    """One assumption; keys of the JSON."""

    id: str = figure('letter of the assumption', '`a` to `j`')
    statement: str = figure('what is assumed')
    state: str = figure('whether it holds', '`met`, `violated` or `not_testable`')
    evidence: str = figure('figures in a sentence')


_UNRESOLVED = 'the run is too short for the correlation of the errors'
_ALIKE = f'{_UNRESOLVED}: a slow error and a change of the process look alike'


def _of(key: str, state: str, evidence: str) -> Assumption:
    return Assumption(key, STATEMENTS[key], state, evidence)


def is_resolved(spread: Spread | None) -> bool:
    """Tell whether a record is long enough to distinguish slow errors from a change."""
    return spread is not None and not (spread.r_slow > SLOW_RATIO and
                                       spread.slow_variance_deg2 > SLOW_SHARE * spread.d_deg2)


def judge_large_n(n: int, nu: float | None, resolved: bool) -> Assumption:
    """Judge (a) by the number of differences and their effective number for the variance."""
    if n == 0:
        return _of('a', NOT_TESTABLE, 'there are no differences')
    if nu is None:
        return _of('a', VIOLATED, f'{n} differences are fewer than 128, or too unevenly '
                   'spread in time')
    if nu >= ENOUGH and not resolved:
        return _of('a', NOT_TESTABLE, f'{n} differences, but {_UNRESOLVED}: the number of '
                   'independent ones that they are worth is unknown')
    return _of('a', MET if nu >= ENOUGH else VIOLATED,
               f'{n} differences are worth {nu:.4g} independent ones for the variance; '
               f'{ENOUGH:.4g} are needed')


def judge_synchronous(skew: Skew, range_s: float) -> Assumption:
    """Judge (b) by the time skew and the variance that it adds."""
    if skew.kind == 'beyond':
        return _of('b', VIOLATED, skew.why_not(range_s))
    largest = skew.largest_variance_deg2(range_s)
    if largest is None or not skew.std_deg:
        return _of('b', NOT_TESTABLE, 'there is too little data to estimate latency and '
                   'clock offset')
    share = largest / skew.std_deg ** 2
    if not skew.well_determined:
        # The variance holds what an unknown skew adds, so a small share excuses none.
        return _of('b', NOT_TESTABLE, skew.why_not(range_s))
    figures = (f'the latency or clock offset is {skew.skew_s:.3f} s (standard uncertainty '
               f'{skew.u_s:.3f} s) and adds up to {100.0 * share:.3g} % to the variance')
    if share <= SKEW_SHARE:
        return _of('b', MET, figures)
    return _of('b', VIOLATED if skew.significant else NOT_TESTABLE, figures)


def judge_stabilized(warm_up: WarmUp | None) -> Assumption:
    """Judge (c) by an exponential warm-up in the analysed differences."""
    if warm_up is None:
        return _of('c', NOT_TESTABLE, 'there is too little data to see a warm-up')
    if not warm_up.preferred:
        return _of('c', MET, 'no exponential warm-up describes the differences')
    figures = (f'a warm-up of {warm_up.amplitude_deg:.3g} deg with time constant '
               f'{warm_up.tau_s:.4g} s')
    if warm_up.settle_s == 0.0:
        return _of('c', MET, f'{figures} stays within {warm_up.tolerance_deg:.3g} deg')
    end = (f'is over only {warm_up.settle_s:.4g} s after the first analysed difference'
           if warm_up.settle_s < warm_up.span_s else 'is not over at the end of the run')
    return _of('c', VIOLATED, f'{figures} {end}')


def _explain_low_variance(upper_deg2: float | None, reference_deg: float) -> str:
    """Return why the variance is too small for the RS, or an empty string."""
    if upper_deg2 is None or not upper_deg2 < reference_deg ** 2:
        return ''
    return (f'the standard deviation of the differences is at most {math.sqrt(upper_deg2):.3g} '
            f'deg, less than the {reference_deg:.3g} deg that the RS alone should have')


def judge_reference_norm(sigma_ref_lower_deg: float | None, sigma_ref_max_deg: float,
                         upper_deg2: float | None, m_low: float) -> Assumption:
    """
    Judge (d) by the noise of the RS that the data show.

    Parameters
    ----------
    sigma_ref_lower_deg
        Lower bound of the RS standard deviation from both headings, by `reference_noise`;
        degrees.
    sigma_ref_max_deg
        Norm of the RS standard deviation, degrees.
    upper_deg2
        Upper confidence bound of the variance of the differences, square degrees; None if
        unknown or unreliable.
    m_low
        Lower bound of sigma_ref / sigma_ref_max that the verdict uses.

    """
    below = _explain_low_variance(upper_deg2, m_low * sigma_ref_max_deg)
    if below:
        return _of('d', VIOLATED, f'{below}: its norm is too large, unless (i) is violated')
    if sigma_ref_lower_deg is None:
        return _of('d', NOT_TESTABLE, 'a systematic error of the RS cannot be seen in '
                   'differences, and the ship is never quiet enough to show its noise')
    figures = (f'both headings show at least {sigma_ref_lower_deg:.3g} deg of RS noise, its norm '
               f'is {sigma_ref_max_deg:.3g} deg')
    if sigma_ref_lower_deg > sigma_ref_max_deg:
        return _of('d', VIOLATED, figures)
    return _of('d', NOT_TESTABLE, f'{figures}; a systematic error of the RS cannot be seen in '
               'differences')


def judge_installation(mean_interval_deg: tuple[float, float] | None, sigma_max_deg: float,
                       variant: str) -> Assumption:
    """Judge (e) by the 95 % interval of the mean, which includes the offset's uncertainty."""
    if mean_interval_deg is None:
        return _of('e', NOT_TESTABLE, 'there is too little data for an interval of the mean')
    low, up = mean_interval_deg
    figures = (f'the mean difference is within [{low:.4g}, {up:.4g}] deg, sigma_max is '
               f'{sigma_max_deg:.4g} deg')
    if max(abs(low), abs(up)) <= SMALL_OFFSET * sigma_max_deg:
        return _of('e', MET, figures)
    if variant == 'A' and not low <= 0.0 <= up:
        return _of('e', VIOLATED, f'{figures}; in variant A nothing but an offset explains that')
    return _of('e', NOT_TESTABLE, f'{figures}; an offset and a systematic error of the TS look '
               'alike')


def judge_drift_and_stationary(order: Order | None, residual: Stationarity,
                               resolved: bool | None) -> Assumption:
    """
    Judge (f) by the residuals about the polynomial that the drift needs.

    Parameters
    ----------
    order
        The order chosen.
    residual
        Stationarity of the residuals about that polynomial.
    resolved
        Whether the record is long enough for their correlation.

    """
    if order is None or residual.least_p is None:
        return _of('f', NOT_TESTABLE, 'there is too little data')
    drift = f'a drift of order {order.order}' if order.order else 'no drift'
    figures = f'{drift}; the rest is stationary with p = {residual.least_p:.2g}'
    if not resolved:
        return _of('f', NOT_TESTABLE, f'{drift}; {_ALIKE}')
    return _of('f', VIOLATED if residual.least_p < SIGNIFICANT else MET, figures)


def judge_ergodic(runs: Homogeneity | None) -> Assumption:
    """Judge (g) by the means and variances of several runs."""
    if runs is None or runs.m < 2:
        return _of('g', NOT_TESTABLE, 'there is only one run')
    figures = (f'{runs.m} runs: equal means have p = {runs.q_p:.2g}, equal variances p = '
               f'{runs.bartlett_p:.2g}')
    if runs.drift_orders is not None and len(set(runs.drift_orders)) > 1:
        orders = ', '.join(map(str, runs.drift_orders))
        figures += f'; the order of their drift is not constant: {orders}'
    if runs.variances_equal and runs.means_equal:
        return _of('g', MET, figures)
    if runs.variances_equal:
        return _of('g', VIOLATED, f'{figures}; the systematic error varies from run to run '
                   f'by {math.sqrt(runs.between_variance_deg2 or 0.0):.3g} deg: variant C')
    return _of('g', VIOLATED, figures)


def judge_constant_moments(stationarity: Stationarity, slope: Slope | None, span_h: float,
                           dependence: HeadingDependence, resolved: bool | None) -> Assumption:
    """
    Judge (h) by trends of mean and variance, and by a dependence on the heading.

    Parameters
    ----------
    stationarity
        Stationarity of the differences as analysed.
    slope
        Slope of the same.
    span_h
        Length of the run, hours.
    dependence
        Harmonics of the heading in the differences.
    resolved
        Whether the record is long enough for the correlation of the residuals.

    """
    if stationarity.least_p is None:
        return _of('h', NOT_TESTABLE, 'there is too little data')
    if dependence.p is not None and dependence.p < DEPENDENT:
        return _of('h', VIOLATED, 'the difference depends on the heading, by up to '
                   f'{dependence.amplitude_deg:.3g} deg (p = {dependence.p:.2g})')
    trends = [text for p, text in (
        (stationarity.mean_p, 'the mean'), (stationarity.square_p, 'the variance'),
        (stationarity.kpss_p, 'the level')) if p is not None and 3.0 * p < SIGNIFICANT]
    figures = (f'reverse arrangements of {stationarity.blocks} blocks: '
               f'mean z = {stationarity.mean_z:.2f}, square z = {stationarity.square_z:.2f}')
    if stationarity.kpss is not None:
        figures += f'; KPSS {stationarity.kpss:.3f}'
    if slope is not None and slope.u_deg_per_h is not None:
        figures += (f'; slope {slope.slope_deg_per_h:.3g} deg/h (standard uncertainty '
                    f'{slope.u_deg_per_h:.2g}), {slope.slope_deg_per_h * span_h:.3g} deg over '
                    'the run')
    if not resolved:
        return _of('h', NOT_TESTABLE, f'{_ALIKE}; {figures}')
    if trends:
        return _of('h', VIOLATED, f'{" and ".join(trends)} changes; {figures}')
    return _of('h', MET, figures)


def judge_correlated_errors(upper_deg2: float | None, reference_deg: float,
                            source: OneSource) -> Assumption:
    """
    Judge (i): two sensors can only show a violation, by a difference that is too small.

    Parameters
    ----------
    upper_deg2
        As for `judge_reference_norm`.
    reference_deg
        Least standard deviation of the RS that the verdict uses, degrees.
    source
        Signs that both headings come from one sensor.

    """
    if source.kind == 'common':
        return _of('i', VIOLATED, 'the TS follows the noise or the glitches of the RS: both come '
                   'from one sensor')
    if source.kind == 'suspected':
        return _of('i', VIOLATED, 'the TS repeats the RS, reading by reading: both may come from '
                   'one sensor')
    below = _explain_low_variance(upper_deg2, reference_deg)
    if below:
        return _of('i', VIOLATED, f'{below}: the errors are correlated, unless (d) is violated')
    return _of('i', NOT_TESTABLE, 'a correlation of the errors cannot be seen in differences')


def model_kurtosis(model: str, rs_share: float) -> float:
    """
    Return the excess kurtosis of the difference under a model.

    Parameters
    ----------
    model : {'NN', 'UN', 'NU', 'UU'}
        Distributions of the TS and of the RS error.
    rs_share
        Share of the RS in the variance of the difference, 0 to 1.

    References
    ----------
    The fourth cumulant of a sum is the sum of the fourth cumulants; that of a uniform
    distribution is -1.2 sigma^4.

    """
    ts, rs = (-1.2 if law == 'U' else 0.0 for law in model)
    return ts * (1.0 - rs_share) ** 2 + rs * rs_share ** 2


def judge_laws(shape: Shape, model: str, reference_deg: tuple[float, float]) -> Assumption:
    """
    Judge (j) by skewness and kurtosis at the effective size.

    Parameters
    ----------
    shape
        Shape of the differences or their residuals.
    model : {'NN', 'UN', 'NU', 'UU'}
        Laws of the errors of TS and RS, GK (2) to (2c).
    reference_deg : pair of float
        Least and largest standard deviation of the RS, degrees; any kurtosis that the model
        gives between them is accepted.

    """
    std_deg, kurtosis, z_skewness = shape.std_deg, shape.excess_kurtosis, shape.skewness_z
    if shape.p is None or std_deg is None or kurtosis is None or z_skewness is None:
        return _of('j', NOT_TESTABLE, 'there is too little data, or the differences are equal')
    shares = [min(1.0, (s / std_deg) ** 2) for s in reference_deg]
    steps = [shares[0] + (shares[1] - shares[0]) * k / 50.0 for k in range(51)]
    expected = [model_kurtosis(model, s) for s in steps]
    nearest = min(max(kurtosis, min(expected)), max(expected))
    z = (kurtosis - nearest) * math.sqrt(shape.n_effective / 24.0)
    p = math.exp(-0.5 * (z_skewness ** 2 + z * z))
    figures = (f'skewness {shape.skewness:.3g}, excess kurtosis {shape.excess_kurtosis:.3g} '
               f'(model {model}: {nearest:.3g}) of {shape.n_effective:.4g} effective differences: '
               f'p = {p:.2g}')
    if shape.n_effective < ENOUGH:
        return _of('j', NOT_TESTABLE, f'{figures}; too few to tell')
    return _of('j', VIOLATED if p < SIGNIFICANT else MET, figures)
