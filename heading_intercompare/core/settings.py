# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Every setting of the analysis: name, default, unit, meaning, range. Declared here and only here.

These classes give the ROS parameters, the YAML file, `--set` and the tables of the documentation.
The outer rooms declare their own settings with the same `setting`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields, is_dataclass, MISSING
import difflib
from functools import cache
import hashlib
import json
import math
import types
from typing import (
    Any,
    cast,
    get_args,
    get_origin,
    get_type_hints,
    Iterable,
    Iterator,
    Mapping,
    Union,
)

__all__ = ['Alignment', 'CampaignRule', 'Checked', 'Detectors', 'explain_unknown', 'flatten',
           'from_mapping', 'leave_out_gone', 'list_settings', 'Norms', 'Pairing', 'Risk',
           'RunCutting', 'Sequential', 'Setting', 'setting', 'Settings', 'settings_sha256',
           'SettingsError', 'to_mapping']


_NO_GATE = ('is gone: the decision has no gate any more, its bounds widen if the record says '
            'little; leave it out (risk.min_duration_s states the least length of a run)')

_GONE = {
    'risk.method': 'is gone: there is one rule, live and at the end; leave it out',
    'detectors.same_source_ratio': 'is gone: use detectors.same_source_share instead',
    'risk.nu_min': _NO_GATE, 'risk.r1_max': _NO_GATE, 'risk.share_max': _NO_GATE,
}
"""Settings of earlier versions, and what to do instead."""


class SettingsError(ValueError):
    """A setting has an unknown name or a value that is not allowed."""


@dataclass(frozen=True, slots=True)
class Setting:
    """One declared setting, for documentation and parameter servers."""

    name: str
    default: Any
    help: str
    kinds: tuple[type, ...]
    lo: float | None
    hi: float | None
    choices: tuple[str, ...]

    @property
    def allowed(self) -> str:
        """The allowed values, in words."""
        words = []
        if bool in self.kinds:
            words.append('true or false')
        if float in self.kinds or int in self.kinds:
            kind = 'a number' if float in self.kinds else 'an integer'
            if self.lo is not None and self.hi is not None:
                kind += f' from {self.lo:g} to {self.hi:g}'
            elif self.lo is not None:
                kind += f' of at least {self.lo:g}'
            words.append(kind)
        words += [repr(c) for c in self.choices]
        if str in self.kinds and not self.choices:
            words.append('text')
        if type(None) in self.kinds:
            words.append('none')
        return ' or '.join(words)


def setting(default: Any, help: str, lo: float | None = None, hi: float | None = None, *,
            choices: tuple[str, ...] = ()) -> Any:
    """
    Declare one setting as a dataclass field.

    Parameters
    ----------
    default : object
        Value if none is given; None for an optional setting.
    help : str
        Meaning, with the unit in square brackets.
    lo, hi : float, optional
        Inclusive range of numbers.
    choices : tuple of str
        The allowed words, if the setting takes text; empty for any text.

    """
    return field(default=default,
                 metadata={'help': help, 'lo': lo, 'hi': hi, 'choices': tuple(choices)})


# Evaluating the annotations of a class takes 0.2 ms, and every settings object needs them.
_hints_of = cache(get_type_hints)


@cache
def _groups_of(settings_class: type) -> dict[str, type]:
    """Return the settings classes nested in a class, by name."""
    return {f.name: cast(type, hint) for f in fields(settings_class)
            if is_dataclass(hint := _hints_of(settings_class)[f.name])}


@cache
def list_settings(settings_class: type, prefix: str = '') -> tuple[Setting, ...]:
    """Return the settings of a class and of the classes nested in it, with dotted names."""
    found: list[Setting] = []
    for f in fields(settings_class):
        hint: type = _hints_of(settings_class)[f.name]
        if is_dataclass(hint):
            found += list_settings(hint, f'{prefix}{f.name}.')
            continue
        union = get_origin(hint) in (Union, types.UnionType)
        default = f.default if f.default is not MISSING else None
        found.append(Setting(prefix + f.name, default, f.metadata['help'],
                             get_args(hint) if union else (hint,),
                             f.metadata['lo'], f.metadata['hi'], f.metadata['choices']))
    return tuple(found)


