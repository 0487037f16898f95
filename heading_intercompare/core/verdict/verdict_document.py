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

from dataclasses import dataclass, field, replace
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
from heading_intercompare.core.diagnostics.assumptions import Assumption
from heading_intercompare.core.diagnostics.deviation import HeadingDependence
from heading_intercompare.core.diagnostics.percentile import Percentile
from heading_intercompare.core.diagnostics.run_findings import Allan, Correlation, Drift, RunSkew
from heading_intercompare.core.json_keys import leave_out_none, no_key
from heading_intercompare.core.motion.motion_check import MotionCheck
from heading_intercompare.core.outcome import Outcome, worst
from heading_intercompare.core.runs.pairing_figures import PairingFigures
from heading_intercompare.core.settings import (
    fill_in_added,
    is_added,
    leave_out_added,
    Settings,
    settings_sha256,
    SettingsError,
)
from heading_intercompare.core.statistics.ergodicity import Homogeneity
from heading_intercompare.core.statistics.normality import Normality
from heading_intercompare.core.statistics.stationarity import Stationarity
from heading_intercompare.core.typed_reader import (
    check_schema,
    make_plain,
    read_plain,
    VerdictError,
)
from heading_intercompare.core.validity.condition import Finding, gravest, worst_effect
from heading_intercompare.core.version import RULE_VERSION, VERSION

from .conclusion import campaign_words
from .headline import compose_headline

if TYPE_CHECKING:
    import pandas

__all__ = ['Campaign', 'Input', 'OperatorNote', 'RunVerdict', 'SCHEMA', 'SCHEMA_VERSION',
           'Software', 'Verdict', 'VerdictError']

_SCHEMA = 'heading_intercompare/verdict/'
SCHEMA_VERSION = '2.7'
"""
Major and minor version of the mapping.

The minor version increases when keys are added, which readers ignore, or a key that may be absent
goes; the major version when another key disappears or changes its meaning.
"""
_MAJOR = int(SCHEMA_VERSION.partition('.')[0])
SCHEMA = f'{_SCHEMA}{_MAJOR}'
"""Kind of the document, and its major version only."""
_AGAIN = 'judge the recordings again, with `analyze` or `rejudge`'


@dataclass(frozen=True, slots=True)
class RunVerdict:
    """
    All findings of one run; the fields are the keys of the JSON, in its order.

    Attributes are documented with the JSON in ``docs/verdict_json.md``. Angles are in degrees,
    variances in square degrees, stamps in nanoseconds; a missing figure is None.
    """

    run: int
    source: str
    start_ns: int
    end_ns: int
    duration_s: float
    pairing: PairingFigures
    n_input: int
    n_invalid: int
    n_stabilization: int
    n: int
    mean_deg: float | None
    min_deg: float | None
    max_deg: float | None
    max_abs_deg: float | None
    mean_square_deg2: float | None
    circular_mean_deg: float | None
    resultant_length: float | None
    drift_coefficients_deg: tuple[float, ...]
    variance_deg2: float | None
    std_deg: float | None
    variance_criterion: VarianceCriterion
    count_criterion: CountCriterion
    total_error: TotalError
    outcome: Outcome
    reason: str
    headline: str
    validity: Sequence[Finding]
    validity_effect: str
    coverage: Coverage
    looks: Sequence[LookVerdict]
    paper_outcome: Outcome
    guarded: Guarded
    skew: RunSkew
    drift: Drift
    heading_dependence: HeadingDependence
    normality: Normality
    stationarity: Stationarity
    correlation: Correlation
    allan: Allan
    assumptions: Sequence[Assumption]
    warnings: Sequence[str]
    taken_out: TakenOut | None = leave_out_none()
    motion: MotionCheck | None = leave_out_none()
    #: None before version 2.7, and with too few independent differences.
    limit_95: Percentile | None = leave_out_none()


@dataclass(frozen=True, slots=True)
class Campaign:
    """
    The result of all runs together; keys of the JSON, None if no run has the figure.

    The rule that decides and its reason; the worst of m runs, GK variant C; the number of runs
    with each outcome; the common variance.
    """

    rule: str
    reason: str
    m: int
    worst_variance_deg2: float | None
    worst_variance_run: int | None
    worst_plus_rate: float | None
    worst_plus_plus_rate: float | None
    a_low_deg: float | None
    a_up_deg: float | None
    low_worst_deg: float | None
    up_worst_deg: float | None
    homogeneity: Homogeneity
    runs_by_outcome: Mapping[str, int]
    sensor: Together | None
    #: Findings on the runs together; None before version 2.7.
    validity: Sequence[Finding] | None = leave_out_none()

    @classmethod
    def of(cls, runs: Sequence[RunVerdict], homogeneity: Homogeneity, rule: str, reason: str,
           sensor: Together | None, validity: Sequence[Finding]) -> 'Campaign':
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
            sensor=sensor, validity=tuple(validity))


