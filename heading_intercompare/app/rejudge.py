# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings judged anew, and what has become of the verdicts that they hold."""

from __future__ import annotations

from dataclasses import dataclass
import json
from typing import Any, Callable, Mapping, Sequence

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_texts, RECORD, REPORT_TOPIC
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.settings import leave_out_gone, Settings, SettingsError
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS
from heading_intercompare.core.verdict.validity import DOUBTFUL
from heading_intercompare.core.verdict.verdict_document import Verdict, VerdictError

from .analysis import judge_bags
from .config import Config, settings_for

__all__ = ['CHANGED', 'FormerVerdict', 'rejudge', 'rejudge_bag', 'Rejudged', 'SAME', 'UNJUDGED',
           'WITHOUT_REPORT']

CHANGED, UNJUDGED, WITHOUT_REPORT, SAME = 'changed', 'not_judged', 'no_report', 'same'
_ORDER = (CHANGED, UNJUDGED, WITHOUT_REPORT, SAME)
_REPORT = 'report.json'
_STORED = 'settings.'
_SCHEMA = 'heading_intercompare/verdict/'
#: The first build numbered neither its rule nor its schema otherwise.
_RULE_OF_SCHEMA_1 = 1
_WORSE = {Outcome.COMPLIANT: 0, Outcome.INDETERMINATE: 1, Outcome.NON_COMPLIANT: 2}


@dataclass(frozen=True, slots=True)
class FormerVerdict:
    """
    What every version of a verdict says, also one that is not read as a whole any more.

    Attributes
    ----------
    outcome : Outcome
    headline : str or None
        None by rule 1, which had none.
    validity_effect : str or None
        None by rule 1.
    software_version, rule_version, settings_sha256
        What judged, by which rule and with which settings; None if it does not say so.

    """

    outcome: Outcome
    headline: str | None
    validity_effect: str | None
    software_version: str | None
    rule_version: int | None
    settings_sha256: str | None

    @property
    def words(self) -> str:
        """The outcome, its doubt and what judged, in words."""
        doubt = ', DOUBTFUL' if _is_doubtful(self.outcome, self.validity_effect) else ''
        rule = 'an unnumbered rule' if self.rule_version is None else f'rule {self.rule_version}'
        return f'{OUTCOME_WORDS[self.outcome.value]}{doubt} by {rule}'


