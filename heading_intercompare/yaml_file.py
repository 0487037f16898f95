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
Reads YAML files as plain values, and reports a mistake in one line.

Numbers and booleans are those of YAML 1.2: 1e9 is a number, as in ROS, and `on` is a word. The
parser rejects everything that a reader could misunderstand or that could take unlimited time: a
name given twice, a tag, a second document, deep nesting, a large file. In settings it also rejects
anchors and aliases, as ROS does, and numbers such as 010, which is 10 in YAML 1.2 and 8 for ROS.
An alias is the value of its anchor, not a copy, so that a few lines cannot fill the memory.

Values are built from the events of PyYAML, because the metadata of a bag may be long. For a bag
with 3000 topics, 2.2 MB, that takes 0.5 s. The loader of PyYAML takes 2 s. ruamel.yaml, the
library for YAML 1.2, takes 4.5 s with the parser in C of its version 0.17, and 20 s without one,
as in 0.19.
"""

from __future__ import annotations

from pathlib import Path
import re
from typing import Any, Iterator

import yaml

from heading_intercompare.core.declared_settings import SettingsError

#: More than any parameter file or scenario needs.
_MOST_BYTES = 2**20
_DEEPEST = 50
_TOO_DEEP = f'nested deeper than {_DEEPEST} levels'
#: Python converts only numbers up to a few thousand digits, and no setting needs that many.
_MOST_DIGITS = 300

_Loader: type = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)

#: The core schema of YAML 1.2.
_WORDS = {'': None, '~': None, **dict.fromkeys(('null', 'Null', 'NULL')),
          **dict.fromkeys(('true', 'True', 'TRUE'), True),
          **dict.fromkeys(('false', 'False', 'FALSE'), False)}
_INTEGER = re.compile(r'[-+]?[0-9]+')
_OCTAL_IN_ROS = re.compile(r'[-+]?0[0-9]+')
_BASED = re.compile(r'0o[0-7]+|0x[0-9a-fA-F]+')
_REAL = re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?')
_NOT_FINITE = re.compile(r'(?P<sign>[-+]?)\.(?P<word>inf|Inf|INF)|\.(nan|NaN|NAN)')


class YamlError(ValueError):
    """
    A text is not YAML, or uses a part of YAML that is not accepted.

    Attributes
    ----------
    line
        The line of the mistake, counted from 1.

    """

    def __init__(self, problem: str, line: int | None = None) -> None:
        super().__init__(problem)
        self.line = line


def _read_scalar(text: str) -> Any:
    """Return the value of an unquoted scalar."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text) or _BASED.fullmatch(text):
        if len(text) > _MOST_DIGITS:
            raise YamlError('a number with too many digits')
        return int(text, 0) if _BASED.fullmatch(text) else int(text)
    if _REAL.fullmatch(text):
        return float(text)
    match = _NOT_FINITE.fullmatch(text)
    if match:
        return float(f'{match["sign"]}inf') if match['word'] else float('nan')
    return text


