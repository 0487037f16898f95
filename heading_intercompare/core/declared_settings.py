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

"""How a setting is declared, read from a mapping, checked, listed and hashed."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, is_dataclass, MISSING
import difflib
from functools import cache
import hashlib
import json
import math
import re
import shlex
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
    NamedTuple,
    Union,
)

from .text_rows import split_rows

_DATE = re.compile('[0-9]{4}-[0-9]{2}-[0-9]{2}')


class SettingsError(ValueError):
    """A setting has an unknown name or a value that is not allowed."""


class Moved(NamedTuple):
    """Stands in `REMOVED` for the value of a setting that is stated in another place now."""

    words: str
    """Why, and where it is stated now."""


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
    is_date: bool = False

    @property
    def allowed(self) -> str:
        """Return the allowed values, in words."""
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
            words.append('a date from 1970 to 2261, YYYY-MM-DD' if self.is_date else 'text')
        if type(None) in self.kinds:
            words.append('none')
        return ' or '.join(words)


def setting(default: Any, help: str, lo: float | None = None, hi: float | None = None, *,
            choices: tuple[str, ...] = (), is_date: bool = False) -> Any:
    """
    Declare one setting as a dataclass field.

    Parameters
    ----------
    default
        Value if none is given; None for an optional setting.
    help
        Meaning, with the unit in square brackets.
    lo, hi
        Inclusive range of numbers.
    choices
        The allowed words, if the setting takes text; empty for any text.
    is_date
        Whether the text must be a date, YYYY-MM-DD.

    """
    return field(default=default, metadata={'help': help, 'lo': lo, 'hi': hi,
                                            'choices': tuple(choices), 'is_date': is_date})


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
    declared: list[Setting] = []
    for f in fields(settings_class):
        hint: type = _hints_of(settings_class)[f.name]
        if is_dataclass(hint):
            declared += list_settings(hint, f'{prefix}{f.name}.')
            continue
        union = get_origin(hint) in (Union, types.UnionType)
        default = f.default if f.default is not MISSING else None
        declared.append(Setting(name=prefix + f.name, default=default, help=f.metadata['help'],
                                kinds=get_args(hint) if union else (hint,), lo=f.metadata['lo'],
                                hi=f.metadata['hi'], choices=f.metadata['choices'],
                                is_date=f.metadata['is_date']))
    return tuple(declared)


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
                and (not rule.choices or value in rule.choices)
                and (not rule.is_date or _is_date(value)))
    if not good:
        raise SettingsError(f'{rule.name} = {value!r}: must be {rule.allowed}')
    return value


def _is_date(text: str) -> bool:
    """Tell whether a text is a date of the years that stamps can hold."""
    if not _DATE.fullmatch(text):
        return False
    # The Tab key needs the settings without numpy.
    import numpy as np
    try:
        np.datetime64(text)
    except ValueError:
        return False
    return '1970' <= text < '2262'


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


def explain_unknown(kind: str, name: str, names: Iterable[str]) -> SettingsError:
    """Return the error for an unknown name, with the nearest known name."""
    close = difflib.get_close_matches(name, names, n=1)
    hint = f'; did you mean {close[0]!r}?' if close else ''
    return SettingsError(f'unknown {kind} {name!r}{hint}')


class Used(NamedTuple):
    """
    The settings of a class that a program uses, which is given one file with those of others.

    Attributes
    ----------
    settings_class
        The class.
    names
        Names of settings, or of groups of settings; none names all of the class.

    """

    settings_class: type
    names: tuple[str, ...] = ()

    def has(self, name: str) -> bool:
        """Tell whether the program uses a setting."""
        return not self.names or any(
            name == prefix or name.startswith(f'{prefix}.') for prefix in self.names)


def from_mapping(settings_class: type, mapping: Mapping[str, Any]) -> Any:
    """
    Return settings made from a mapping.

    Parameters
    ----------
    settings_class
        A dataclass whose fields are made by `setting` or are such dataclasses.
    mapping
        Nested or with dotted names, in any mixture. Names that are absent take their default.

    Raises
    ------
    SettingsError
        For an unknown name, a wrong type or a value outside its range: name, value, what is
        allowed.

    """
    rules = {rule.name: rule for rule in list_settings(settings_class)}
    values = {}
    for name, value in drop_removed(settings_class, flatten(mapping)).items():
        if name not in rules:
            raise explain_unknown('setting', name, rules)
        values[name] = _check_value(rules[name], value)
    return _build(settings_class, values, '')


def _removed(settings_class: type) -> Mapping[str, Any]:
    """Return the removed settings of a class, with the value that holds always."""
    removed: Mapping[str, Any] = getattr(settings_class, 'REMOVED', {})
    return removed


def drop_removed(settings_class: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return values by dotted name without those of removed settings.

    A class names what it removed, and the value that holds always, in `REMOVED`. Recordings and
    files that state this value are read as before. One that `Moved` may be none, and the message
    does not repeat its value.

    Raises
    ------
    SettingsError
        If a removed setting has another value.

    """
    removed = _removed(settings_class)
    for name, value in values.items():
        if isinstance(removed.get(name), Moved):
            if value not in (None, 'none'):
                raise SettingsError(f'{name}: this setting was removed: {removed[name].words}')
        elif name in removed and value != removed[name]:
            raise SettingsError(f'{name} = {value!r}: this setting was removed, and its value is '
                                f'always {removed[name]!r}; take it out')
    return {name: value for name, value in values.items() if name not in removed}


