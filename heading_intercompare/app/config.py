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

"""Settings from a ROS parameter file and from ``--set name=value``."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
import re
from types import MappingProxyType, NoneType
from typing import Any, Mapping, Sequence

from heading_intercompare.core.declared_settings import (
    drop_removed,
    flatten,
    list_settings,
    Setting,
    SettingsError,
)
from heading_intercompare.core.sensor_table import read_sensors
from heading_intercompare.core.sensors.pair_settings import settings_of_pair
from heading_intercompare.core.settings import Secrets, Settings
from heading_intercompare.special_files import read_once
from heading_intercompare.yaml_file import load_settings, parse_yaml, YamlError

SHARED = '/**'
"""The section whose settings apply to every node and every command."""

# The replayer neither pairs nor judges: what it calls the TS may be another topic of the bag.
_NODES = re.compile(r'synchronizer|compliance|recorder|dashboard|.*_driver|\*+')
_NOWHERE = object()
_FIGURE = re.compile(r'\s*[-+]?[0-9.]+([eE][-+]?[0-9]+)?\s*')

LIVE: Mapping[str, Any] = {'sequential.plan_s': 'open'}
"""What a graph takes that judges live, by setting, where the user states nothing."""

_ANALYSIS = frozenset(rule.name for rule in list_settings(Settings))
_GROUPS = frozenset(name.partition('.')[0] for name in _ANALYSIS)


@dataclass(frozen=True, slots=True)
class Config:
    """
    The contents of a ROS parameter file.

    Attributes
    ----------
    path
        Path of the file; empty without one.
    shared
        The section ``/**``: `Settings` by dotted name.
    sections
        The parameters of single nodes, by dotted name.
    bare
        The settings that stand without a section, such as ``trial``; nodes of `ros2` reject them.

    """

    path: str = ''
    shared: Mapping[str, Any] = field(default_factory=dict)
    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    bare: Sequence[str] = ()


def load_config(path: str | None) -> Config:
    """
    Read a ROS parameter file; settings without a section are those of ``/**``.

    Raises
    ------
    OSError
        If the file cannot be read.
    SettingsError
        If it is not a ROS parameter file; the message says what is wrong and where.

    """
    if path is None:
        return Config()
    document = parse_yaml(read_once(path), path)
    if document is None:
        return Config(path)
    if not isinstance(document, dict):
        raise SettingsError(f'{path}: is not a ROS parameter file: must hold sections such as '
                            f"'{SHARED}: ros__parameters: ...'")
    bare = {name: value for name, value in document.items()
            if str(name).partition('.')[0] in _GROUPS and not _is_section(value)}
    sections = {}
    for name, section in document.items():
        if name in bare:
            continue
        if not _is_section(section):
            raise SettingsError(f'{path}: section {name!r}: must hold ros__parameters and '
                                'nothing else, or be a group of settings such as norms or trial')
        short = str(name).lstrip('/') if name != SHARED else SHARED
        if short in sections:
            raise SettingsError(f'{path}: section {short!r} is given twice, with and without a '
                                'slash')
        sections[short] = _flatten_section(path, name, section['ros__parameters'] or {})
    shared = _join_bare(path, _flatten_section(path, SHARED, bare), sections.pop(SHARED, {}))
    for name, values in sections.items():
        _refuse_own_analysis(path, name, values, shared)
        _refuse_secrets(path, name, values)
    return Config(path, shared, sections, tuple(bare))


def _is_section(value: object) -> bool:
    return isinstance(value, dict) and set(value) == {'ros__parameters'}


def _flatten_section(path: str, name: str, parameters: object) -> dict[str, Any]:
    if not isinstance(parameters, dict):
        raise SettingsError(f'{path}: section {name!r}: ros__parameters must be a mapping')
    try:
        return flatten(parameters)
    except SettingsError as error:
        raise SettingsError(f'{path}: section {name!r}: {error}') from error


def _join_bare(path: str, bare: Mapping[str, Any], shared: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings without a section and those of ``/**``; a name in both is an error."""
    if twice := sorted(bare.keys() & shared.keys()):
        raise SettingsError(f"{path}: {twice[0]} is given twice, in section '{SHARED}' and "
                            'without a section')
    return {**shared, **bare}


def _refuse_own_analysis(path: str, name: str, values: Mapping[str, Any],
                         shared: Mapping[str, Any]) -> None:
    """Raise SettingsError if one node is to judge, pair or record by settings of its own."""
    # Nodes of other packages have parameters of the same names, such as `model`.
    if not _NODES.fullmatch(name.rpartition('/')[2]):
        return
    for key in values:
        if key in _ANALYSIS and repr(values[key]) != repr(shared.get(key, _NOWHERE)):
            raise SettingsError(
                f'{path}: section {name!r}: {key} holds for every node and every command, which '
                f"would disagree otherwise: put it into section '{SHARED}'")


def _refuse_secrets(path: str, name: str, values: Mapping[str, Any]) -> None:
    """Raise SettingsError if the section of a live page holds a token: bags copy the file."""
    if name.rpartition('/')[2] != 'dashboard':
        return
    try:
        drop_removed(Secrets, values)
    except SettingsError as error:
        raise SettingsError(f'{path}: section {name!r}: {error}') from error


def _parse_assignments(assignments: Sequence[str]) -> dict[str, Any]:
    """
    Return the names and values of ``--set name=value`` options.

    Raises
    ------
    SettingsError
        If one is not of this form, or if two give different values to a name.

    """
    rules = {rule.name: rule for rule in list_settings(Settings)}
    values: dict[str, Any] = {}
    for assignment in assignments:
        name, equals, text = assignment.partition('=')
        name = name.strip()
        if not equals or not name:
            raise SettingsError(f'--set {assignment}: must be name=value, '
                                'e.g. --set norms.sigma_max_deg=0.2; most trials need no other '
                                f'settings than {", ".join(Settings.NEEDED)}')
        try:
            value = text if name in rules and _is_text(rules[name], text) else (
                load_settings(text))
        except YamlError as error:
            raise SettingsError(
                f'--set {assignment}: the value cannot be read: {error}') from error
        if repr(values.setdefault(name, value)) != repr(value):
            raise SettingsError(f'--set {assignment}: {name} is given twice, first as '
                                f'{values[name]!r}')
    return values


def _is_text(rule: Setting, text: str) -> bool:
    """Tell whether the value of an assignment is its text as it stands, and no YAML."""
    # The time 12:00 would be a number in YAML, and a reason may hold any sign.
    if rule.kinds == (str,) or rule.name in ('runs.cut_at_utc', 'exclusions', 'sensors'):
        return True
    is_figure_or_words = str in rule.kinds and not rule.choices and NoneType not in rule.kinds
    return is_figure_or_words and not _FIGURE.fullmatch(text)


def unstated(defaults: Mapping[str, Any], config: Config,
             assignments: Sequence[str] = ()) -> dict[str, Any]:
    """Return those of some defaults that neither the file nor ``--set`` states."""
    stated = {*flatten(config.shared), *_parse_assignments(assignments)}
    return {name: value for name, value in defaults.items() if name not in stated}


def settings_for(config: Config, assignments: Sequence[str] = (),
                 defaults: Mapping[str, Any] = MappingProxyType({}),
                 **overrides: Any) -> Settings:
    """
    Return the settings of a command: defaults, then the file, then ``--set``, then options.

    Parameters
    ----------
    config
        The parameter file, as read.
    assignments
        The ``name=value`` of ``--set``.
    defaults
        Settings that differ from their declared defaults where nothing is stated.
    overrides
        Settings that have an option of their own (``ts_topic``), by name; None is skipped.

    Raises
    ------
    SettingsError
        If a setting is wrong; one line with its name, and with the file if it came from there.

    """
    try:
        from_file = Settings.from_mapping(config.shared).to_mapping() if config.shared else {}
    except SettingsError as error:
        raise SettingsError(f'{config.path}: {error}') from error
    merged = {**from_file, **unstated(defaults, config, assignments),
              **_parse_assignments(assignments),
              **{k: v for k, v in overrides.items() if v is not None}}
    return Settings.from_mapping(merged)


def choose_pair(settings: Settings, ts: str | None, rs: str | None) -> Settings:
    """
    Return the settings of two of several sensors that ``--ts`` and ``--rs`` name.

    Parameters
    ----------
    settings
        With `ts` and `rs` as topics.
    ts, rs
        As given: names of sensors, or topics.

    Returns
    -------
    Settings
        Without sensors if both options are given; otherwise the settings as they are.

    Raises
    ------
    ValueError
        If one of the options is given without the other.

    """
    if settings.sensors is None or ts is None and rs is None:
        return settings
    if ts is None or rs is None:
        option = f'--ts {ts}' if rs is None else f'--rs {rs}'
        raise ValueError(f'{option}: with the setting sensors give --ts and --rs, to compare '
                         'these two alone, or neither')
    by_name = {sensor.name: sensor for sensor in read_sensors(settings.sensors)}
    if ts in by_name and rs in by_name:
        return settings_of_pair(settings, by_name[ts], by_name[rs])
    return replace(settings, sensors=None)