@dataclass(frozen=True, slots=True)
class Rejudged:
    """
    What became of one recording.

    Attributes
    ----------
    path : str
    status : {'changed', 'not_judged', 'no_report', 'same'}
        Changed is another outcome, or the same one that is doubtful now or no longer.
    former : FormerVerdict or None
        Of the report in it; None without one.
    outcome, headline, validity_effect, rule_version, settings_sha256
        Of the verdict anew; None if it could not be judged.
    settings_changed : tuple of str
        Settings that both verdicts have, with other values.
    settings_gone : tuple of str
        Stored settings that are gone, each with what to do instead.
    error : str or None
        Why it could not be judged.
    notes : tuple of str
        What else the user should know of it.

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
        """What became of it, in one line."""
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
        """Its place among others: what changed comes first, the most severe before the rest."""
        now = 0 if self.outcome is None else _WORSE[self.outcome]
        then = now if self.former is None else _WORSE[self.former.outcome]
        return _ORDER.index(self.status), then - now, -now


def rejudge(paths: Sequence[str], config: Config | None = None, assignments: Sequence[str] = (), *,
            jobs: int | None = None,
            progress: Callable[[str], None] = lambda text: None) -> list[Rejudged]:
    """
    Judge recordings anew, each with its own settings; one that is bad does not stop the others.

    Parameters
    ----------
    paths : sequence of str
        ``.mcap`` files and rosbag2 directories.
    config : Config, optional
        Settings for all of them, instead of those that they store.
    assignments : sequence of str
        ``name=value``, before those of the file or of the recording.
    jobs : int, optional
        Processes that read a recording.
    progress : callable
        Told what has been done.

    Returns
    -------
    list of Rejudged
        The changed ones first, the most severe before the rest.

    Raises
    ------
    SettingsError
        If the given settings are wrong.

    """
    settings_for(config or Config(), assignments)
    found = []
    for done, path in enumerate(paths):
        progress(f'{done} of {len(paths)} done, {path}')
        try:
            found.append(rejudge_bag(path, config, assignments, jobs=jobs))
        except OSError as error:
            found.append(_unjudged(path, error.strerror or str(error)))
        except ValueError as error:
            found.append(_unjudged(path, str(error).removeprefix(f'{path}: ')))
        except MemoryError:
            found.append(_unjudged(path, 'there is not enough memory for it'))
    return sorted(found, key=lambda each: each.rank)


def rejudge_bag(path: str, config: Config | None = None, assignments: Sequence[str] = (), *,
                jobs: int | None = None) -> Rejudged:
    """
    Judge one recording anew; as `rejudge`.

    Raises
    ------
    OSError, ValueError
        If it cannot be judged.

    """
    reader = BagReader(path)
    report, notes = _read_report(reader)
    stored = {} if config else _stored_settings(reader, report)
    kept, gone = leave_out_gone(stored)
    settings = _settings(config or Config(), kept, assignments)
    judged = judge_bags([path], settings, jobs=jobs)
    notes += [note.removeprefix(f'{path}: ') for note in judged.notes]
    return _compare(path, None if report is None else _read_former(report), judged.verdict,
                    tuple(_find_changed(report, settings)), tuple(gone), tuple(notes))


def _compare(path: str, former: FormerVerdict | None, verdict: Verdict,
             changed: tuple[str, ...], gone: tuple[str, ...], notes: tuple[str, ...]) -> Rejudged:
    if former is None:
        status = WITHOUT_REPORT
    else:
        doubtful = _is_doubtful(verdict.outcome, verdict.validity_effect)
        # Rule 1 doubted nothing: what it certified and is doubtful now has changed.
        same = (former.outcome is verdict.outcome
                and _is_doubtful(former.outcome, former.validity_effect) == doubtful)
        status = SAME if same else CHANGED
    return Rejudged(path, status, former, verdict.outcome, verdict.headline,
                    verdict.validity_effect, verdict.rule_version, verdict.settings_sha256,
                    changed, gone, None, notes)


def _unjudged(path: str, why: str) -> Rejudged:
    return Rejudged(path, UNJUDGED, error=' '.join(why.split()))


def _is_doubtful(outcome: Outcome, effect: str | None) -> bool:
    """Tell whether a decision is doubtful; what is not decided need not be doubted."""
    return outcome is not Outcome.INDETERMINATE and effect == DOUBTFUL


def _read_report(reader: BagReader) -> tuple[Mapping[str, Any] | None, list[str]]:
    """Return the last report in a bag, and what is wrong with it."""
    texts: list[str | bytes] = [attached.data for attached in reader.attachments()
                                if attached.name == _REPORT]
    texts = texts or [text for _, text in read_texts(reader, REPORT_TOPIC)]
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
    if not isinstance(schema, str) or not schema.startswith(_SCHEMA):
        raise VerdictError('is not a verdict of heading_intercompare')
    try:
        outcome = Outcome(report.get('outcome'))
    except ValueError:
        raise VerdictError(f'outcome = {report.get("outcome")!r}: must be one of '
                           f'{", ".join(repr(each.value) for each in Outcome)}') from None
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
    """Return the settings that a bag stores, else those of the report in it."""
    record = reader.metadata().get(RECORD, {})
    stored = {name.removeprefix(_STORED): value for name, value in record.items()
              if name.startswith(_STORED)}
    given = (report or {}).get('settings')
    if not stored and isinstance(given, Mapping):
        stored = {str(name): 'none' if value is None else value for name, value in given.items()}
    return stored


def _settings(config: Config, stored: Mapping[str, Any], assignments: Sequence[str]) -> Settings:
    """Return the settings to judge with."""
    try:
        settings = settings_for(config, [*(f'{name}={value}' for name, value in stored.items()),
                                         *assignments])
    except SettingsError as error:
        raise SettingsError(f'its settings: {str(error).removeprefix("--set ")}; give them with '
                            '--config') from error
    norms = settings.norms
    if norms.sigma_ref_max_deg is None or (norms.sigma_max_deg is None and norms.preset is None):
        raise SettingsError(
            ('its settings have no norm' if stored or config.path else 'it stores no settings')
            + ': give norms.sigma_max_deg (or norms.preset) and norms.sigma_ref_max_deg with '
            '--config or --set')
    return settings


def _find_changed(report: Mapping[str, Any] | None, settings: Settings) -> list[str]:
    """Return the settings that both verdicts have, with other values."""
    given = (report or {}).get('settings')
    if not isinstance(given, Mapping):
        return []
    return [name for name, value in settings.to_mapping().items()
            if name in given and given[name] != value]