def name_keywords(settings_class: type, keywords: Mapping[str, Any]) -> dict[str, Any]:
    """
    Return the dotted names and the values of settings given as keywords.

    Parameters
    ----------
    settings_class
        A dataclass whose fields are made by `setting` or are such dataclasses.
    keywords
        By the last part of the name, or by the whole name with ``_`` for the dot. A group takes
        an object of its class, or a mapping.

    Raises
    ------
    SettingsError
        For a name that is unknown or that two groups have, and for a setting given twice.

    """
    names = [*(rule.name for rule in list_settings(settings_class)), *_removed(settings_class)]
    meant: dict[str, list[str]] = {}
    for name in names:
        for keyword in dict.fromkeys((name.rpartition('.')[2], name.replace('.', '_'))):
            meant.setdefault(keyword, []).append(name)
    groups = _groups_of(settings_class)
    values: dict[str, Any] = {}
    for keyword, value in keywords.items():
        if keyword in groups:
            inner = to_mapping(value) if isinstance(value, groups[keyword]) else value
            if not isinstance(inner, Mapping):
                raise SettingsError(f'{keyword} = {value!r}: must be {groups[keyword].__name__}'
                                    '(...) or a mapping')
            stated = {f'{keyword}.{name}': value for name, value in flatten(inner).items()}
        elif keyword not in meant:
            raise explain_unknown('setting', keyword, [*meant, *groups])
        elif len(meant[keyword]) > 1:
            choices = ' or '.join(name.replace('.', '_') for name in meant[keyword])
            raise SettingsError(f'setting {keyword!r} is in several groups: give {choices}')
        else:
            stated = {meant[keyword][0]: value}
        if twice := [name for name in stated if name in values]:
            raise SettingsError(f'{twice[0]} is given twice')
        values.update(stated)
    return values


def _build(settings_class: type, values: Mapping[str, Any], prefix: str) -> Any:
    hints = _hints_of(settings_class)
    arguments = {}
    for f in fields(settings_class):
        name = prefix + f.name
        if is_dataclass(hints[f.name]):
            arguments[f.name] = _build(hints[f.name], values, name + '.')
        elif name in values:
            arguments[f.name] = values[name]
    return settings_class(**arguments)


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
    mapping
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
        settings_class = cast(type, type(self))
        for rule in list_settings(settings_class):
            if '.' not in rule.name:
                object.__setattr__(self, rule.name, _check_value(rule, getattr(self, rule.name)))
        for name, group in _groups_of(settings_class).items():
            if not isinstance(getattr(self, name), group):
                raise SettingsError(f'{name} = {getattr(self, name)!r}: must be '
                                    f'{group.__name__}(...); from_mapping takes mappings')


_NAME = re.compile('[A-Za-z][A-Za-z0-9_]{0,39}', re.ASCII)
_TRUTH = {'true': True, 'false': False}


def read_rows(text: str | None, kind: type,
              words: Mapping[str, tuple[str, Any]] | None = None) -> Iterator[tuple[str, Any]]:
    """
    Yield the settings of each row with their name.

    Parameters
    ----------
    text
        Rows separated by line ends or ``;``: a name, then ``setting=value`` in any order. Values
        with spaces stand in quotes; ``#`` begins a comment.
    kind
        The settings class of each row.
    words
        Single words that stand for a setting and its value.

    Yields
    ------
    name, settings : str, object

    Raises
    ------
    ValueError
        If a row is wrong, or a name comes twice; the message names the row.

    """
    seen: set[str] = set()
    rows = [row for row in split_rows(text) if not row.startswith('#')]
    for at, row in enumerate(rows, 1):
        try:
            name, settings = read_row(row, kind, words)
            if not _NAME.fullmatch(name):
                raise ValueError(f'{name!r}: a name must begin with a letter, and have only '
                                 'letters, digits and _, at most 40')
            if name.lower() in seen:
                raise ValueError(f'the name {name} is given twice')
        except ValueError as error:
            raise ValueError(f'row {at} ({row:.60}): {error}') from error
        seen.add(name.lower())
        yield name, settings


def read_row(row: str, kind: type,
             words: Mapping[str, tuple[str, Any]] | None = None) -> tuple[str, Any]:
    """Return the first word of a row and its settings; see `read_rows`."""
    name, *assignments = shlex.split(row, comments=True) or ('',)
    rules = {rule.name: rule for rule in list_settings(kind)}
    return name, from_mapping(kind, _read_values(assignments, rules, words or {}))


def _read_values(assignments: list[str], rules: Mapping[str, Setting],
                 words: Mapping[str, tuple[str, Any]]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for word in assignments:
        key, equals, text = word.partition('=')
        value: Any = text
        if word in words:
            key, value = words[word]
        elif not equals:
            raise ValueError(f'{word!r}: must be setting=value'
                             + ''.join(f', or {flag}' for flag in words))
        elif key not in rules:
            raise explain_unknown('setting', key, rules)
        else:
            value = _read_value(rules[key], text)
        if key in values:
            raise ValueError(f'{key} is given twice')
        values[key] = value
    return values


def _read_value(rule: Setting, text: str) -> Any:
    """Return a text as the setting takes it: a truth value, a number, or the text."""
    if bool in rule.kinds and text.lower() in _TRUTH:
        return _TRUTH[text.lower()]
    if {int, float} & {*rule.kinds}:
        try:
            return float(text)
        except ValueError:
            pass
    return text