@dataclass(frozen=True, slots=True)
class OperatorNote:
    """A note of the operator, with its time."""

    stamp_ns: int
    text: str


@dataclass(frozen=True, slots=True)
class Input:
    """
    The source of readings, and its problems.

    Attributes
    ----------
    path : str
        Path as given.
    sha256 : str or None
        Hash of its data; None if it could not be read.
    ts_topic, rs_topic : str or None
        Topics read, or that made the pairs of a journal or csv. Of a log one topic is its sentence
        ('HEHDT'), or 'csv', and the other topic None.
    notes : tuple of OperatorNote, or None
        Notes of the operator, in time order.
    error : str or None
        Why it could not be read.
    no_run : str or None
        Why it gave no run, and the fate of its readings.
    same_as, continues : str or None
        Path of an earlier input: with the same data; judged together, as this trial began there.
    ledger_problems : tuple of str, or None
        Why its readings are not all accounted for.
    not_taken : mapping, or None
        Lines of a log that gave no heading, by reason; None if it is no log.
    made_from : mapping, or None
        Path and hash of each recording whose readings a csv of pairs has.

    """

    path: str
    sha256: str | None = None
    ts_topic: str | None = None
    rs_topic: str | None = None
    notes: tuple[OperatorNote, ...] | None = leave_out_none()
    error: str | None = leave_out_none()
    no_run: str | None = leave_out_none()
    same_as: str | None = leave_out_none()
    continues: str | None = leave_out_none()
    ledger_problems: tuple[str, ...] | None = leave_out_none()
    not_taken: Mapping[str, int] | None = leave_out_none()
    made_from: Mapping[str, str | None] | None = leave_out_none()

    @property
    def why_no_run(self) -> str | None:
        """Why this input has no run; None if it has one."""
        if self.same_as is not None:
            return f'it has the data of {self.same_as}'
        if self.continues is not None:
            return f'it was judged together with {self.continues}'
        return self.error or self.no_run


@dataclass(frozen=True, slots=True)
class Software:
    """The software that judged."""

    name: str = 'heading_intercompare'
    version: str = VERSION