class _Builder:
    """Builds plain values from the events of a parser; rejects events that are not accepted."""

    def __init__(self, events: Iterator[yaml.Event], settings: bool) -> None:
        self._events = events
        self._settings = settings
        self._line = 1
        self._depth = 0
        self._anchors: dict[str, Any] = {}

    def _next(self) -> yaml.Event:
        event = next(self._events)
        self._line = event.start_mark.line + 1
        if self._settings and getattr(event, 'anchor', None) is not None:
            raise YamlError('anchors and aliases are not accepted: write the value out',
                            self._line)
        if getattr(event, 'tag', None) is not None:
            raise YamlError(f'tags are not accepted: {event.tag}', self._line)
        return event

    def document(self) -> Any:
        """Return the only document, or None if there is none."""
        value = None
        self._next()
        event = self._next()
        if isinstance(event, yaml.DocumentStartEvent):
            value = self._value(self._next())
            self._next()
            event = self._next()
        if not isinstance(event, yaml.StreamEndEvent):
            raise YamlError('there is a second document', self._line)
        return value

    def _value(self, event: yaml.Event) -> Any:
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self._anchors:
                raise YamlError(f'the alias *{event.anchor} stands before the end of what it '
                                'means, or for nothing', self._line)
            return self._anchors[event.anchor]
        anchor: str | None = getattr(event, 'anchor', None)
        if anchor is None:
            return self._plain(event)
        self._anchors.pop(anchor, None)
        value = self._anchors[anchor] = self._plain(event)
        return value

    def _plain(self, event: yaml.Event) -> Any:
        if isinstance(event, yaml.ScalarEvent):
            if self._settings and event.implicit[0] and _OCTAL_IN_ROS.fullmatch(event.value):
                raise YamlError(f'{event.value} may be octal: write it without the first zeros, '
                                'or in quotes if it is no number', self._line)
            try:
                return _read_scalar(event.value) if event.implicit[0] else event.value
            except YamlError as error:
                raise YamlError(str(error), self._line) from None
        self._depth += 1
        if self._depth > _DEEPEST:
            raise YamlError(_TOO_DEEP, self._line)
        value = (self._mapping() if isinstance(event, yaml.MappingStartEvent)
                 else self._sequence())
        self._depth -= 1
        return value

    def _sequence(self) -> list[Any]:
        values = []
        while not isinstance(event := self._next(), yaml.SequenceEndEvent):
            values.append(self._value(event))
        return values

    def _mapping(self) -> dict[Any, Any]:
        values: dict[Any, Any] = {}
        while not isinstance(event := self._next(), yaml.MappingEndEvent):
            name, line = self._name(event), self._line
            if name in values:
                raise YamlError(f'{name!r} is given twice', line)
            values[name] = self._value(self._next())
        return values

    def _name(self, event: yaml.Event) -> Any:
        if isinstance(event, (yaml.ScalarEvent, yaml.AliasEvent)):
            name = self._value(event)
            if not isinstance(name, (dict, list)):
                return name
        raise YamlError('a name must be a word', self._line)


def load_yaml(text: str, most_bytes: int = _MOST_BYTES) -> Any:
    """
    Return the value of a YAML text.

    Parameters
    ----------
    text
        One document.
    most_bytes
        A longer text is rejected.

    Raises
    ------
    YamlError
        If the text is not YAML, or uses a part of YAML that is not accepted; with the problem and
        the line.

    Examples
    --------
    >>> load_yaml('[1e9, 2.5E-3, 1e, 7, 0x10, on, true]')
    [1000000000.0, 0.0025, '1e', 7, 16, 'on', True]

    """
    return _load(text, most_bytes, settings=False)


def load_settings(text: str) -> Any:
    """Return the value of a YAML text that holds settings; YamlError as `load_yaml`."""
    return _load(text, _MOST_BYTES, settings=True)


def _load(text: str, most_bytes: int, settings: bool) -> Any:
    if len(text) > most_bytes:
        raise YamlError(f'longer than {most_bytes} bytes')
    try:
        return _Builder(yaml.parse(text, Loader=_Loader), settings).document()
    except UnicodeEncodeError as error:
        raise YamlError('not YAML: not text') from error
    except yaml.YAMLError as error:
        problem = getattr(error, 'problem', None) or 'not text'
        # Later parsers have a limit of their own, which the brackets of one line may reach first.
        raise YamlError(_TOO_DEEP if 'nesting depth' in problem else f'not YAML: {problem}',
                        _find_line(text, error)) from error


def _find_line(text: str, error: yaml.YAMLError) -> int | None:
    """Return the line of an error, counted from 1."""
    mark, place = getattr(error, 'problem_mark', None), getattr(error, 'position', None)
    if mark is not None:
        # The parser misses an end after the last line; report the last line instead.
        return int(min(mark.line, text.rstrip('\n').count('\n'))) + 1
    return None if place is None else text.encode(errors='replace').count(b'\n', 0, place) + 1


def parse_yaml(data: bytes, path: str | Path) -> Any:
    """
    Return the settings in a YAML file from its bytes.

    Raises
    ------
    SettingsError
        As `load_yaml`; the message names the file, the line and the problem.

    """
    try:
        return load_settings(data.decode())
    except UnicodeDecodeError as error:
        raise SettingsError(f'{path}: not YAML: not text') from error
    except YamlError as error:
        where = '' if error.line is None else f', line {error.line}'
        raise SettingsError(f'{path}{where}: {error}') from error
