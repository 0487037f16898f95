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

"""A test of a norm as judged: its figure, its limit, its state, and how to sail it."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Sequence

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.required_tests import KINDS, OWN, RequiredTest, UNVERIFIED, VERIFIED
from heading_intercompare.core.settings import Risk

MET, NOT_MET, OPEN, NOT_SAILED = 'met', 'not_met', 'open', 'not_sailed'

STATES = {MET: 'met', NOT_MET: 'not met', OPEN: 'open', NOT_SAILED: 'not sailed'}
"""The states of a test, and their words."""

_GRAVEST_FIRST = (NOT_MET, MET, OPEN, NOT_SAILED)


@dataclass(frozen=True, slots=True)
class TestRisks:
    """
    The risks of one test out of several.

    Attributes
    ----------
    met
        Of calling it met for a sensor at its limit.
    not_met
        Of calling it not met for a sensor at its limit: the producer's risk is shared among the
        tests of the norm, and among runs.

    """

    __test__ = False

    met: float
    not_met: float

    @classmethod
    def of(cls, risk: Risk, tests: int, runs: int = 1) -> 'TestRisks':
        """Share the risks of a verdict among its tests and runs."""
        return cls(risk.alpha_consumer, risk.alpha_producer / max(1, tests * runs))


@dataclass(frozen=True, slots=True)
class SettlePoint:
    """Ten readings after a start: mean, variance about it, and heading."""

    mean_deg: float = figure('settle-point error', 'mean of ten differences')
    variance_deg2: float = figure('variance of its ten readings')
    heading_deg: float = figure('heading at its first reading')


@dataclass(frozen=True, slots=True)
class Measurement:
    """
    What a record shows of one test.

    Attributes
    ----------
    value, low, high
        The figure, and its bounds at the two risks, in the unit of the test; None if the record
        shows nothing of it.
    risk_not_met
        Smallest risk at which the test is not met: the probability of a figure at least as large
        from a sensor at its limit. None if it cannot be told.
    sailed
        Whether the record holds what the test asks for: only then may it be met.
    record
        What the record holds of it, in words.
    unless
        What else explains a figure above the limit, in words; empty if nothing does.
    settle_point
        That of a run that begins with a start.

    """

    value: float | None = None
    low: float | None = None
    high: float | None = None
    risk_not_met: float | None = None
    sailed: bool = False
    record: str = ''
    unless: str = ''
    settle_point: SettlePoint | None = None


@dataclass(frozen=True, slots=True)
class JudgedTest:
    """One row of the table of tests; keys of the JSON."""

    kind: str = figure('test', choices={name: kind.words for name, kind in KINDS.items()})
    words: str = figure('what is limited')
    clause: str = figure('clause of the norm')
    status: str = figure('whether its text was read', choices={
        VERIFIED: 'in the document', UNVERIFIED: 'only in a draft or another source',
        OWN: 'a limit of `norms.tests`'})
    unit: str = figure('unit of figure and limit', 'deg or h')
    limit: float = figure('limit', 'at the latitude of the norm', unit='')
    state: str = figure('result', choices=STATES)
    value: float | None = figure('figure', 'null if the record shows nothing of it', unit='')
    low: float | None = figure('its lower .. upper bound', 'at the risks of the test', up='high',
                               unit='')
    high: float | None = figure('upper bound', unit='')
    risk_not_met: float | None = figure(
        'smallest risk at which it is not met', "that of the test is the producer's risk over "
        'the number of tests', unit='1')
    sailed: bool = figure('whether the record holds what the test asks for')
    record: str = figure('what the record holds of it')
    manoeuvre: str = figure('what to sail, or to wait for, to decide it')
    unless: str = figure('another explanation of a figure above the limit', 'empty without one')
    settle_point: SettlePoint | None = figure(
        'settle point of the start that the run begins with',
        absent='but in the test of its repeatability')
    run: int | None = figure('number of the run that decides', absent='in the table of a run, '
                             'and if all runs together decide', unit='')

    @property
    def source(self) -> str:
        """Return the clause, marked if its text was not read."""
        return f'{self.clause} [unverified]' if self.status == UNVERIFIED else self.clause

    @property
    def line(self) -> str:
        """Return the test in a sentence, as for a headline."""
        figures = '' if self.value is None else f' {_number(self.value)} {self.unit},'
        return f'{self.words}{figures} limit {self.limit:.3g} {self.unit} ({self.source})'

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Return result, figure with its bounds, limit and clause, as for a table."""
        figures = '-' if self.value is None or self.low is None or self.high is None else (
            f'{_number(self.value)} ({_number(self.low)} .. {_number(self.high)})')
        return STATES[self.state], figures, f'{self.limit:.3g} {self.unit}', self.source

    @property
    def notes(self) -> str:
        """Return what the record holds, and what decides the test or explains its figure."""
        parts = [self.record]
        if self.state == NOT_MET and self.unless:
            parts.append(f'unless {self.unless}')
        if self.state in (OPEN, NOT_SAILED):
            parts.append(f'to decide it: {self.manoeuvre}')
        return '; '.join(filter(None, parts))

    def with_measurement(self, measured: Measurement, risks: TestRisks) -> 'JudgedTest':
        """Return the test with what a record shows of it, judged."""
        return replace(self, **{declared.name: getattr(measured, declared.name)
                                for declared in fields(measured)}).judge(risks)

    def judge(self, risks: TestRisks) -> 'JudgedTest':
        """Return the test with the state that its figures give at these risks."""
        return replace(self, state=self._find_state(risks))

    def _find_state(self, risks: TestRisks) -> str:
        if self.value is not None and self.value > self.limit and (
                self.risk_not_met is not None and self.risk_not_met <= risks.not_met):
            return NOT_MET
        if self.value is None or not self.sailed:
            return NOT_SAILED
        return MET if self.high is not None and self.high <= self.limit else OPEN


