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

"""The verdict on several sensors: the outcome of each, all pairs, the vote; and as text."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Any, Callable, Iterator, Mapping, Sequence

from heading_intercompare.core.declared_figures import figure, no_key
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import (
    make_plain,
    read_plain,
)
from heading_intercompare.core.verdict.compare_verdicts import compare_plain, drop_sources
from heading_intercompare.core.verdict.verdict_document import (
    Input,
    make_document,
    read_head,
    Software,
    Verdict,
)
from heading_intercompare.core.version import RULE_VERSION

from .pair_figures import PairFigures
from .variance_split import SensorVariance
from .vote import Vote

_SCHEMA = 'heading_intercompare/sensors/'
SCHEMA_VERSION = '1.0'
"""Major and minor version of the mapping, as for a verdict."""
_MAJOR = int(SCHEMA_VERSION.partition('.')[0])
SCHEMA = f'{_SCHEMA}{_MAJOR}'
"""Kind of the document, and its major version only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorResult:
    """What the comparison says of one sensor; keys of the JSON."""

    name: str = figure('name of the sensor')
    role: str = figure('role of the sensor', '`ts` or `rs`')
    topic: str = figure('its topic')
    sigma_max_deg: float = figure('its norm')
    outcome: Outcome | None = figure('outcome of the sensor', 'null for the reference')
    headline: str = figure('outcome in one line')
    validity_effect: str = figure('gravest effect of a finding', '`holds`, `doubtful` or `void`')
    variance: SensorVariance | None = figure('its share in all variances', 'null for two sensors')


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorsVerdict:
    """The verdict on several sensors."""

    outcome: Outcome = figure('worst outcome of the tested sensors')
    headline: str = figure('all outcomes and the vote in one line')
    validity_effect: str = figure('gravest effect on any outcome', '`holds`, `doubtful` or `void`')
    software: Software = figure('the program that judged', default=Software())
    rule_version: int = figure('version of the decision rule', default=RULE_VERSION)
    settings: Settings = figure('every setting by its dotted name', 'with the sensors')
    inputs: Sequence[Input] = figure('where the readings came from')
    sensors: Sequence[SensorResult] = figure('what the comparison says of each sensor')
    pairs: Sequence[PairFigures] = figure('figures of each pair of sensors')
    vote: Vote = figure('which sensor is wrong')
    risk: float = figure('risk that the vote names a sound sensor while most are sound')
    verdicts: Mapping[str, Verdict] = figure('verdict on each tested sensor against the '
                                             'reference, by name', 'empty without a reference')
    signed: str | None = no_key()
    provenance: str | None = no_key()

    @property
    def settings_sha256(self) -> str:
        """Hash of the settings."""
        return settings_sha256(self.settings.to_mapping())

    def find_pair(self, first: str, second: str) -> tuple[PairFigures, float] | None:
        """Return the figures of two sensors, and 1, or -1 if they stand for second - first."""
        for pair in self.pairs:
            if pair.names == (first, second):
                return pair, 1.0
            if pair.names == (second, first):
                return pair, -1.0
        return None

    def __str__(self) -> str:
        """Return the tables that the command line prints."""
        return sensors_text(self)

    def __repr__(self) -> str:
        """Return the number of sensors and the headline."""
        return f'<Verdict on {len(self.sensors)} sensors: {self.headline}>'

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain dictionaries and lists, ready for JSON."""
        return make_document(replace(self, verdicts={}), SCHEMA, SCHEMA_VERSION) | {
            'verdicts': {name: verdict.to_dict() for name, verdict in self.verdicts.items()}}

    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any]) -> 'SensorsVerdict':
        """
        Return the verdict from a mapping of `to_dict`, or from its JSON.

        Raises
        ------
        VerdictError
            If it is another kind of document or of another major version, a key is missing, or a
            value is not of its type: one line that names the key.

        """
        settings = read_head(mapping, _SCHEMA, _MAJOR, 'verdicts')
        documents = read_plain(Mapping[str, Any], mapping['verdicts'], 'verdicts')
        verdict: SensorsVerdict = read_plain(
            cls, {**mapping, 'settings': make_plain(settings), 'verdicts': {}})
        return replace(verdict, verdicts={
            name: Verdict.from_dict(document) for name, document in documents.items()})


def is_of_sensors(mapping: object) -> bool:
    """Tell whether a document is a verdict on several sensors, of any version."""
    return isinstance(mapping, Mapping) and str(mapping.get('schema', '')).startswith(_SCHEMA)


def find_sensor_differences(a: SensorsVerdict, b: SensorsVerdict) -> Iterator[str]:
    """
    Yield the differences of two verdicts, except those of their sources.

    Yields
    ------
    str
        One difference with the names of the JSON, as `find_differences`.

    """
    yield from compare_plain(_describe_without_sources(a), _describe_without_sources(b))


def _describe_without_sources(verdict: SensorsVerdict) -> dict[str, Any]:
    return replace(verdict, inputs=(), verdicts={
        name: drop_sources(of_pair) for name, of_pair in verdict.verdicts.items()}).to_dict()


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
    if verdict.provenance is not None:
        yield verdict.provenance
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
