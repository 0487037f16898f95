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

"""A verdict on several sensors as text for people."""

from __future__ import annotations

import math
from typing import Callable, Iterator, Sequence

from .pair_figures import PairFigures
from .sensors_verdict import SensorResult, SensorsVerdict

__all__ = ['matrix_of', 'sensors_text', 'split_words', 'SHOWN']

SHOWN: tuple[tuple[str, Callable[[PairFigures, float], str]], ...] = (
    ('standard deviation of the difference [deg]', lambda pair, sign: _number(pair.std_deg)),
    ('  as share of what both norms explain',
     lambda pair, sign: '-' if pair.share is None else
     f'{pair.share:.2f}{" !" if pair.differs else ""}'),
    ('mean difference, row - column [deg]',
     lambda pair, sign: '-' if pair.mean_deg is None else f'{sign * pair.mean_deg:+.4f}'),
    ('age, row - column, and its standard uncertainty [s]',
     lambda pair, sign: '-' if pair.skew_s is None or pair.skew_u_s is None else
     f'{sign * pair.skew_s:+.3f} ({pair.skew_u_s:.3f})'),
)
"""The matrices that people see: title, and the text of a pair with the sign of row - column."""


def _number(value: float | None) -> str:
    return '-' if value is None else f'{value:.4f}'


def matrix_of(verdict: SensorsVerdict,
              text: Callable[[PairFigures, float], str]) -> list[list[str]]:
    """Return a matrix of texts with names as its first row and column."""
    names = [sensor.name for sensor in verdict.sensors]
    rows = [['', *names]]
    for row in names:
        cells = [row]
        for column in names:
            pair = verdict.find_pair(row, column)
            cells.append('' if row == column else '-' if pair is None else text(*pair))
        rows.append(cells)
    return rows


def split_words(sensor: SensorResult) -> str:
    """Return the standard deviation of a sensor from the split, with its range."""
    variance = sensor.variance
    if variance is None:
        return '-'
    low, high = (math.copysign(math.sqrt(abs(v)), v) for v in variance.interval_deg2)
    if variance.std_deg is None:
        return (f'negative variance {variance.variance_deg2:.3g} deg2: the errors are correlated, '
                'or the record is short')
    return f'{variance.std_deg:.4f} ({max(low, 0.0):.4f} .. {max(high, 0.0):.4f})'


def sensors_text(verdict: SensorsVerdict) -> str:
    """Return the outcomes, the matrices of all pairs, the vote and its evidence, as lines."""
    return '\n'.join(_lines(verdict))


def _lines(verdict: SensorsVerdict) -> Iterator[str]:
    yield f'VERDICT on {len(verdict.sensors)} sensors: {verdict.headline}'
    yield ''
    width = max(len(sensor.name) for sensor in verdict.sensors)
    for sensor in verdict.sensors:
        yield f'{sensor.name:{width}}  norm {sensor.sigma_max_deg:g} deg: {sensor.headline}'
    for title, text in SHOWN:
        yield ''
        yield title
        yield from _align(matrix_of(verdict, text))
    if any(pair.differs for pair in verdict.pairs):
        yield '  !: more than both norms explain'
    if any(sensor.variance for sensor in verdict.sensors):
        yield ''
        yield ('standard deviation of each sensor [deg] (at least 95 % range), if their errors '
               'are uncorrelated')
        for sensor in verdict.sensors:
            yield f'  {sensor.name:{width}}  {split_words(sensor)}'
    yield ''
    yield f'who is wrong: {verdict.vote.words} (risk {verdict.risk:g} that it names a sound one)'
    for pair in verdict.pairs:
        words = [*([f'differs: {pair.gross}'] if pair.gross else []),
                 *(f for f in pair.findings if f != pair.gross)]
        if words:
            yield f'  {pair.first} and {pair.second}: {"; ".join(words)}'


def _align(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        yield '  ' + '  '.join([f'{row[0]:{widths[0]}}', *(
            f'{cell:>{width}}' for cell, width in zip(row[1:], widths[1:]))]).rstrip()
