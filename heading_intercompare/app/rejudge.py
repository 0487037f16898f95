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
Judging recordings again, and comparing the result with the verdicts that they hold.

A verdict that is compared with a new one is read unchecked: it may be that of an older rule.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import find_report, read_settings
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensors.pair_settings import check_sensors
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import VerdictError
from heading_intercompare.core.validity.condition import is_doubtful
from heading_intercompare.core.verdict.compare_verdicts import drop_sources
from heading_intercompare.core.verdict.consistency import compare_with, ContradictionError
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.verdict_document import Input, Software, Verdict
from heading_intercompare.core.version import RULE_VERSION
from heading_intercompare.readers.registry import has_streams, is_verdict
from heading_intercompare.report.json import CONFIRMED, label, parse_unchecked, read_unchecked

from .analysis import judge_bags, Judgement
from .config import Config, settings_for
from .inputs import find_input
from .job import explain_unreadable, UNREADABLE

CHANGED, UNJUDGED, WITHOUT_REPORT, SAME = 'changed', 'not_judged', 'no_report', 'same'
_ORDER = (CHANGED, UNJUDGED, WITHOUT_REPORT, SAME)
_REPORT = 'report.json'
_WORSE = {outcome: rank for rank, outcome in enumerate(Outcome)}


@dataclass(frozen=True, slots=True)
class FormerVerdict:
    """
    What is compared of the verdict that a recording holds.

    Attributes
    ----------
    software_version, rule_version, settings_sha256
        The software, rule and settings of the verdict.

    """

    outcome: Outcome
    headline: str
    validity_effect: str
    software_version: str
    rule_version: int
    settings_sha256: str

    @classmethod
    def of(cls, verdict: Verdict | SensorsVerdict) -> 'FormerVerdict':
        """Return what is compared of a verdict."""
        return cls(verdict.outcome, verdict.headline, verdict.validity_effect,
                   verdict.software.version, verdict.rule_version, verdict.settings_sha256)

    @property
    def words(self) -> str:
        """Return the outcome, whether it is doubtful, and its rule, in words."""
        doubt = ', DOUBTFUL' if is_doubtful(self.outcome, self.validity_effect) else ''
        return f'{OUTCOME_WORDS[self.outcome.value]}{doubt} by rule {self.rule_version}'


@dataclass(frozen=True, slots=True)
class Rejudged:
    """
    The result of judging one recording again.

    Attributes
    ----------
    status : {'changed', 'not_judged', 'no_report', 'same'}
        'changed' if the outcome differs, or has become doubtful or is no longer doubtful.
    former
        The verdict in the recording's report; None without a report.
    outcome, headline, validity_effect, rule_version, settings_sha256
        Of the new verdict; None if the recording could not be judged.
    settings_changed
        Settings of both verdicts whose values differ.
    error
        Why the recording could not be judged.
    notes : tuple of str
        What else the user should know about it.

    """

    path: str
    status: str
    former: FormerVerdict | None = None
    outcome: Outcome | None = None
    headline: str | None = None
    validity_effect: str | None = None
    rule_version: int | None = None
    settings_sha256: str | None = None
    settings_changed: tuple[str, ...] = ()
    error: str | None = None
    notes: tuple[str, ...] = ()

    @property
    def line(self) -> str:
        """Return the result in one line."""
        if self.status == UNJUDGED:
            return f'{self.path}: not judged: {self.error}'
        if self.former is None:
            return f'{self.path}: no report in it to compare with: {self.headline}'
        if self.status == SAME:
            return f'{self.path}: same: {self.headline}'
        why = f' (other settings: {", ".join(self.settings_changed)})'
        return (f'{self.path}: {self.former.words} -> {self.headline}'
                f'{why if self.settings_changed else ""}')

    @property
    def rank(self) -> tuple[int, int, int]:
        """Return the sort key: changed recordings first, by how severe the change is."""
        now = 0 if self.outcome is None else _WORSE[self.outcome]
        then = now if self.former is None else _WORSE[self.former.outcome]
        return _ORDER.index(self.status), then - now, -now


