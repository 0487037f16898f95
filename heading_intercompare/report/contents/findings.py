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

"""The further findings in words: what each figure of the JSON is called, its unit and meaning."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, Mapping, Sequence

from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.report.formatting import (
    ABSENT,
    flatten,
    number,
    value,
    with_uncertainty,
)

from .deviation_card import make_deviation_card
from .tables import Table

__all__ = ['describe_findings', 'Figure', 'Finding', 'FINDINGS', 'HOMOGENEITY', 'LEFT_TO_JSON',
           'OF_SHAPE', 'rows_of_block', 'SHAPES']

_COLUMNS = 4

#: Words of the JSON that a figure may be.
_WORDS = {
    'found': 'found', 'unclear': 'found, but poorly determined',
    'beyond': 'beyond the range of the search', 'no_fit': 'no skew fits',
    'not_turned': 'the ship did not turn enough', 'too_few': 'too few pairs',
    'insufficient_data': 'too few differences', 'headings_too_narrow': 'too few headings',
    'agrees': 'nothing contradicts', 'doubt': 'may be wrong', 'contradicts': 'wrong',
    'not_testable': 'not testable', 'off': 'points off the course',
    'mirrored': 'turns against the course', 'frozen': 'stays while the course changes',
    'astray': 'does not follow', 'follows': 'follows', 'against': 'turns against it',
    'scaled': 'turns by another factor', 'ts': 'TS', 'rs': 'RS', 'both': 'TS and RS',
}


@dataclass(frozen=True, slots=True)
class Figure:
    """
    A figure of the JSON in words.

    Attributes
    ----------
    key : str
        Its dotted name within its block.
    words, unit : str
        '1' is the unit of a number without dimension, '' that of anything else.
    u_key : str
        Name of its standard uncertainty, which stands beside it; empty if it has none.

    """

    key: str
    words: str
    unit: str
    u_key: str = ''


@dataclass(frozen=True, slots=True)
class Finding:
    """
    One section of the further findings.

    Attributes
    ----------
    block : str
        The block of the JSON, a field of `RunVerdict`.
    title, meaning : str
        What is examined, and how to read the figures.
    assumptions : str
        Letters of the assumptions that it supports, which conclude from the figures.
    figures : tuple of Figure
        A row each.
    columns : tuple of Figure
        Lists of the JSON that belong together, a column each; the rows are their items.
    side_by_side : tuple of (str, str)
        Name and words of blocks with the figures of `OF_SHAPE`, a column each.

    """

    block: str
    title: str
    meaning: str
    assumptions: str
    figures: tuple[Figure, ...]
    columns: tuple[Figure, ...] = ()
    side_by_side: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Described:
    """A section for the page: a sentence per run, and its tables with their titles."""

    title: str
    meaning: str
    concluded: Sequence[str]
    tables: Sequence[tuple[str, Table]]


SHAPES = (('difference', 'differences'), ('ts_first_difference', 'change of the TS'),
           ('rs_first_difference', 'change of the RS'),
           ('ts_moving_average', 'TS about its moving average'),
           ('rs_moving_average', 'RS about its moving average'))
"""The distributions that are examined."""
OF_SHAPE = (
    Figure('n', 'values', '1'),
    Figure('n_effective', 'independent values they are worth for the shape', '1'),
    Figure('std_deg', 'standard deviation', 'deg'), Figure('skewness', 'skewness', '1'),
    Figure('excess_kurtosis', 'excess kurtosis', '1'),
    Figure('skewness_z', 'skewness, in its standard deviations', '1'),
    Figure('kurtosis_z', 'excess kurtosis, in its standard deviations', '1'),
    Figure('jarque_bera', 'Jarque-Bera statistic', '1'), Figure('p', 'its probability', '1'))
"""The figures of a distribution."""

HOMOGENEITY = (
    Figure('m', 'runs compared', '1'),
    Figure('weighted_mean_deg', 'mean of the means, weighted by their uncertainties', 'deg'),
    Figure('q', "Cochran's statistic of equal means", '1'),
    Figure('q_p', 'probability of one as large if the means are equal', '1'),
    Figure('birge_ratio', 'Birge ratio: above 1 the means scatter more than they should', '1'),
    Figure('between_variance_deg2', 'variance of the systematic error from run to run', 'deg²'),
    Figure('bartlett', "Bartlett's statistic of equal variances", '1'),
    Figure('bartlett_p', 'probability of one as large if the variances are equal', '1'),
    Figure('means_equal', 'the means agree', ''),
    Figure('variances_equal', 'the variances agree', ''),
    Figure('drift_orders', 'order of the drift of each run', '1'),
)
"""How the runs compare with each other."""

FINDINGS = (
    Finding(
        'skew', 'Time skew between the sensors',
        'If the data of one sensor are older than their stamps say, every turn of the ship makes '
        'a difference that no sensor error causes. A positive skew means that the data of the TS '
        'are older. The estimate compares the differences with the rate of turn. The scan shifts '
        'one stream in time and looks for the least scatter.', 'b', (
            Figure('estimate.kind', 'result of the estimate', ''),
            Figure('estimate.skew_s', 'skew, with its standard uncertainty', 's', 'estimate.u_s'),
            Figure('estimate.interval_s', '95 % interval of the skew', 's'),
            Figure('estimate.well_determined', 'the skew is well determined', ''),
            Figure('estimate.significant', 'the interval excludes zero', ''),
            Figure('variance_aligned_deg2', 'variance of the differences without the skew',
                   'deg²'),
            Figure('outcome_as_paired', 'GK (5) as paired', ''),
            Figure('outcome_aligned', 'GK (5) without the skew', ''),
            Figure('estimate.std_deg', 'standard deviation of the differences used', 'deg'),
            Figure('estimate.std_aligned_deg', 'the same without the skew', 'deg'),
            Figure('estimate.mean_aligned_deg', 'mean of the differences without the skew',
                   'deg'),
            Figure('estimate.rs_rate_std_deg_s', 'rate of turn of the RS, standard deviation',
                   'deg/s'),
            Figure('estimate.rate_std_deg_s', 'rate of turn that both sensors show', 'deg/s'),
            Figure('estimate.strength',
                   'strength of that rate; below 10 the ship did not turn enough', '1'),
            Figure('estimate.ols_s', 'skew by least squares, too small because of noise', 's',
                   'estimate.ols_u_s'),
            Figure('estimate.iv_s', 'skew after one step of the estimate', 's'),
            Figure('estimate.beyond_s', 'skew beyond the range of the search, about', 's'),
            Figure('estimate.also_s', 'another that fits about as well', 's'),
            Figure('estimate.searched_s', 'clocks that lie apart were sought up to', 's'),
            Figure('estimate.n', 'pairs or short averages used', '1'),
            Figure('scan.skew_s', 'scan: skew of the least scatter', 's', 'scan.u_s'),
            Figure('scan.bias_s', 'scan: shift that a noisy RS may cause, at most', 's'),
            Figure('scan.well_determined', 'scan: the skew is well determined', ''),
            Figure('scan.at_edge', 'scan: the least scatter is at an end of the range', ''),
            Figure('scan.std_deg', 'scan: standard deviation at that skew', 'deg'),
            Figure('scan.std_zero_deg', 'scan: standard deviation without a skew', 'deg'),
            Figure('scan.mean_deg', 'scan: mean difference at that skew', 'deg'),
            Figure('scan.mean_zero_deg', 'scan: mean difference without a skew', 'deg'),
            Figure('scan.range_s', 'scan: range', 's'), Figure('scan.step_s', 'scan: step', 's'),
            Figure('scan.n', 'scan: TS readings compared', '1'))),
    Finding(
        'drift', 'Drift and warm-up',
        'A drift is a slow change of the mean difference. It is described by a polynomial in '
        'time, by a straight line, and by an exponential as after switching on.', 'cf', (
            Figure('order.order', 'order of the polynomial that the differences call for', '1'),
            Figure('order.beyond', 'a higher order would fit better still', ''),
            Figure('order.blocks', 'block means that the order is chosen by', '1'),
            Figure('coefficients_deg', 'Legendre coefficients of that polynomial', 'deg'),
            Figure('left_deg2',
                   'variance of the drift if it is left in, upper 95 % bound', 'deg²'),
            Figure('residual_std_deg', 'standard deviation about the polynomial', 'deg'),
            Figure('span_h', 'length of the run', 'h'),
            Figure('line.slope_deg_per_h', 'slope, with its standard uncertainty', 'deg/h',
                   'line.u_deg_per_h'),
            Figure('line.interval_deg_per_h', '95 % interval of the slope', 'deg/h'),
            Figure('line.u_naive_deg_per_h',
                   'uncertainty of the slope if the errors were uncorrelated', 'deg/h'),
            Figure('line.intercept_deg', 'value of the line at the first difference', 'deg'),
            Figure('line.tau_samples', 'correlation time about the line', 'readings'),
            Figure('line.residual_std_deg', 'standard deviation about the line', 'deg'),
            Figure('warm_up.preferred', 'an exponential describes the run better', ''),
            Figure('warm_up.amplitude_deg', 'warm-up: amplitude', 'deg'),
            Figure('warm_up.level_deg', 'warm-up: final level', 'deg'),
            Figure('warm_up.tau_s', 'warm-up: time constant', 's'),
            Figure('warm_up.tolerance_deg', 'warm-up: remainder that is tolerated', 'deg'),
            Figure('warm_up.settle_s', 'warm-up: time until then', 's'),
            Figure('warm_up.span_s', 'warm-up: length of the run', 's'),
            Figure('mser_s', 'time until the start no longer disturbs the mean', 's'))),
    Finding(
        'heading_dependence', 'Dependence on the heading',
        'The deviation is fitted as A + B sin ψ + C cos ψ + D sin 2ψ + E cos 2ψ, where ψ is the '
        'heading of the RS. A small probability means that the difference depends on it.', 'e', (
            Figure('reason', 'why it could not be fitted', ''),
            Figure('coefficients_deg', 'A to E, with their standard uncertainties', 'deg',
                   'u_deg'),
            Figure('amplitude_deg', 'largest departure from A', 'deg'),
            Figure('f', 'F statistic of B to E being zero', '1'),
            Figure('p', 'its probability', '1'),
            Figure('residual_std_deg', 'standard deviation about the fit', 'deg'),
            Figure('empty_arc_deg', 'largest arc without a heading', 'deg'),
            Figure('condition', 'condition number of the fit', '1'),
            Figure('n', 'differences', '1'))),
    Finding(
        'normality', 'Distribution of the errors',
        'The model assumes a normal or a uniform distribution. Normal values have neither '
        'skewness nor excess kurtosis; uniform ones have an excess kurtosis of -1.2. A small '
        'probability speaks against normal values. The change of a sensor from reading to '
        'reading, and its deviation from a moving average, show its noise alone.', 'j', (
            Figure('thinned_step', 'step between nearly independent differences', 'readings'),
            Figure('thinned_n', 'number of these', '1'),
            Figure('anderson_darling', 'Anderson-Darling statistic of these', '1'),
            Figure('anderson_darling_p', 'its probability', '1'),
            Figure('moving_average_width', 'width of the moving average', 'readings'),
            Figure('ts_step_deg', 'resolution of the TS', 'deg'),
            Figure('rs_step_deg', 'resolution of the RS', 'deg'),
            Figure('ts_repeated_share', 'share of TS readings equal to the one before', '1'),
            Figure('rs_repeated_share', 'share of RS readings equal to the one before', '1'),
            Figure('rounding_variance_deg2', 'variance that rounding adds', 'deg²')),
        side_by_side=SHAPES),
    Finding(
        'stationarity', 'Constancy in time',
        'Mean and variance must not change during the run. Small probabilities mean that they '
        'do.', 'h', (
            Figure('blocks', 'blocks compared', '1'), Figure('block_s', 'their length', 's'),
            Figure('mean_z', 'trend of the mean, in its standard deviations', '1'),
            Figure('mean_p', 'its probability', '1'),
            Figure('square_z', 'trend of the variance, in its standard deviations', '1'),
            Figure('square_p', 'its probability', '1'),
            Figure('kpss', 'KPSS statistic of a constant level', '1'),
            Figure('kpss_p', 'its probability', '1'),
            Figure('kpss_lags', 'lags that it allows for', '1'))),
    Finding(
        'correlation', 'Correlation in time',
        'Neighbouring differences repeat each other. The effective numbers say how many '
        'independent differences would give as good a mean and as good a variance.', 'a', (
            Figure('n', 'differences', '1'),
            Figure('n_effective_mean', 'effective number for the mean', '1'),
            Figure('n_effective_variance', 'effective number for the variance', '1'),
            Figure('r1', 'correlation of neighbours', '1'),
            Figure('tau_1_s', 'correlation time for the mean', 's'),
            Figure('tau_2_s', 'correlation time for the variance', 's'),
            Figure('window_s', 'largest lag summed', 's'),
            Figure('closed', 'the run is long enough for these times', ''),
            Figure('stamps.n', 'stamps', '1'),
            Figure('stamps.typical_s', 'median step of the stamps', 's'),
            Figure('stamps.nominal_s', 'step of the sensor', 's'),
            Figure('stamps.lost_share', 'share of readings that the stamps show as missing', '1'),
            Figure('stamps.backward', 'steps back', '1'),
            Figure('stamps.equal', 'equal stamps', '1'),
            Figure('stamps.silences', 'silences', '1'),
            Figure('stamps.longest_back_s', 'longest step back', 's'),
            Figure('stamps.longest_s', 'longest step', 's'))),
    Finding(
        'motion', 'Headings against the motion of the ship',
        'On a straight course a heading points along the course over ground, but for leeway and '
        'current, which nobody knows. An angle beyond the bound is a gross error. A smaller one '
        'proves nothing. The rate of turn shows a heading that turns the other way, too far, or '
        'not at all.', '', (
            Figure('kind', 'conclusion', ''), Figure('whose', 'sensor that is wrong', ''),
            Figure('n_positions', 'positions in the run', '1'),
            Figure('n_velocities', 'velocities in the run', '1'),
            Figure('n_rates', 'rates of turn in the run', '1'),
            Figure('n_legs', 'straight legs', '1'), Figure('legs_s', 'their time', 's'),
            Figure('astern_s', 'part of it on which the ship seems to go astern', 's'),
            Figure('least_bound_deg', 'least angle off the course that shows', 'deg'),
            *(Figure(f'{name}.{key}', f'{name.upper()}: {words}', unit)
              for name in ('ts', 'rs') for key, words, unit in (
                  ('kind', 'against the course', ''),
                  ('off_deg', 'mean angle off the course', 'deg'),
                  ('largest_deg', 'largest angle off the course of a leg', 'deg'),
                  ('against_s', 'time of the legs with an angle beyond the bound', 's'),
                  ('turns.kind', 'against the rate of turn', ''),
                  ('turns.n', 'spans of 5 s compared', '1'),
                  ('turns.turn_deg', 'turn in a span, root mean square', 'deg'),
                  ('turns.slope', 'slope of its turns on the rate of turn', '1'),
                  ('turns.correlation', 'their correlation', '1'),
                  ('turns.delay_s', 'delay of the heading that fits best', 's')))),
        (Figure('legs.duration_s', 'leg', 's'), Figure('legs.course_deg', 'course', 'deg'),
         Figure('legs.speed_kn', 'speed', 'kn'), Figure('legs.bound_deg', 'bound', 'deg'),
         Figure('legs.ts_deg', 'TS - course', 'deg'),
         Figure('legs.rs_deg', 'RS - course', 'deg'))),
    Finding(
        'allan', 'Scatter against averaging time',
        'The Allan deviation says how much neighbouring averages differ. White noise falls with '
        'the root of the averaging time; a level or rising deviation shows slow errors.', '', (),
        (Figure('tau_s', 'averaging time', 's'), Figure('m', 'readings averaged', '1'),
         Figure('deviation_deg', 'Allan deviation', 'deg'),
         Figure('terms', 'differences of averages', '1'))),
    Finding(
        'allan', 'Noise of the reference sensor',
        'Where the ship is quiet, the noise of both sensors can be told apart. The bound is the '
        'least that the RS scatters; it must not exceed its norm.', 'd', (
            Figure('reference_noise.sigma_ref_lower_deg',
                   'standard deviation of the RS, lower 95 % bound', 'deg'),),
        (Figure('reference_noise.octaves', 'readings averaged', '1'),
         Figure('reference_noise.ts_variance_deg2', 'variance of the TS', 'deg²'),
         Figure('reference_noise.rs_variance_deg2',
                'variance of the RS, with its standard uncertainty', 'deg²',
                'reference_noise.u_deg2'),
         Figure('reference_noise.following_deg2', 'of it in proportion to the motion', 'deg²'))),
)
"""The sections, in their order on the page."""

LEFT_TO_JSON = {
    'skew.scan.curve_s': 'the curve is drawn, not printed',
    'skew.scan.curve_std_deg': 'the curve is drawn, not printed',
    'drift.order.bic': 'only the order that it chooses says something',
    'motion.legs.start_ns': 'the legs are printed in their order, and drawn on the track',
    'normality.ts_step_seen_deg': 'the finding on the resolution says the step',
    'normality.rs_step_seen_deg': 'the finding on the resolution says the step',
    'heading_dependence.covariance_deg2': 'its diagonal is printed, as uncertainties',
}
"""Figures that the protocol leaves to the JSON, and why."""


def describe_findings(runs: Sequence[RunVerdict]) -> list[Described]:
    """Return the sections that say something about the runs, with their figures."""
    sections = []
    for finding in FINDINGS:
        blocks = [(run.run, dict(flatten(getattr(run, finding.block)))) for run in runs
                  if getattr(run, finding.block) is not None]
        tables = [('', table) for table in rows_of_block(finding.figures, blocks)]
        for run, block in blocks if finding.side_by_side else ():
            tables.append((f'Run {run}', _place_side_by_side(finding.side_by_side, block)))
        for run, block in blocks if finding.columns else ():
            if rows := _columns(finding.columns, block):
                tables.append((f'Run {run}', Table(
                    [_head(figure) for figure in finding.columns], rows)))
        if finding.block == 'heading_dependence':
            tables += [(f'Run {run.run}: deviation card', card) for run in runs
                       if (card := make_deviation_card(run.heading_dependence)) is not None]
        if tables:
            sections.append(Described(finding.title, finding.meaning,
                                      _conclude(finding, runs), tables))
    return sections


def rows_of_block(figures: Sequence[Figure],
                  blocks: Sequence[tuple[int, Mapping[str, Any]]]) -> list[Table]:
    """
    Return tables of the figures that at least one run has, a few runs in each.

    Parameters
    ----------
    figures : sequence of Figure
        Figures of one section of the findings.
    blocks : sequence of (int, mapping)
        Number of the run, and its figures by their dotted names.

    """
    tables = []
    for first in range(0, len(blocks), _COLUMNS):
        columns = blocks[first:first + _COLUMNS]
        rows = [[figure.words, figure.unit, *(_cell(figure, block) for _, block in columns)]
                for figure in figures]
        if rows := [row for row in rows if {*row[2:]} != {ABSENT}]:
            tables.append(Table(['', 'unit', *(f'run {run}' for run, _ in columns)], rows))
    return tables


def _cell(figure: Figure, block: Mapping[str, Any]) -> str:
    return _text(block.get(figure.key), block.get(figure.u_key))


def _text(thing: Any, u: Any = None) -> str:
    if isinstance(thing, bool) or thing is None or thing == '':
        return value(thing)
    if isinstance(thing, (list, tuple)):
        return ', '.join(_text(element, element_u)
                         for element, element_u in zip_longest(thing, u or ())) or ABSENT
    if isinstance(thing, str):
        return _WORDS.get(thing, value(thing))
    return with_uncertainty(thing, u) if isinstance(thing, float) else number(thing)


def _head(figure: Figure) -> str:
    return f'{figure.words} [{figure.unit}]'


def _columns(figures: Sequence[Figure], block: Mapping[str, Any]) -> list[list[str]]:
    """Return a row for each item of the lists; without any, none."""
    lists = [[_text(element, u) for element, u in zip_longest(
        block.get(figure.key) or (), block.get(figure.u_key) or ())] for figure in figures]
    return [list(row) for row in zip(*lists)]


def _place_side_by_side(names: Sequence[tuple[str, str]], block: Mapping[str, Any]) -> Table:
    return Table(['', 'unit', *(words for _, words in names)],
                 [[figure.words, figure.unit,
                   *(_text(block.get(f'{name}.{figure.key}')) for name, _ in names)]
                  for figure in OF_SHAPE])


def _conclude(finding: Finding, runs: Sequence[RunVerdict]) -> list[str]:
    """Return what the assumptions of GK say on the figures, a sentence per run."""
    states = {'met': 'met', 'violated': 'VIOLATED', 'not_testable': 'not testable'}
    return [f'Run {run.run}: assumption ({assumption.id}) is '
            f'{states.get(assumption.state, assumption.state)}: {assumption.evidence}'
            for run in runs for assumption in run.assumptions
            if assumption.id in finding.assumptions]