@dataclass(frozen=True, slots=True)
class Verdict:
    """
    The verdict of all runs on the TS.

    Attributes
    ----------
    outcome : Outcome
        The guarded decision by `campaign.rule`.
    headline : str
        The outcome in one line, with the findings that affect it and its coverage.
    validity_effect : {'holds', 'doubtful', 'void'}
        The most serious effect of a finding in any run.
    paper_outcome : Outcome
        GK as printed, worst of runs.
    settings : Settings
    inputs : sequence of Input
        Empty for readings given live or by a program.
    campaign : Campaign
    runs : sequence of RunVerdict
    software : Software
        The software that judged.
    rule_version : int or None
        Version of the decision rule, see `RULE_VERSION`; None in verdicts older than that.
    ledger_problems : sequence of str or None
        Sentences that say why the ledger is not complete; None if unknown, before 2.2.
    intermediate : bool or None
        True if the last run was still in progress: what a stop would have given; otherwise None.
    taken_out : TakenOut or None
        What a person took out, and the verdict with nothing taken out; None without exclusions.
    plotter : callable or None
        ``plotter(verdict, name)`` draws the figures, from a sketch of the pairs; no key.
    settings_sha256 : str
        Hash of the settings, see the function `settings_sha256`.

    """

    outcome: Outcome
    headline: str
    validity_effect: str
    paper_outcome: Outcome
    settings: Settings
    inputs: Sequence[Input]
    campaign: Campaign
    runs: Sequence[RunVerdict]
    software: Software = field(default_factory=Software)
    rule_version: int | None = RULE_VERSION
    ledger_problems: Sequence[str] | None = leave_out_none()
    intermediate: bool | None = leave_out_none()
    taken_out: TakenOut | None = leave_out_none()
    plotter: Any = no_key()

    @property
    def ledger_complete(self) -> bool | None:
        """Whether the ledger accounts for every reading; None if unknown."""
        return None if self.ledger_problems is None else not self.ledger_problems

    @property
    def settings_sha256(self) -> str:
        """Hash of the settings."""
        return settings_sha256(leave_out_added(self.settings.to_mapping()))

    @classmethod
    def of(cls, runs: Sequence[RunVerdict], outcome: Outcome, campaign: Campaign,
           coverage: Coverage | None, settings: Settings, inputs: Sequence[Input]) -> 'Verdict':
        """Build the verdict from runs and from their result together."""
        together = campaign.validity or ()
        is_alone = len(runs) == 1 and campaign.rule == 'every_run'
        if is_alone and runs[0].outcome is outcome and not any(f.words for f in together):
            line = runs[0].headline
        else:
            findings = [*together, *(
                replace(f, words=f'run {r.run}: {f.words}') if f.words and len(runs) > 1 else f
                for r in runs for f in r.validity)]
            why = campaign_words(campaign, runs, coverage)
            line = compose_headline(outcome, findings, coverage, why)
        problems = tuple(f'{recording.path}: {problem}' for recording in inputs
                         for problem in recording.ledger_problems or ())
        return cls(outcome, line, gravest(
            [worst_effect(together), *(r.validity_effect for r in runs)]),
                   worst(r.paper_outcome for r in runs), settings, tuple(inputs), campaign,
                   tuple(runs), ledger_problems=problems)

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
        more: dict[str, Any] = {} if self.ledger_problems is None else {
            'ledger_complete': self.ledger_complete,
            'ledger_problems': make_plain(self.ledger_problems)}
        more |= {name: make_plain(value) for name in ('intermediate', 'taken_out')
                 if (value := getattr(self, name)) is not None}
        return {
            'schema': SCHEMA,
            'schema_version': SCHEMA_VERSION,
            'outcome': self.outcome.value,
            'headline': self.headline,
            'validity_effect': self.validity_effect,
            'paper_outcome': self.paper_outcome.value,
            'software': make_plain(self.software),
            'rule_version': self.rule_version,
            'settings_sha256': self.settings_sha256,
            'settings': make_plain(leave_out_added(self.settings.to_mapping())),
            'inputs': make_plain(self.inputs),
            **more,
            'campaign': make_plain(self.campaign),
            'runs': make_plain(self.runs),
        }

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
        `to_dict` of the result is the mapping again. A number that was not finite is nan. Version
        2.0 had neither `schema_version` nor `rule_version` nor `settings_sha256`: its rule version
        is None, which means unknown, and the hash follows from the settings.

        """
        if not isinstance(mapping, Mapping):
            raise VerdictError(f'a verdict must be an object, not {type(mapping).__name__}')
        check_schema(mapping, _SCHEMA, _MAJOR, _AGAIN)
        of_2_0 = 'schema_version' not in mapping
        try:
            # All settings must be present: a default could differ from the value that was used.
            if isinstance(settings := mapping.get('settings'), Mapping):
                mapping = {**mapping, 'settings': _read_settings(settings)}
            verdict: Verdict = read_plain(
                cls, {'rule_version': None, **mapping} if of_2_0 else mapping)
        except VerdictError as error:
            if of_2_0:
                raise VerdictError(f'{error}; if an earlier version wrote it, {_AGAIN}') from error
            raise
        complete = verdict.ledger_complete
        if (stated := mapping.get('ledger_complete', complete)) is not complete:
            raise VerdictError(f'ledger_complete = {stated!r:.70}: must be '
                               f'{make_plain(complete)!r} by ledger_problems')
        if 'settings_sha256' not in mapping and not of_2_0:
            raise VerdictError('settings_sha256 is missing')
        if (digest := mapping.get('settings_sha256', verdict.settings_sha256)
                ) != verdict.settings_sha256:
            raise VerdictError(f'settings_sha256 = {digest!r:.70}: the settings have '
                               f'{verdict.settings_sha256!r}, so they were changed afterwards')
        return verdict


def _read_settings(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return all settings as plain values, nested like the classes."""
    for name in Settings().to_mapping():
        if name not in mapping and not is_added(name):
            raise VerdictError(f'settings.{name} is missing')
    try:
        settings = Settings.from_mapping(fill_in_added(mapping))
        Limits.of(settings.norms, settings.model)
    except SettingsError as error:
        raise VerdictError(f'settings: {error}') from error
    plain: dict[str, Any] = make_plain(settings)
    return plain
