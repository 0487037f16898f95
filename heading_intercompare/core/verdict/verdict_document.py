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

"""The verdict as a document: findings of each run, the campaign, and the mapping for JSON."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Iterable, Mapping, Sequence, TYPE_CHECKING

from heading_intercompare.core.decision.campaign import Together
from heading_intercompare.core.decision.coverage import Coverage
from heading_intercompare.core.decision.criteria import (
    CountCriterion,
    Limits,
    TotalError,
    VarianceCriterion,
)
from heading_intercompare.core.decision.guarded import Guarded
from heading_intercompare.core.decision.sequential import LookVerdict
from heading_intercompare.core.decision.taken_out import TakenOut
from heading_intercompare.core.declared_figures import figure, is_left_out, list_keys, no_key
from heading_intercompare.core.declared_settings import settings_sha256, SettingsError
from heading_intercompare.core.diagnostics.assumptions import Assumption
from heading_intercompare.core.diagnostics.by_motion import ByMotion
from heading_intercompare.core.diagnostics.deviation import HeadingDependence
from heading_intercompare.core.diagnostics.percentile import Percentile
from heading_intercompare.core.diagnostics.run_findings import Allan, Correlation, Drift, RunSkew
from heading_intercompare.core.diagnostics.sensor_quality import QualityCheck
from heading_intercompare.core.motion.motion_check import MotionCheck
from heading_intercompare.core.norm_tests.judged_test import JudgedTest
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.runs.pairing_figures import PairingFigures
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.normality import Normality
from heading_intercompare.core.statistics.stationarity import Homogeneity, Stationarity
from heading_intercompare.core.typed_reader import (
    check_schema,
    make_plain,
    read_plain,
    VerdictError,
)
from heading_intercompare.core.validity.condition import (
    DOUBTFUL,
    Finding,
    gravest,
    VOID,
    worst_effect,
)
from heading_intercompare.core.version import RULE_VERSION, VERSION

from .chosen_runs import ChosenRuns
from .conclusion import campaign_words
from .headline import compose_headline

if TYPE_CHECKING:
    import pandas


_SCHEMA = 'heading_intercompare/verdict/'
SCHEMA_VERSION = '1.0'
"""
Major and minor version of the mapping.