def _check_value(rule: Setting, value: Any) -> Any:
    """Return the value as the declared type, or raise SettingsError."""
    kinds = rule.kinds
    if type(None) in kinds and (value is None or value == 'none'):
        return None
    if isinstance(value, bool):
        good = bool in kinds
    elif isinstance(value, (int, float)):
        if isinstance(value, int) and float in kinds:
            value = float(value)
        elif isinstance(value, float) and float not in kinds and value.is_integer():
            value = int(value)
        good = type(value) in kinds and math.isfinite(value)
        good = good and (rule.lo is None or value >= rule.lo)
        good = good and (rule.hi is None or value <= rule.hi)
    else:
        good = (isinstance(value, str) and str in kinds
                and (not rule.choices or value in rule.choices))
    if not good:
        raise SettingsError(f'{rule.name} = {value!r}: must be {rule.allowed}')
    return value


def flatten(mapping: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a nested mapping by dotted name; SettingsError if one comes twice."""
    values: dict[str, Any] = {}
    for name, value in _walk(mapping, ''):
        if name in values:
            raise SettingsError(f'{name} is given twice')
        values[name] = value
    return values


def _walk(mapping: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, value in mapping.items():
        if isinstance(value, Mapping):
            yield from _walk(value, f'{prefix}{name}.')
        else:
            yield f'{prefix}{name}', value


def explain_unknown(kind: str, name: str, known: Iterable[str]) -> SettingsError:
    """Return the error for an unknown name: its replacement, or the nearest known name."""
    if name in _GONE:
        return SettingsError(f'{kind} {name!r} {_GONE[name]}')
    close = difflib.get_close_matches(name, known, n=1)
    hint = f'; did you mean {close[0]!r}?' if close else ''
    return SettingsError(f'unknown {kind} {name!r}{hint}')


def leave_out_gone(given: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """
    Remove obsolete settings from those that an earlier version stored.

    Parameters
    ----------
    given : mapping
        Settings by their dotted names.

    Returns
    -------
    kept : dict
        The settings that are not obsolete. Unknown names stay.
    gone : list of str
        For each obsolete setting its name and value, and what to do instead.

    """
    return ({name: value for name, value in given.items() if name not in _GONE},
            [f'{name} = {value} {_GONE[name]}' for name, value in given.items() if name in _GONE])


def from_mapping(settings_class: type, mapping: Mapping[str, Any]) -> Any:
    """
    Return settings made from a mapping.

    Parameters
    ----------
    settings_class : type
        A dataclass whose fields are made by `setting` or are such dataclasses.
    mapping : mapping
        Nested or with dotted names, in any mixture. Names that are absent take their default.

    Raises
    ------
    SettingsError
        For an unknown name, a wrong type or a value outside its range: name, value, what is
        allowed.

    """
    rules = {rule.name: rule for rule in list_settings(settings_class)}
    given = flatten(mapping)
    if gone := [name for name in _GONE if name in given and name not in rules]:
        # All at once: an old file would be refused once for each.
        alike = {why: ', '.join(repr(name) for name in gone if _GONE[name] == why)
                 for why in dict.fromkeys(map(_GONE.__getitem__, gone))}
        raise SettingsError('; '.join(f'setting {names} {why}' for why, names in alike.items()))
    values = {}
    for name, value in given.items():
        if name not in rules:
            raise explain_unknown('setting', name, rules)
        values[name] = _check_value(rules[name], value)
    return _build(settings_class, values, '')


def _build(settings_class: type, values: Mapping[str, Any], prefix: str) -> Any:
    hints = _hints_of(settings_class)
    given = {}
    for f in fields(settings_class):
        name = prefix + f.name
        if is_dataclass(hints[f.name]):
            given[f.name] = _build(hints[f.name], values, name + '.')
        elif name in values:
            given[f.name] = values[name]
    return settings_class(**given)


def to_mapping(settings: Any) -> dict[str, Any]:
    """Return dotted names and values of all settings, in the order of their declaration."""
    result, kind = {}, cast(type, type(settings))
    for rule in list_settings(kind):
        value = settings
        for part in rule.name.split('.'):
            value = getattr(value, part)
        result[rule.name] = value
    return result


def settings_sha256(mapping: Mapping[str, Any]) -> str:
    """
    Return the hash that identifies the settings of a verdict.

    Parameters
    ----------
    mapping : mapping
        All settings by their dotted names, as in `to_mapping` and in the JSON of a verdict.

    Returns
    -------
    str
        SHA-256, in hexadecimal, of the mapping as JSON in UTF-8: names sorted, no spaces, numbers
        as Python writes them (``0.3``, ``600.0``), None as null.

    Examples
    --------
    >>> settings_sha256({'b': None, 'a': 1.0})  # of {"a":1.0,"b":null}
    'cedebbf26781a7a0d9193136bda2e8aa0b8b76bbbe975460721bf4fe673b91c7'

    """
    text = json.dumps(mapping, sort_keys=True, separators=(',', ':'), ensure_ascii=False)
    return hashlib.sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()


class Checked:
    """Checks each field of a settings class at construction."""

    __slots__ = ()

    def __post_init__(self) -> None:
        """Check every field and convert plain values to their declared type."""
        own = cast(type, type(self))
        for rule in list_settings(own):
            if '.' not in rule.name:
                object.__setattr__(self, rule.name, _check_value(rule, getattr(self, rule.name)))
        for name, group in _groups_of(own).items():
            if not isinstance(getattr(self, name), group):
                raise SettingsError(f'{name} = {getattr(self, name)!r}: must be '
                                    f'{group.__name__}(...); from_mapping takes mappings')


@dataclass(frozen=True, slots=True)
class Norms(Checked):
    """The norms of the TS, and what is known about the RS."""

    sigma_max_deg: float | None = setting(
        None, 'norm of the TS standard deviation [deg]; required, or given by a preset', 0.0)
    sigma_ref_max_deg: float | None = setting(
        None, 'norm of the RS standard deviation [deg]; required', 0.0)
    sigma_ref_deg: float | None = setting(
        None, 'actual RS standard deviation if known (service log) [deg]; sets m_low and m_up '
        'to sigma_ref_deg / sigma_ref_max_deg', 0.0)
    m_low: float = setting(0.0, 'lower bound of M = sigma_ref / sigma_ref_max', 0.0, 1.0)
    m_up: float = setting(1.0, 'upper bound of M = sigma_ref / sigma_ref_max', 0.0, 1.0)
    probability: float = setting(0.997, 'confidence probability P', 0.5, 0.999999)
    k_rule: float | str = setting(
        'exact', "coverage factor K(P) of the counts: 'exact' two-sided quantile of the model, "
        "'three' for 3 in Gaussian models, or a number", 0.1, 20.0, choices=('exact', 'three'))
    k_total_rule: str = setting(
        'ts', "K of GK (7): 'ts' distribution of the TS error alone, or 'composition'",
        choices=('ts', 'composition'))
    total_error_max_deg: float | None = setting(
        None, 'norm of the total TS error at P [deg]', 0.0)
    preset: str | None = setting(
        None, 'a named norm (see the command norms); replaces sigma_max_deg')
    latitude_deg: float | None = setting(
        None, 'latitude for the secant factor of a preset [deg]', -70.0, 70.0)

    def __post_init__(self) -> None:
        """Check ranges and the order of the bounds of M."""
        Checked.__post_init__(self)
        if self.sigma_max_deg is not None and self.sigma_max_deg <= 0.0:
            raise SettingsError(
                f'norms.sigma_max_deg = {self.sigma_max_deg!r}: must be greater than 0')
        if self.m_low > self.m_up:
            raise SettingsError(f'norms.m_low = {self.m_low!r}: must not exceed '
                                f'norms.m_up = {self.m_up!r}')
        if (self.sigma_ref_deg is not None and self.sigma_ref_max_deg is not None
                and self.sigma_ref_deg > self.sigma_ref_max_deg):
            raise SettingsError(
                f'norms.sigma_ref_deg = {self.sigma_ref_deg!r}: the RS is out of its norm '
                f'norms.sigma_ref_max_deg = {self.sigma_ref_max_deg!r}; no verdict is possible')


@dataclass(frozen=True, slots=True)
class Pairing(Checked):
    """How TS and RS readings are paired."""

    method: str = setting(
        'auto', "'interpolate': RS interpolated to the TS stamps; 'interpolate_ts': TS to the RS "
        "stamps; 'auto': 'interpolate_ts' if the RS is slow, otherwise 'interpolate'; 'nearest': "
        'mutual nearest stamps, ties to the earlier',
        choices=('auto', 'interpolate', 'interpolate_ts', 'nearest'))
    auto_s: float = setting(
        60.0, "start of a run on which 'auto' bases its choice [s]", 1.0, 600.0)
    slow_rs_s: float = setting(
        0.25, 'an RS is slow if its step is longer than this, and than 1.5 TS steps [s]', 0.0,
        3600.0)
    max_gap_s: float = setting(3.0, 'longest bracket interpolated, inclusive [s]', 0.0, 3600.0)
    tolerance_s: float = setting(0.05, "largest lag of a pair, method 'nearest' [s]", 0.0, 60.0)
    max_wait_s: float = setting(
        5.0, 'live only: how long a reading waits for its partner [s]', 0.0, 600.0)
    jump_s: float = setting(10.0, 'a longer step of the stamps is a jump [s]', 0.1, 86400.0)


@dataclass(frozen=True, slots=True)
class RunCutting(Checked):
    """Where a run starts and ends, and which part is analysed."""

    stabilization_s: float | str = setting(
        0.0, "start of a run that is not analysed [s], or 'auto'", 0.0, choices=('auto',))
    gap_s: float = setting(60.0, 'a silence of the pairs longer than this cuts a run [s]', 0.0)
    min_duration_s: float = setting(0.0, 'a piece shorter than this is not a run [s]', 0.0)


@dataclass(frozen=True, slots=True)
class Alignment(Checked):
    """Time skew between the sensors."""

    skew_s: float = setting(
        0.0, 'known TS latency, subtracted from the TS stamps before pairing [s]', -60.0, 60.0)
    skew: str = setting(
        'report', "'off'; 'report': estimate the skew and show the verdict with and without it; "
        "'apply': pair again with the skew removed", choices=('off', 'report', 'apply'))
    skew_range_s: float = setting(
        2.0, 'largest skew to search for, in either direction [s]', 0.01, 60.0)


@dataclass(frozen=True, slots=True)
class Sequential(Checked):
    """Early verdicts at doubling looks."""

    plan_s: float | None = setting(
        None, 'planned length of a run [s]; none: no early verdict', 0.0)
    looks: int = setting(7, 'number of doubling looks', 2, 20)


@dataclass(frozen=True, slots=True)
class Risk(Checked):
    """Risks of the guarded decision."""

    alpha_consumer: float = setting(0.05, 'risk of certifying a TS at its norm', 1e-9, 0.5)
    alpha_producer: float = setting(0.05, 'risk of rejecting a TS at its norm', 1e-9, 0.5)
    count_share: float = setting(
        0.1, "share of the producer's risk for the counts; the rest is for the variance", 0.001,
        0.999)
    slowest_error_s: float | None = setting(
        None, 'slowest error of the TS: the time in which its correlation falls to 1/e, never a '
        'period [s]; a run shorter than 20 times this is not certified', 0.0)
    sensor_class: str | None = setting(
        None, 'class of the TS; gives the slowest error if slowest_error_s does not (see the '
        'command norms)', choices=('gyrocompass', 'ins', 'ins_aided', 'gnss_compass'))
    min_duration_s: float | None = setting(
        None, 'shortest run that may comply, if longer than the slowest error requires [s]; '
        'none: 600 s if no slowest error is stated', 0.0)


@dataclass(frozen=True, slots=True)
class CampaignRule(Checked):
    """How several runs are judged together; to be chosen before the data are seen."""

    rule: str = setting(
        'every_run', "'every_run': each run must comply; 'sensor': the common variance of all "
        'runs must comply', choices=('every_run', 'sensor'))


@dataclass(frozen=True, slots=True)
class Detectors(Checked):
    """Thresholds of the detectors and of their findings."""

    convention_tolerance_deg: float = setting(
        10.0, 'a mean difference within this of 90, -90 or 180 means a wrong convention [deg]',
        0.0, 45.0)
    frozen_s: float = setting(
        5.0, 'a sensor is frozen if it repeats its value for at least this time [s]', 0.0)
    frozen_moved_deg: float = setting(
        0.0, 'a frozen sensor counts only if the other one meanwhile turns by more than this, and '
        'by more than the errors and steps of both explain [deg]', 0.0, 180.0)
    same_source_share: float = setting(
        0.001, 'the sensors are one if at most this share of the changing readings differs', 0.0,
        1.0)
    mean_max_deg: float = setting(
        15.0, 'a larger mean difference, after the stated installation angle is removed, makes a '
        'run void unless 3 standard uncertainties of that angle cover it [deg]', 0.0, 180.0)
    lost_doubtful: float = setting(
        0.1, 'a run with a larger share of lost readings is doubtful', 0.0, 1.0)
    lost_void: float = setting(0.5, 'a run with a larger share of lost readings is void', 0.0, 1.0)
    silence_steps: float = setting(
        10.0, 'a step of the stamps longer than this multiple of the usual one is a silence', 1.0)


@dataclass(frozen=True, slots=True)
class Settings(Checked):
    """All settings of the analysis, the same for nodes, command line and scripts."""

    norms: Norms = field(default_factory=Norms)
    model: str = setting('NN', 'TS and RS error distributions, N normal or U uniform',
                         choices=('NN', 'UN', 'NU', 'UU'))
    variant: str = setting('B', 'a priori knowledge of the TS mean: GK Table I',
                           choices=('A', 'B', 'C'))
    installation_offset_deg: float = setting(
        0.0, 'known angle TS - RS as mounted [deg]', -360.0, 360.0)
    installation_offset_u_deg: float = setting(
        0.0, 'standard uncertainty of the installation offset [deg]', 0.0, 180.0)
    wrap_center_deg: float = setting(
        0.0, 'differences are reduced to [c - 180, c + 180) [deg]', -360.0, 360.0)
    runs: RunCutting = field(default_factory=RunCutting)
    drift_order: int | str = setting(
        0, "order of the polynomial removed before GK (4), or 'auto'", 0, 3, choices=('auto',))
    pairing: Pairing = field(default_factory=Pairing)
    alignment: Alignment = field(default_factory=Alignment)
    sequential: Sequential = field(default_factory=Sequential)
    ts_topic: str = setting('ts/heading', 'topic of the TS')
    rs_topic: str = setting('rs/heading', 'topic of the RS')
    ts_convention: str = setting('enu', 'world axes of the TS orientation',
                                 choices=('enu', 'ned'))
    rs_convention: str = setting('enu', 'world axes of the RS orientation',
                                 choices=('enu', 'ned'))
    risk: Risk = field(default_factory=Risk)
    campaign: CampaignRule = field(default_factory=CampaignRule)
    window_s: float = setting(600.0, 'length of the rolling window [s]', 1.0)
    detectors: Detectors = field(default_factory=Detectors)

    def __post_init__(self) -> None:
        """Check single settings, and combinations that exclude each other."""
        Checked.__post_init__(self)
        if self.variant == 'A' and self.drift_order != 0:
            raise SettingsError(f'drift_order = {self.drift_order!r}: must be 0 in variant A, '
                                'whose TS has no systematic error that could drift')

    @classmethod
    def from_mapping(cls, mapping: Mapping[str, Any]) -> 'Settings':
        """Return settings from nested or dotted names; see `from_mapping`."""
        made: Settings = from_mapping(cls, mapping)
        return made

    def to_mapping(self) -> dict[str, Any]:
        """Return dotted names and values, in the order of their declaration."""
        return to_mapping(self)