def rejudge(paths: Sequence[str], config: Config | None = None, assignments: Sequence[str] = (), *,
            jobs: int | None = None,
            progress: Callable[[str], None] = lambda text: None) -> list[Rejudged]:
    """
    Judge recordings again, each with its own settings; a bad one does not stop the others.

    Parameters
    ----------
    paths
        ``.mcap`` files and rosbag2 directories; or verdicts in JSON, whose inputs are judged.
    config
        Settings for all recordings, instead of those that they store.
    assignments
        ``name=value``; they override the settings of the file or the recording.
    jobs
        Processes that read a recording.
    progress
        Called with the progress in words.

    Returns
    -------
    list of Rejudged
        Changed recordings first, the most severe change before the rest.

    Raises
    ------
    SettingsError
        If the given settings are wrong.

    """
    settings_for(config or Config(), assignments)
    rejudged = []
    for done, path in enumerate(paths):
        progress(f'{done} of {len(paths)} done, {path}')
        try:
            judge = rejudge_verdict if is_verdict(path) else rejudge_bag
            rejudged.append(judge(path, config, assignments, jobs=jobs))
        except UNREADABLE as error:
            rejudged.append(Rejudged(path, UNJUDGED, error=explain_unreadable(error, path)))
    return sorted(rejudged, key=lambda bag: bag.rank)


def rejudge_bag(path: str, config: Config | None = None, assignments: Sequence[str] = (), *,
                jobs: int | None = None) -> Rejudged:
    """
    Judge one recording again; see `rejudge`.

    Raises
    ------
    OSError, ValueError
        If the recording cannot be judged.

    """
    reader = BagReader(path)
    report, notes = _read_report(reader)
    stored = {} if config else _stored_settings(reader, report)
    settings = _settings(config or Config(), stored, assignments)
    judged = judge_bags([path], settings, jobs=jobs)
    notes += [note.removeprefix(f'{path}: ') for note in judged.notes]
    return _compare(path, report, judged.verdict, tuple(notes))


def rejudge_verdict(path: str, config: Config | None = None, assignments: Sequence[str] = (), *,
                    jobs: int | None = None) -> Rejudged:
    """
    Judge the inputs of a verdict in JSON again, with its settings; see `rejudge`.

    Raises
    ------
    OSError, ValueError
        If its inputs are not at hand, hold other data, or cannot be judged from it alone.

    """
    former = read_unchecked(path)
    judged = _judge_inputs(path, former, config, assignments, jobs)
    return _compare(path, former, judged.verdict, judged.notes)


def confirm_verdict(path: str, verdict: Verdict | SensorsVerdict, *, jobs: int | None = None,
                    ) -> tuple[Verdict | SensorsVerdict, str]:
    """
    Judge the inputs of a verdict that was read, where they are at hand, and compare the results.

    Parameters
    ----------
    path
        The file of the verdict.
    verdict
        As read from there.
    jobs
        Processes that read a recording.

    Returns
    -------
    verdict : Verdict or SensorsVerdict
        The same verdict, with another label if its inputs confirm it.
    why : str
        Why the inputs that it names do not confirm it; empty if they do, or if it names none.

    Raises
    ------
    ContradictionError
        If its inputs give another verdict.

    """
    if not verdict.inputs:
        return verdict, ''
    try:
        judged = _judge_inputs(path, verdict, None, (), jobs).verdict
    except UNREADABLE as error:
        return verdict, explain_unreadable(error, path)
    if _list_frames(judged) != _list_frames(verdict):
        return verdict, ('its inputs alone give other runs, as without a table of runs or a log '
                         'of motion')
    try:
        compare_with(_without_places(verdict), _without_places(judged), 'inputs')
    except ContradictionError as error:
        if any(has_streams(_find_recording(recording, path)) for recording in verdict.inputs):
            # The options that chose its columns or streams are in no setting.
            return verdict, 'its inputs give another verdict if they are read without options'
        raise ContradictionError(f'{path}: {error}') from error
    return label(verdict, CONFIRMED), ''


def _list_frames(verdict: Verdict | SensorsVerdict) -> list[tuple[int, int, bool]]:
    """Return what the inputs alone do not decide: start and end of the runs, and the motion."""
    if isinstance(verdict, Verdict):
        return [(run.start_ns, run.end_ns, run.motion is None) for run in verdict.runs]
    return [frame for of_sensor in verdict.verdicts.values() for frame in _list_frames(of_sensor)]


def _without_places(verdict: Verdict | SensorsVerdict) -> Verdict | SensorsVerdict:
    """Return a verdict without the version that made it, and without paths."""
    if isinstance(verdict, Verdict):
        return _without_paths(verdict)
    return replace(verdict, software=Software(), rule_version=RULE_VERSION,
                   inputs=_drop_paths(verdict.inputs), verdicts={
                       name: _without_paths(of_sensor)
                       for name, of_sensor in verdict.verdicts.items()})


def _without_paths(verdict: Verdict) -> Verdict:
    return replace(drop_sources(verdict), software=Software(), rule_version=RULE_VERSION,
                   inputs=_drop_paths(verdict.inputs), ledger_problems=())


