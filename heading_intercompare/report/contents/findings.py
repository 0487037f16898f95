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

"""The further findings: figures of the JSON in sections, in words; and the deviation card."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import zip_longest
import math
from typing import Any, Mapping, Sequence

import numpy as np

from heading_intercompare.core.declared_figures import Figure, list_figures
from heading_intercompare.core.diagnostics.by_motion import BySector
from heading_intercompare.core.diagnostics.deviation import (
    deviation_at,
    HeadingDependence,
    holds_all_round,
)
from heading_intercompare.core.statistics.normality import Shape
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.core.verdict.vocabulary import STATE_WORDS
from heading_intercompare.report.formatting import (
    ABSENT,
    flatten,
    number,
    value,
    with_uncertainty,
)

from .tables import Table

#: From row to row of the deviation card.
_STEP_DEG = 45.0

Figures = Mapping[str, Figure]

_COLUMNS = 4
_FIGURES = list_figures(RunVerdict)


@dataclass(frozen=True, slots=True)
class Finding:
    """
    One section of the further findings.

    Attributes
    ----------
    block
        The block of a `RunVerdict`, whose words are the title.
    meaning
        How to read the figures.
    assumptions
        Letters of the assumptions that it supports, which conclude from the figures.
    rows, columns
        Keys within the block: figures, a row each; lists that belong together, a column each,
        whose items are the rows.
    side_by_side
        Keys of blocks with the figures of a `Shape`, a column each.

    """

    block: str
    meaning: str
    assumptions: str
    rows: str
    columns: str = ''
    side_by_side: str = ''

    @property
    def title(self) -> str:
        """Return what is examined."""
        words = _FIGURES[self.block].words
        return f'{words[0].upper()}{words[1:]}'

    def pick(self, keys: str) -> Figures:
        """Return the figures of keys within the block by their keys in a run."""
        return {f'{self.block}.{key}': _FIGURES[f'{self.block}.{key}'] for key in keys.split()}


@dataclass(frozen=True, slots=True)
class Described:
    """A section for the page: a sentence per run, and its tables with their titles."""

    title: str
    meaning: str
    concluded: Sequence[str]
    tables: Sequence[tuple[str, Table]]


_OF_HEADING = ('kind', 'off_deg', 'largest_deg', 'against_s', 'turns.kind', 'turns.n',
               'turns.turn_deg', 'turns.slope', 'turns.correlation', 'turns.delay_s')

_OF_QUALITY = ('n', 'n_reduced', 'reduced_share', 'flags', 'stated_median_deg',
               'stated_largest_deg')

FINDINGS = (
    Finding(
        'skew',
        'If the data of one sensor are older than their stamps say, every turn of the ship makes '
        'a difference that no sensor error causes. A positive latency means that the data of '
        'the TS are older. The estimate compares the differences with the rate of turn. The '
        'scan shifts one stream in time and looks for the least scatter.', 'b',
        'estimate.kind estimate.skew_s estimate.interval_s estimate.well_determined '
        'estimate.significant variance_aligned_deg2 outcome_as_paired outcome_aligned '
        'estimate.std_deg estimate.std_aligned_deg estimate.mean_aligned_deg '
        'estimate.rs_rate_std_deg_s estimate.rate_std_deg_s estimate.strength estimate.ols_s '
        'estimate.iv_s estimate.beyond_s estimate.also_s estimate.searched_s estimate.n '
        'scan.skew_s scan.bias_s scan.well_determined scan.at_edge scan.std_deg '
        'scan.std_zero_deg scan.mean_deg scan.mean_zero_deg scan.range_s scan.step_s scan.n'),
    Finding(
        'drift',
        'A drift is a slow change of the mean difference. It is described by a polynomial in '
        'time, by a straight line, and by an exponential as after switching on.', 'cf',
        'order.order order.beyond order.blocks coefficients_deg left_deg2 residual_std_deg span_h '
        'line.slope_deg_per_h line.interval_deg_per_h line.u_naive_deg_per_h line.intercept_deg '
        'line.tau_samples line.residual_std_deg warm_up.preferred warm_up.amplitude_deg '
        'warm_up.level_deg warm_up.tau_s warm_up.tolerance_deg warm_up.settle_s warm_up.span_s '
        'mser_s'),
    Finding(
        'heading_dependence',
        'The deviation is fitted as A + B sin ψ + C cos ψ + D sin 2ψ + E cos 2ψ, where ψ is the '
        'heading of the RS. A small probability means that the difference depends on it.', 'e',
        'reason coefficients_deg amplitude_deg f p residual_std_deg empty_arc_deg condition n'),
    Finding(
        'by_motion.turns',
        'A TS that follows late points to port of the RS in a turn to starboard, and to starboard '
        'in a turn to port. Starboard is positive.', '', '',
        'from_deg_s to_deg_s n duration_s rate_deg_s mean_deg low_deg up_deg std_deg'),
    Finding(
        'normality',
        'The model assumes a normal or a uniform distribution. Normal values have neither '
        'skewness nor excess kurtosis; uniform ones have an excess kurtosis of -1.2. A small '
        'probability speaks against normal values. The change of a sensor from reading to '
        'reading, and its deviation from a moving average, show its noise alone.', 'j',
        'thinned_step thinned_n anderson_darling anderson_darling_p moving_average_width '
        'ts_step_deg rs_step_deg ts_repeated_share rs_repeated_share rounding_variance_deg2',
        side_by_side='difference ts_first_difference rs_first_difference ts_moving_average '
        'rs_moving_average'),
    Finding(
        'stationarity',
        'Mean and variance must not change during the run. Small probabilities mean that they '
        'do.', 'h',
        'blocks block_s mean_z mean_p square_z square_p kpss kpss_p kpss_lags'),
    Finding(
        'correlation',
        'Neighbouring differences repeat each other. The effective numbers say how many '
        'independent differences would give as good a mean and as good a variance, by the '
        'correlation times of this section alone. The decision allows for slower errors too, so '
        'its number, among the results, is another one.', 'a',
        'n n_effective_mean n_effective_variance r1 tau_1_s tau_2_s window_s closed stamps.n '
        'stamps.typical_s stamps.nominal_s stamps.lost_share stamps.backward stamps.equal '
        'stamps.silences stamps.longest_back_s stamps.longest_s'),
    Finding(
        'motion',
        'On a straight course a heading points along the course over ground, but for leeway and '
        'current, which nobody knows. An angle beyond the bound is a gross error. A smaller one '
        'proves nothing. The rate of turn shows a heading that turns the other way, too far, or '
        'not at all.', '',
        'kind whose n_positions n_velocities n_rates n_legs legs_s astern_s least_bound_deg '
        + ' '.join(f'{sensor}.{key}' for sensor in ('ts', 'rs') for key in _OF_HEADING),
        'legs.duration_s legs.course_deg legs.speed_kn legs.bound_deg legs.ts_deg legs.rs_deg'),
    Finding(
        'quality',
        'Some sensors say how good a reading is: by a flag, or by the standard deviation that '
        'they claim. A claim is no proof, and a reading of unknown quality is not a poor one.', '',
        'ts_claim without_reduced '
        + ' '.join(f'{sensor}.{key}' for sensor in ('ts', 'rs') for key in _OF_QUALITY)),
    Finding(
        'allan',
        'The Allan deviation says how much neighbouring averages differ. White noise falls with '
        'the root of the averaging time; a level or rising deviation shows slow errors.', '', '',
        'tau_s m deviation_deg terms'),
    Finding(
        'allan.reference_noise',
        'Where the ship is quiet, the noise of both sensors can be told apart. The bound is the '
        'least that the RS scatters; it must not exceed its norm.', 'd', 'sigma_ref_lower_deg',
        'octaves ts_variance_deg2 rs_variance_deg2 following_deg2'),
)
"""The sections, in their order on the page."""

LEFT_TO_JSON = {
    'skew.scan.curve_s': 'the curve is drawn, not printed',
    'skew.scan.curve_std_deg': 'the curve is drawn, not printed',
    'drift.order.bic': 'only the order that it chooses says something',
    'motion.legs.start_ns': 'the legs are printed in their order, and drawn on the track',
    'normality.ts_step_seen_deg': 'the finding on the resolution says the step',
    'normality.rs_step_seen_deg': 'the finding on the resolution says the step',
    'by_motion.smoothed_s': 'the explanation says what a steady heading is',
    **{f'by_motion.sectors.{declared.name}': 'the table by heading, among the results, has it'
       for declared in fields(BySector)},
    'by_motion.rate_span_s': 'the figure by rate of turn has it',
    'heading_dependence.covariance_deg2': 'its diagonal is printed, as uncertainties',
}
"""Figures that the protocol leaves to the JSON, and why."""


def describe_findings(runs: Sequence[RunVerdict]) -> list[Described]:
    """Return the sections that say something about the runs, with their figures."""
    figures_of_runs = [(run.run, dict(flatten(run))) for run in runs]
    sections = []
    for finding in FINDINGS:
        blocks = [(run, figures) for run, figures in figures_of_runs
                  if any(key.startswith(f'{finding.block}.') for key in figures)]
        tables = [('', table) for table in rows_of_block(finding.pick(finding.rows), blocks)]
        for run, figures in blocks if finding.side_by_side else ():
            tables.append((f'Run {run}', _place_side_by_side(
                finding.pick(finding.side_by_side), figures)))
        for run, figures in blocks if finding.columns else ():
            columns = finding.pick(finding.columns)
            if rows := _columns(columns, figures):
                tables.append((f'Run {run}', Table(
                    [f'{figure.words} [{figure.unit}]' for figure in columns.values()], rows)))
        if finding.block == 'heading_dependence':
            tables += [(f'Run {run.run}: deviation card', card) for run in runs
                       if (card := make_deviation_card(run.heading_dependence)) is not None]
        if tables:
            sections.append(Described(finding.title, finding.meaning,
                                      _conclude(finding, runs), tables))
    return sections


def rows_of_block(figures: Figures,
                  blocks: Sequence[tuple[int, Mapping[str, Any]]]) -> list[Table]:
    """
    Return tables of the figures that at least one run has, a few runs in each.

    Parameters
    ----------
    figures : mapping of str to Figure
        The figures to show, by their keys.
    blocks
        Number of the run, and its figures by their dotted names.

    """
    tables = []
    for first in range(0, len(blocks), _COLUMNS):
        columns = blocks[first:first + _COLUMNS]
        rows = [[figure.words, figure.unit, *(_cell(key, figure, block) for _, block in columns)]
                for key, figure in figures.items()]
        if rows := [row for row in rows if {*row[2:]} != {ABSENT}]:
            tables.append(Table(['', 'unit', *(f'run {run}' for run, _ in columns)], rows))
    return tables


def _cell(key: str, figure: Figure, block: Mapping[str, Any]) -> str:
    thing = block.get(key)
    return (figure.choices[thing] if isinstance(thing, str) and thing in figure.choices
            else _text(thing, block.get(figure.u_key)))


def _text(thing: Any, u: Any = None) -> str:
    if isinstance(thing, (bool, str)) or thing is None:
        return value(thing)
    if isinstance(thing, (list, tuple)):
        return ', '.join(_text(element, element_u)
                         for element, element_u in zip_longest(thing, u or ())) or ABSENT
    return with_uncertainty(thing, u) if isinstance(thing, float) else number(thing)


def _columns(figures: Figures, block: Mapping[str, Any]) -> list[list[str]]:
    """Return a row for each item of the lists; without any, none."""
    lists = [[_text(element, u) for element, u in zip_longest(
        block.get(key) or (), block.get(figure.u_key) or ())] for key, figure in figures.items()]
    return [list(row) for row in zip(*lists)]


def _place_side_by_side(shapes: Figures, block: Mapping[str, Any]) -> Table:
    return Table(['', 'unit', *(shape.words for shape in shapes.values())],
                 [[figure.words, figure.unit,
                   *(_text(block.get(f'{name}.{key}')) for name in shapes)]
                  for key, figure in list_figures(Shape).items()])


def _conclude(finding: Finding, runs: Sequence[RunVerdict]) -> list[str]:
    """Return what the assumptions of GK say on the figures, a sentence per run."""
    return [f'Run {run.run}: assumption ({assumption.id}) is '
            f'{STATE_WORDS.get(assumption.state, assumption.state)}: {assumption.evidence}'
            for run in runs for assumption in run.assumptions
            if assumption.id in finding.assumptions]


def make_deviation_card(fit: HeadingDependence) -> Table | None:
    """
    Return the card of a run, a row per 45 deg.

    Parameters
    ----------
    fit
        The harmonics of the run.

    Returns
    -------
    Table or None
        None without coefficients, or if the ship left out more than 120 deg of the compass: there
        the fit would be a guess.

    """
    if fit.coefficients_deg is None or not holds_all_round(fit):
        return None
    headings = np.arange(0.0, 360.0, _STEP_DEG)
    x_deg, u_deg = deviation_at(fit, headings)
    mean_deg = fit.coefficients_deg[0]
    return Table(
        ['heading [deg]', 'TS - RS, fitted [deg]', 'correction to add to the TS [deg]',
         'of this by the heading [deg]'],
        [[number(at), with_uncertainty(x, u), with_uncertainty(-x, u), f'{mean_deg - x:.3f}']
         for at, x, u in zip(headings.tolist(), x_deg.tolist(), u_deg.tolist())
         if math.isfinite(x)])
