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

"""Named settings of one kind, as a person writes them: a row of text each."""

from __future__ import annotations

import re
import shlex
from typing import Any, Iterator, Mapping

from heading_intercompare.core.declared_settings import (
    explain_unknown,
    from_mapping,
    list_settings,
    Setting,
)

__all__ = ['read_rows']

_NAME = re.compile('[A-Za-z][A-Za-z0-9_]{0,39}', re.ASCII)
_TRUTH = {'true': True, 'false': False}


def read_rows(text: str | None, kind: type,
              words: Mapping[str, tuple[str, Any]] | None = None) -> Iterator[tuple[str, Any]]:
    """
    Yield the settings of each row with their name.

    Parameters
    ----------
    text : str or None
        Rows separated by line ends or ``;``: a name, then ``setting=value`` in any order. Values
        with spaces stand in quotes; ``#`` begins a comment.
    kind : type
        The settings class of each row.
    words : mapping of str to (str, object), optional
        Single words that stand for a setting and its value.

    Yields
    ------
    name, settings : str, object

    Raises
    ------
    ValueError
        If a row is wrong, or a name comes twice; the message names the row.

    """
    rules = {rule.name: rule for rule in list_settings(kind)}
    seen: set[str] = set()
    rows = [row for row in map(str.strip, re.split(r'[;\r\n]', text or ''))
            if row and not row.startswith('#')]
    for at, row in enumerate(rows, 1):
        try:
            name, *assignments = shlex.split(row, comments=True)
            if not _NAME.fullmatch(name):
                raise ValueError(f'{name!r}: a name must begin with a letter, and have only '
                                 'letters, digits and _, at most 40')
            if name.lower() in seen:
                raise ValueError(f'the name {name} is given twice')
            settings = from_mapping(kind, _read_values(assignments, rules, words or {}))
        except ValueError as error:
            raise ValueError(f'row {at} ({row:.60}): {error}') from error
        seen.add(name.lower())
        yield name, settings


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