def _drop_paths(inputs: Sequence[Input]) -> tuple[Input, ...]:
    return tuple(replace(recording, path='', same_as=None, continues=None, made_from=None)
                 for recording in inputs)


def _judge_inputs(path: str, former: Verdict | SensorsVerdict, config: Config | None,
                  assignments: Sequence[str], jobs: int | None) -> Judgement:
    """Return the judgement of the inputs of a verdict; ValueError if they hold other data."""
    recordings = [_find_recording(recording, path) for recording in former.inputs]
    if not recordings:
        raise ValueError('it names no input: it was given live or from Python')
    settings = _settings(config or Config(), {} if config else _to_assignments(former.settings),
                         assignments)
    judged = judge_bags(recordings, settings, jobs=jobs)
    for recording, before, now in zip(recordings, former.inputs, judged.verdict.inputs):
        if now.error is not None:
            raise ValueError(f'{recording}: {now.error}')
        if now.sha256 != before.sha256:
            raise ValueError(f'{recording}: holds other data than those that were judged '
                             f'(SHA-256 {now.sha256}, not {before.sha256})')
    return judged


def _find_recording(recording: Input, verdict: str) -> str:
    """Return where an input of a verdict lies that can be judged from the verdict alone."""
    if recording.not_taken is not None:
        raise ValueError(f'its input {recording.path} is a log, and the verdict does not say how '
                         'its stamps were read: use analyze, or import it and analyze the bag')
    place = find_input(recording.path, verdict)
    if place is None:
        raise ValueError(f'its input {recording.path} is neither there nor beside the verdict')
    return place


def _compare(path: str, report: Verdict | SensorsVerdict | None, verdict: Verdict | SensorsVerdict,
             notes: tuple[str, ...]) -> Rejudged:
    status, former, changed = WITHOUT_REPORT, None, []
    if report is not None:
        same = (report.outcome is verdict.outcome
                and is_doubtful(report.outcome, report.validity_effect)
                == is_doubtful(verdict.outcome, verdict.validity_effect))
        status, former = SAME if same else CHANGED, FormerVerdict.of(report)
        before = report.settings.to_mapping()
        changed = [name for name, value in verdict.settings.to_mapping().items()
                   if before[name] != value]
    return Rejudged(path=path, status=status, former=former, outcome=verdict.outcome,
                    headline=verdict.headline, validity_effect=verdict.validity_effect,
                    rule_version=verdict.rule_version, settings_sha256=verdict.settings_sha256,
                    settings_changed=tuple(changed), notes=notes)


def _read_report(reader: BagReader) -> tuple[Verdict | SensorsVerdict | None, list[str]]:
    """Return the last report in a bag, or None and what is wrong with it."""
    texts: list[str | bytes] = [attached.data for attached in reader.attachments()
                                if attached.name == _REPORT]
    if not texts and (published := find_report(reader)) is not None:
        texts = [published.text]
    if not texts:
        return None, []
    try:
        return parse_unchecked(texts[-1]), []
    except VerdictError as error:
        return None, [f'the report in it: {error}']


def _stored_settings(reader: BagReader,
                     report: Verdict | SensorsVerdict | None) -> dict[str, Any]:
    """Return the settings stored in a bag; if there are none, those of the report in it."""
    stored: dict[str, Any] = {**read_settings(reader)}
    return stored if stored or report is None else _to_assignments(report.settings)


def _to_assignments(settings: Settings) -> dict[str, Any]:
    """Return settings by name, as `settings_for` takes them."""
    return {name: 'none' if value is None else value
            for name, value in settings.to_mapping().items()}


def _settings(config: Config, stored: Mapping[str, Any], assignments: Sequence[str]) -> Settings:
    """Return the settings to judge with."""
    try:
        overridden = {assignment.partition('=')[0].strip() for assignment in assignments}
        settings = settings_for(config, [*(f'{name}={value}' for name, value in stored.items()
                                           if name not in overridden), *assignments])
    except SettingsError as error:
        raise SettingsError(f'its settings: {str(error).removeprefix("--set ")}; give them with '
                            '--config') from error
    if settings.sensors is not None:
        check_sensors(settings)
        return settings
    norms = settings.norms
    if norms.sigma_ref_max_deg is None or (norms.sigma_max_deg is None and norms.preset is None):
        raise SettingsError(
            ('its settings have no norm' if stored or config.path else 'it stores no settings')
            + ': give norms.sigma_max_deg (or norms.preset) and norms.sigma_ref_max_deg with '
            '--config or --set')
    return settings