The minor version increases when keys are added, which readers ignore, or a key that may be absent
goes; the major version when another key disappears or changes its meaning.
"""
_MAJOR = int(SCHEMA_VERSION.partition('.')[0])
SCHEMA = f'{_SCHEMA}{_MAJOR}'
"""Kind of the document, and its major version only."""


@dataclass(frozen=True, slots=True)
class RunVerdict:
    """
    All findings of one run; the fields are the keys of the JSON, in its order.

    Angles are in degrees, variances in square degrees, stamps in nanoseconds; a missing figure is
    None.
    """

    def __repr__(self) -> str:
        """Return the number of the run and the headline."""
        return f'<RunVerdict on run {self.run}: {self.headline}>'

    run: int = figure('number of the run, from 1', unit='')
    source: str = figure('source', 'name of the input')
    start_ns: int = figure('first pair', row='first pair, UTC')
    end_ns: int = figure('last pair')
    duration_s: float = figure('duration')
    pairing: PairingFigures = figure('share of the run in the ledger')
    n_input: int = figure('pairs given')
    n_invalid: int = figure('left out: not finite')
    n_stabilization: int = figure('left out: stabilisation period')
    n: int = figure('differences analysed, n', row='analysed n')
    mean_deg: float | None = figure('mean difference')
    min_deg: float | None = figure('minimum difference')
    max_deg: float | None = figure('maximum difference')
    max_abs_deg: float | None = figure('largest |difference|')
    mean_square_deg2: float | None = figure('mean square')
    circular_mean_deg: float | None = figure('direction of the mean of unit vectors')
    resultant_length: float | None = figure('resultant length', 'of the mean of unit vectors')
    drift_coefficients_deg: tuple[float, ...] = figure('coefficients of the drift removed',
                                                       'Legendre; empty for `drift_order` 0')
    variance_deg2: float | None = figure('variance, GK (4)', row='variance')
    std_deg: float | None = figure('standard deviation')
    variance_criterion: VarianceCriterion = figure('GK (5)')
    count_criterion: CountCriterion = figure('GK (6)')
    total_error: TotalError = figure('GK (7)')
    outcome: Outcome = figure('outcome')
    reason: str = figure('why the outcome is as it is', 'see risk.md')
    headline: str = figure('outcome in one line', 'with the binding findings, and the coverage')
    validity: Sequence[Finding] = figure('what the data say about each condition')
    validity_effect: str = figure('gravest effect of a finding', '`holds`, `doubtful` or `void`')
    coverage: Coverage = figure('errors that the verdict covers')
    looks: Sequence[LookVerdict] = figure('looks at the run in progress', 'empty without a plan')
    paper_outcome: Outcome = figure('GK as printed')
    guarded: Guarded = figure('decision with a stated risk', 'see risk.md')
    skew: RunSkew = figure('latency or clock offset between the sensors')
    drift: Drift = figure('drift and warm-up')
    heading_dependence: HeadingDependence = figure('dependence on the heading')
    normality: Normality = figure('distribution of the errors')
    stationarity: Stationarity = figure('constancy in time')
    correlation: Correlation = figure('correlation in time')
    allan: Allan = figure('scatter against averaging time')
    assumptions: Sequence[Assumption] = figure('assumptions (a) to (j) of GK')
    warnings: Sequence[str] = figure('sentences of warning', 'the word before the colon is fixed')
    taken_out: TakenOut | None = figure('what was taken out by hand', absent='if nothing was')
    motion: MotionCheck | None = figure('headings against the motion of the ship',
                                        absent='if it is not known')
    by_motion: ByMotion | None = figure('differences by heading and by the rate of turn',
                                        absent='with fewer than 64 differences')
    quality: QualityCheck | None = figure('what the sensors say of their readings',
                                          absent='if they say nothing')
    limit_95: Percentile | None = figure('limit that 95 % of the differences keep',
                                         absent='with fewer than 20 independent differences')
    norm_tests: Sequence[JudgedTest] | None = figure(
        'tests that the norm requires, and what this run shows of each',
        absent='if the norm requires none')
    clock_segment: int | None = figure('clocks set back before it',
                                       'stamps are repeated from segment to segment', unit='1',
                                       absent='if none was')
    evidence: Any = no_key()

    @property
    def conditions_in_doubt(self) -> str:
        """Return the conditions that do not hold, such as ``losses=doubtful``, with commas."""
        return ','.join(f'{finding.condition}={finding.effect}' for finding in self.validity
                        if finding.effect in (DOUBTFUL, VOID))


@dataclass(frozen=True, slots=True)
class Campaign:
    """
    The result of all runs together; keys of the JSON, None if no run has the figure.

    The rule that decides and its reason; the worst of m runs, GK variant C; the number of runs
    with each outcome; the common variance.
    """

    rule: str = figure('rule for the runs together', 'the setting `campaign.rule`')
    reason: str = figure('why the outcome is as it is', 'see risk.md')
    m: int = figure('runs, m')
    worst_variance_deg2: float | None = figure('largest variance')
    worst_variance_run: int | None = figure('in run', 'the run with the largest variance', unit='')
    worst_plus_rate: float | None = figure('largest rate beyond the limit', 'n⁺/n')
    worst_plus_plus_rate: float | None = figure('largest rate beyond the tightened limit', 'n⁺⁺/n')
    a_low_deg: float | None = figure('mean difference, minimum')
    a_up_deg: float | None = figure('mean difference, maximum')
    low_worst_deg: float | None = figure('total TS error, minimum', 'outermost limit of GK (7)')
    up_worst_deg: float | None = figure('total TS error, maximum', 'outermost limit of GK (7)')
    homogeneity: Homogeneity = figure('how the runs compare with each other')
    runs_by_outcome: Mapping[str, int] = figure('number of runs with each outcome, each alone')
    sensor: Together | None = figure('the variance that all runs share, under either rule',
                                     'null if no run has 128 differences')
    validity: Sequence[Finding] = figure('findings on the runs together, as those of a run')
    norm_tests: Sequence[JudgedTest] | None = figure(
        'tests that the norm requires, by all runs', 'each row is that of the run that decides',
        absent='if the norm requires none')

    @classmethod
    def of(cls, runs: Sequence[RunVerdict], homogeneity: Homogeneity, rule: str, reason: str,
           sensor: Together | None, validity: Sequence[Finding],
           norm_tests: Sequence[JudgedTest]) -> 'Campaign':
        """Build the result of all runs together."""
        def apply(pick: Callable[[list[float]], float],
                 values: Iterable[float | None]) -> float | None:
            present = [v for v in values if v is not None]
            return pick(present) if present else None

        variances = [(r.variance_deg2, r.run) for r in runs if r.variance_deg2 is not None]
        # On a tie the first run.
        largest = max(variances, key=lambda of_run: of_run[0], default=None)
        counted = [r for r in runs if r.n]
        return cls(
            rule=rule, reason=reason, m=len(runs),
            worst_variance_deg2=largest[0] if largest else None,
            worst_variance_run=largest[1] if largest else None,
            worst_plus_rate=apply(max, [r.count_criterion.n_plus / r.n for r in counted]),
            worst_plus_plus_rate=apply(max, [r.count_criterion.n_plus_plus / r.n
                                             for r in counted]),
            a_low_deg=apply(min, [r.mean_deg for r in runs]),
            a_up_deg=apply(max, [r.mean_deg for r in runs]),
            low_worst_deg=apply(min, [r.total_error.low_deg for r in runs]),
            up_worst_deg=apply(max, [r.total_error.up_deg for r in runs]), homogeneity=homogeneity,
            runs_by_outcome={o.value: sum(r.outcome is o for r in runs) for o in Outcome},
            sensor=sensor, validity=tuple(validity), norm_tests=tuple(norm_tests) or None)


@dataclass(frozen=True, slots=True)
class OperatorNote:
    """A note of the operator, with its time."""

    stamp_ns: int = figure('time of the note')
    text: str = figure('its text')


@dataclass(frozen=True, slots=True)
class Input:
    """The source of readings, and its problems."""

    path: str = figure('path as given')
    sha256: str | None = figure('SHA-256 of the data', 'null if not readable', default=None)
    ts_topic: str | None = figure('topic of the TS', 'of those that made the pairs; of the '
                                  'first of two logs its sentence, or `csv`', default=None)
    rs_topic: str | None = figure('topic of the RS', 'as for the TS; of the second of two logs '
                                  'the sentence, or `csv`', default=None)
    notes: tuple[OperatorNote, ...] | None = figure(
        'notes of the operator, in the order of their times', absent='without any')
    error: str | None = figure('why it could not be read', 'then no outcome is better than '
                               'indeterminate', absent='otherwise')
    no_run: str | None = figure('why it has no run, and an account of its readings',
                                'then no outcome is better than indeterminate', absent='otherwise')
    same_as: str | None = figure('path of an earlier input with equal data', absent='without one')
    continues: str | None = figure('path of the input that it was judged together with, as this '
                                   'trial began there', absent='otherwise')
    ledger_problems: tuple[str, ...] | None = figure(
        'why its readings are not all accounted for, and where a journal ends', absent='otherwise')
    not_taken: Mapping[str, int] | None = figure('lines of a log that gave no heading, by reason',
                                                 absent='if it is no log')
    made_from: Mapping[str, str | None] | None = figure(
        'path and SHA-256 of each recording whose readings a csv of pairs has', absent='otherwise')

    @property
    def why_no_run(self) -> str | None:
        """Why this input has no run; None if it has one."""
        if self.same_as is not None:
            return f'it has the data of {self.same_as}'
        if self.continues is not None:
            return f'it was judged together with {self.continues}'
        return self.error or self.no_run


@dataclass(frozen=True, slots=True)
class RecordedChunks:
    """What a recorder had written to its bag, as the hash chain through its chunks says."""

    path: str = figure('path of the bag, as its recorder has it')
    chunks: int = figure('chunks written', 'over all its files in order', unit='1')
    sha256: str = figure('newest hash of the chain through these chunks', 'see bags.md')


@dataclass(frozen=True, slots=True)
class Software:
    """The software that judged."""

    name: str = figure('name of the program', default='heading_intercompare')
    version: str = figure('its version', default=VERSION)


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """The verdict of all runs on the TS."""

    outcome: Outcome = figure('outcome', 'the guarded decision by `campaign.rule`')
    headline: str = figure('outcome in one line', 'with the binding findings, and the coverage')
    validity_effect: str = figure('gravest effect in any run', '`holds`, `doubtful` or `void`')
    paper_outcome: Outcome = figure('GK as printed, worst of the runs')
    software: Software = figure('the program that judged', default=Software())
    rule_version: int = figure('version of the decision rule', default=RULE_VERSION)
    settings: Settings = figure('every setting by its dotted name, as at the start',
                                'see settings.md')
    operator_actions: tuple[OperatorNote, ...] | None = figure(
        'what operators did while the nodes ran, such as changes of settings',
        'a recording has it among the notes of its input',
        absent='if nothing, and in the verdict on a recording')
    recordings: tuple[RecordedChunks, ...] | None = figure(
        'bags that were recorded meanwhile, as their recorders said last',
        '`verify` compares them; the newest second of a bag is not covered',
        absent='if no recorder was heard, and in the verdict on a recording')
    inputs: Sequence[Input] = figure('where the readings came from', 'empty without files')
    ledger_problems: Sequence[str] = figure('why not every reading is accounted for, in sentences',
                                            'empty if all are', default=())
    intermediate: bool | None = figure('whether the last run was still in progress',
                                       'its outcome is then that of a stop', absent='otherwise')
    taken_out: TakenOut | None = figure('pairs that the runs leave out', absent='without any')
    chosen: ChosenRuns | None = figure('the runs of a logbook that are judged together',
                                       'by `history --certify`', absent='otherwise')
    campaign: Campaign = figure('the runs together')
    runs: Sequence[RunVerdict] = figure('the runs, in the order of the inputs and of time')
    plotter: Any = no_key()
    signed: str | None = no_key()
    provenance: str | None = no_key()

    @property
    def ledger_complete(self) -> bool:
        """Whether the ledger accounts for every reading."""
        return not self.ledger_problems

    @property
    def settings_sha256(self) -> str:
        """Hash of the settings."""
        return settings_sha256(self.settings.to_mapping())

    @classmethod
    def of(cls, runs: Sequence[RunVerdict], outcome: Outcome, campaign: Campaign,
           coverage: Coverage | None, settings: Settings, inputs: Sequence[Input]) -> 'Verdict':
        """Build the verdict from runs and from their result together."""
        is_alone = len(runs) == 1 and campaign.rule == 'every_run'
        if is_alone and runs[0].outcome is outcome and not any(f.words for f in campaign.validity):
            line = runs[0].headline
        else:
            findings = [*campaign.validity, *(
                replace(f, words=f'run {r.run}: {f.words}') if f.words and len(runs) > 1 else f
                for r in runs for f in r.validity)]
            why = campaign_words(campaign, runs, coverage)
            line = compose_headline(outcome, findings, coverage, why,
                                    campaign.norm_tests or ())
        problems = tuple(f'{recording.path}: {problem}' for recording in inputs
                         for problem in recording.ledger_problems or ())
        return cls(outcome=outcome, headline=line, validity_effect=gravest(
            [worst_effect(campaign.validity), *(r.validity_effect for r in runs)]),
                   paper_outcome=worst(r.paper_outcome for r in runs), settings=settings,
                   inputs=tuple(inputs), ledger_problems=problems, campaign=campaign,
                   runs=tuple(runs))

    def __str__(self) -> str:
        """Return the table that the command line prints."""
        from .verdict_table import verdict_text
        return verdict_text(self)

    def __repr__(self) -> str:
        """Return the number of runs and the headline."""
        runs = '1 run' if len(self.runs) == 1 else f'{len(self.runs)} runs'
        return f'<Verdict on {runs}: {self.headline}>'

    def _repr_html_(self) -> str:
        """Return the same table for notebooks."""
        from .verdict_table import verdict_html
        return verdict_html(self)

    def summary(self) -> str:
        """Return the headline, and a line for each run."""
        from .verdict_table import summary_text
        return summary_text(self)

    def to_frame(self) -> 'pandas.DataFrame':
        """Return the figures, a row per run; see `frame_of_runs`. ValueError without pandas."""
        from .verdict_frame import frame_of_runs
        return frame_of_runs(self)

    def plot(self, name: str | None = None) -> Any:
        """Return the figures of ``docs/figures.md`` for a notebook, or the one of a name."""
        if self.plotter is None:
            raise ValueError('plot: this verdict knows no readings to draw; judge them with '
                             'analyze, analyze_bag or analyze_bags')
        return self.plotter(self, name)

    def to_dict(self) -> dict[str, Any]:
        """Return the verdict as plain dictionaries and lists, ready for JSON."""
        return make_document(self, SCHEMA, SCHEMA_VERSION)

    @classmethod
    def from_dict(cls, mapping: Mapping[str, Any]) -> 'Verdict':
        """
        Return the verdict from a mapping of `to_dict`, or from its JSON.

        Raises
        ------
        VerdictError
            If the major version differs, a key is missing, a value is not of its type, or the
            settings do not match their hash: one line that names the key. Unknown keys are
            ignored, unknown settings are not.

        Notes
        -----
        `to_dict` of the result is the mapping again. A number that was not finite is nan.

        """
        settings = read_head(mapping, _SCHEMA, _MAJOR, 'ledger_complete')
        try:
            Limits.of(settings.norms, settings.model)
        except SettingsError as error:
            raise VerdictError(f'settings: {error}') from error
        verdict: Verdict = read_plain(cls, {**mapping, 'settings': make_plain(settings)})
        complete, stated = verdict.ledger_complete, mapping['ledger_complete']
        if stated is not complete:
            raise VerdictError(f'ledger_complete = {stated!r:.70}: must be '
                               f'{make_plain(complete)!r} by ledger_problems')
        return verdict


def mark_intermediate(verdict: Verdict) -> Verdict:
    """Return a verdict that a stop now would give, marked as such."""
    return replace(verdict, intermediate=True,
                   headline=f'INTERMEDIATE, what a stop now would give: {verdict.headline}')


def make_document(verdict: Any, schema: str, version: str) -> dict[str, Any]:
    """Return the JSON of a verdict; what follows from a key stands before it."""
    document: dict[str, Any] = {'schema': schema, 'schema_version': version}
    for declared in list_keys(verdict):
        value = getattr(verdict, declared.name)
        if declared.name == 'settings':
            document['settings_sha256'], value = verdict.settings_sha256, value.to_mapping()
        elif declared.name == 'ledger_problems':
            document['ledger_complete'] = verdict.ledger_complete
        if not is_left_out(declared, value):
            document[declared.name] = make_plain(value)
    return document


def read_head(mapping: Any, schema: str, major: int, key: str) -> Settings:
    """
    Return the settings of a document of this schema, which must also have a key.

    Raises
    ------
    VerdictError
        If it is another kind of document, or a key is missing, or as in `read_settings`.

    """
    if not isinstance(mapping, Mapping):
        raise VerdictError(f'a verdict must be an object, not {type(mapping).__name__}')
    check_schema(mapping, schema, major)
    for name in ('settings', 'settings_sha256', key):
        if name not in mapping:
            raise VerdictError(f'{name} is missing')
    return read_settings(mapping['settings'], mapping['settings_sha256'])


def read_settings(mapping: Any, sha256: Any) -> Settings:
    """
    Return the settings of a document, given their hash.

    All settings must be present: a default could differ from the value that was used.

    Raises
    ------
    VerdictError
        If a setting is missing, unknown or wrong, or the hash is another.

    """
    stored = read_plain(Mapping[str, Any], mapping, 'settings')
    for name in Settings().to_mapping():
        if name not in stored:
            raise VerdictError(f'settings.{name} is missing')
    try:
        settings = Settings.from_mapping(stored)
    except SettingsError as error:
        raise VerdictError(f'settings: {error}') from error
    digest = settings_sha256(settings.to_mapping())
    if sha256 != digest:
        raise VerdictError(f'settings_sha256 = {sha256!r:.70}: the settings have {digest!r}, so '
                           'they were changed afterwards')
    return settings