def _number(value: float) -> str:
    """Return a figure with two decimals, or with one significant digit if it is small."""
    return f'{value:.1g}' if 0.0 < value < 0.01 else f'{value:.2f}'


def judge_measurement(required: RequiredTest, limit: float, measured: Measurement,
                      risks: TestRisks) -> JudgedTest:
    """Return a required test with what a record shows of it."""
    return JudgedTest(
        kind=required.kind, words=required.words, clause=required.clause, status=required.status,
        unit=KINDS[required.kind].unit, limit=limit, state=OPEN, value=None, low=None, high=None,
        risk_not_met=None, sailed=False, record='', manoeuvre=required.manoeuvre,
        unless='').with_measurement(measured, risks)


def merge_runs(tables: Sequence[tuple[int, Sequence[JudgedTest]]],
               risks: TestRisks) -> tuple[JudgedTest, ...]:
    """
    Return one table from those of several runs.

    Parameters
    ----------
    tables
        The number of each run, and its table; all have the same tests.
    risks
        With the producer's risk shared among the runs.

    Notes
    -----
    A test is not met if a run breaks it, and met if a run meets it: a test is sailed once. The
    row is that of the run that decides.

    """
    rows = []
    for same in zip(*(table for _, table in tables)):
        judged = [replace(row.judge(risks), run=number)
                  for (number, _), row in zip(tables, same)]
        rows.append(min(judged, key=lambda row: (
            _GRAVEST_FIRST.index(row.state),
            1.0 if row.risk_not_met is None else row.risk_not_met)))
    return tuple(rows)


def find_not_met(tests: Sequence[JudgedTest]) -> JudgedTest | None:
    """Return the first test that is not met, one without another explanation before others."""
    broken = [test for test in tests if test.state == NOT_MET]
    return min(broken, key=lambda test: bool(test.unless), default=None)


def say_not_met(tests: Sequence[JudgedTest]) -> str:
    """Return the tests that are not met, with figures and limits; empty if none."""
    return ', '.join(test.line for test in tests if test.state == NOT_MET)


def say_open(tests: Sequence[JudgedTest]) -> str:
    """
    Return which tests a certificate leaves open, in a few words; empty if none.

    Examples
    --------
    >>> say_open([])
    ''

    """
    groups = []
    for state in (OPEN, NOT_SAILED):
        names = [test.words for test in tests if test.state == state]
        if names:
            groups.append(f'{STATES[state]}: {", ".join(names)}')
    met = sum(test.state == MET for test in tests)
    return f'{met} of {len(tests)} tests of the norm met; {"; ".join(groups)}' if groups else ''
