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

"""Judging recordings again, and comparing the result with the verdicts that they hold."""

from __future__ import annotations

from dataclasses import dataclass
import json
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import find_report, RECORD
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.sensors.pair_settings import check_sensors
from heading_intercompare.core.sensors.sensors_verdict import is_of_sensors, SensorsVerdict
from heading_intercompare.core.settings import (
    fill_in_added,
    leave_out_gone,
    Settings,
    SettingsError,
)
from heading_intercompare.core.validity.condition import is_doubtful
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.verdict_document import Verdict, VerdictError

from .analysis import judge_bags
from .config import Config, settings_for
from .job import explain_unreadable, UNREADABLE

__all__ = ['CHANGED', 'FormerVerdict', 'rejudge', 'rejudge_bag', 'Rejudged', 'SAME', 'UNJUDGED',
           'WITHOUT_REPORT']

CHANGED, UNJUDGED, WITHOUT_REPORT, SAME = 'changed', 'not_judged', 'no_report', 'same'
_ORDER = (CHANGED, UNJUDGED, WITHOUT_REPORT, SAME)
_REPORT = 'report.json'
_STORED = 'settings.'
_SCHEMA = 'heading_intercompare/verdict/'
#: Verdicts of schema 1 name no rule: they are by rule 1.
_RULE_OF_SCHEMA_1 = 1
_WORSE = {outcome: rank for rank, outcome in enumerate(Outcome)}


@dataclass(frozen=True, slots=True)
class FormerVerdict:
    """
    What all versions of a verdict have in common, even versions that can no longer be read whole.

    Attributes
    ----------
    outcome : Outcome
    headline : str or None
        None under rule 1, which had no headline.
    validity_effect : str or None
        None under rule 1.
    software_version, rule_version, settings_sha256
        The software, rule and settings of the verdict; None if it does not name them.

    """

    outcome: Outcome
    headline: str | None
    validity_effect: str | None
    software_version: str | None
    rule_version: int | None
    settings_sha256: str | None

    @property
    def words(self) -> str:
        """Return the outcome, whether it is doubtful, and its rule, in words."""
        doubt = ', DOUBTFUL' if is_doubtful(self.outcome, self.validity_effect) else ''
        rule = 'an unnumbered rule' if self.rule_version is None else f'rule {self.rule_version}'
        return f'{OUTCOME_WORDS[self.outcome.value]}{doubt} by {rule}'


@dataclass(frozen=True, slots=True)
class Rejudged:
    """
    The result of judging one recording again.

    Attributes
    ----------
    path : str
    status : {'changed', 'not_judged', 'no_report', 'same'}
        'changed' if the outcome differs, or has become doubtful or is no longer doubtful.
    former : FormerVerdict or None
        The verdict in the recording's report; None without a report.
    outcome, headline, validity_effect, rule_version, settings_sha256
        Of the new verdict; None if the recording could not be judged.
    settings_changed : tuple of str
        Settings of both verdicts whose values differ.
    settings_gone : tuple of str
        Stored settings that no longer exist, each with what to do instead.
    error : str or None
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
    settings_gone: tuple[str, ...] = ()
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
    paths : sequence of str
        ``.mcap`` files and rosbag2 directories.
    config : Config, optional
        Settings for all recordings, instead of those that they store.
    assignments : sequence of str
        ``name=value``; they override the settings of the file or the recording.
    jobs : int, optional
        Processes that read a recording.
    progress : callable
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
            rejudged.append(rejudge_bag(path, config, assignments, jobs=jobs))
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
    current, gone = leave_out_gone(stored)
    settings = _settings(config or Config(), current, assignments)
    judged = judge_bags([path], settings, jobs=jobs)
    notes += [note.removeprefix(f'{path}: ') for note in judged.notes]
    return _compare(path, None if report is None else _read_former(report), judged.verdict,
                    tuple(_find_changed(report, settings)), tuple(gone), tuple(notes))


def _compare(path: str, former: FormerVerdict | None, verdict: Verdict | SensorsVerdict,
             changed: tuple[str, ...], gone: tuple[str, ...], notes: tuple[str, ...]) -> Rejudged:
    if former is None:
        status = WITHOUT_REPORT
    else:
        doubtful = is_doubtful(verdict.outcome, verdict.validity_effect)
        # Rule 1 had no doubts: a certificate of it that is doubtful now has changed.
        same = (former.outcome is verdict.outcome
                and is_doubtful(former.outcome, former.validity_effect) == doubtful)
        status = SAME if same else CHANGED
    return Rejudged(path, status, former, verdict.outcome, verdict.headline,
                    verdict.validity_effect, verdict.rule_version, verdict.settings_sha256,
                    changed, gone, None, notes)


def _read_report(reader: BagReader) -> tuple[Mapping[str, Any] | None, list[str]]:
    """Return the last report in a bag, or None and what is wrong with it."""
    texts: list[str | bytes] = [attached.data for attached in reader.attachments()
                                if attached.name == _REPORT]
    if not texts and (published := find_report(reader)) is not None:
        texts = [published.text]
    if not texts:
        return None, []
    try:
        report = json.loads(texts[-1])
        _read_former(report)
    except VerdictError as error:
        return None, [f'the report in it: {error}']
    except (ValueError, RecursionError):
        return None, ['the report in it is not JSON']
    return report, []


def _read_former(report: Any) -> FormerVerdict:
    """Return what all versions of a verdict have in common."""
    schema = report.get('schema') if isinstance(report, Mapping) else None
    if not isinstance(schema, str) or not (schema.startswith(_SCHEMA) or is_of_sensors(report)):
        raise VerdictError('is not a verdict of heading_intercompare')
    try:
        outcome = Outcome(report.get('outcome'))
    except ValueError:
        raise VerdictError(f'outcome = {report.get("outcome")!r}: must be one of '
                           f'{", ".join(repr(choice.value) for choice in Outcome)}') from None
    software, rule = report.get('software'), report.get('rule_version')
    if schema == f'{_SCHEMA}1':
        rule = _RULE_OF_SCHEMA_1
    version = software.get('version') if isinstance(software, Mapping) else None
    return FormerVerdict(
        outcome=outcome, headline=_text(report.get('headline')),
        validity_effect=_text(report.get('validity_effect')), software_version=_text(version),
        rule_version=rule if type(rule) is int else None,
        settings_sha256=_text(report.get('settings_sha256')))


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None


def _stored_settings(reader: BagReader, report: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the settings stored in a bag; if there are none, those of the report in it."""
    record = reader.metadata().get(RECORD, {})
    stored = {name.removeprefix(_STORED): value for name, value in record.items()
              if name.startswith(_STORED)}
    report_settings = (report or {}).get('settings')
    if not stored and isinstance(report_settings, Mapping):
        stored = {str(name): 'none' if value is None else value
                  for name, value in report_settings.items()}
    return stored


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


def _find_changed(report: Mapping[str, Any] | None, settings: Settings) -> list[str]:
    """Return the settings of the report whose values differ now."""
    report_settings = (report or {}).get('settings')
    if not isinstance(report_settings, Mapping):
        return []
    now = settings.to_mapping()
    # What a report leaves out of its settings has the value that changes nothing.
    then = fill_in_added(report_settings)
    return [name for name, value in now.items() if name in then and then[name] != value]
