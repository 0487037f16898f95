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

"""The JSON Schema of the verdict, derived from its dataclasses and their declared figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from enum import Enum, EnumMeta
from types import NoneType, UnionType
from typing import Any, cast, get_args, get_origin, get_type_hints, Literal, Union

from heading_intercompare.core.declared_figures import is_left_out, list_figures, list_keys
from heading_intercompare.core.declared_settings import list_settings, Setting
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.validity.condition import (
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.verdict.validity import CONDITION_WORDS
from heading_intercompare.core.verdict.verdict_document import SCHEMA, SCHEMA_VERSION, Verdict

_PLAIN = {bool: 'boolean', float: 'number', int: 'integer', str: 'string', NoneType: 'null'}
_MAJOR = SCHEMA_VERSION.partition('.')[0]


def make_schema() -> dict[str, Any]:
    """
    Return the JSON Schema, draft 2020-12, of `Verdict.to_dict`.

    Returns
    -------
    dict
        It requires every key that a verdict of this version has. It allows others, because
        later minor versions add keys. A number that need not be finite may be null.

    """
    kinds: dict[str, Any] = {}
    whole = _describe_dataclass(Verdict, kinds)
    properties = {
        'schema': {'const': SCHEMA,
                   'description': f'`{SCHEMA}`: kind of the document, and its major version'},
        'schema_version': {'type': 'string', 'pattern': rf'^{_MAJOR}\.[0-9]+$',
                           'description': f'major and minor version, `{SCHEMA_VERSION}`'},
        'settings_sha256': {'type': 'string', 'pattern': '^[0-9a-f]{64}$',
                            'description': 'hash of `settings`'},
        'ledger_complete': {'type': 'boolean',
                            'description': 'whether every reading is accounted for'},
        **whole['properties'],
    }
    properties['settings'] = {'description': properties['settings']['description'],
                              **_describe_settings()}
    required = [*properties.keys() - whole['properties'].keys(), *whole['required']]
    del kinds[Settings.__name__]
    # Later minor versions may add conditions, so the names are no closed list.
    finding = kinds[Finding.__name__]['properties']
    finding['condition'] |= {'examples': [*CONDITION_WORDS]}
    finding['effect'] |= {'enum': [HOLDS, NOT_TESTABLE, DOUBTFUL, VOID]}
    return {
        '$schema': 'https://json-schema.org/draft/2020-12/schema',
        '$id': f'urn:heading_intercompare:verdict:{SCHEMA_VERSION}',
        'title': f'Verdict of heading_intercompare, version {SCHEMA_VERSION}',
        'description': 'The keys are explained in docs/verdict_json.md.',
        'type': 'object', 'required': sorted(required),
        'properties': properties, '$defs': {name: kinds[name] for name in sorted(kinds)}}


def _describe(kind: Any, kinds: dict[str, Any]) -> dict[str, Any]:
    """Return the schema of an annotation; add its dataclasses to `kinds`."""
    if is_dataclass(kind):
        name: str = cast(type, kind).__name__
        if name not in kinds:
            kinds[name] = {}
            # The verdict lists settings under their dotted names.
            kinds[name] = {} if kind is Settings else _describe_dataclass(kind, kinds)
        return {'$ref': f'#/$defs/{name}'}
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return _join([_describe(part, kinds) for part in parts])
    if origin is Literal:
        return {'enum': [*parts]}
    if origin is not None:
        return _describe_several(origin, parts, kinds)
    if isinstance(kind, EnumMeta):
        members: list[Enum] = list(kind)
        return {'enum': [member.value for member in members]}
    if kind is Any:
        return {}
    return {'type': ['number', 'null'] if kind is float else _PLAIN[kind]}


def _describe_dataclass(kind: Any, kinds: dict[str, Any]) -> dict[str, Any]:
    hints, figures = get_type_hints(kind), list_figures(kind)
    return {'type': 'object',
            'required': [f.name for f in list_keys(kind) if not is_left_out(f, None)],
            'properties': {f.name: {'description': figures[f.name].text,
                                    **_describe(hints[f.name], kinds)} for f in list_keys(kind)}}


def _describe_several(origin: type, parts: tuple[Any, ...],
                      kinds: dict[str, Any]) -> dict[str, Any]:
    if issubclass(origin, Mapping):
        return {'type': 'object', 'additionalProperties': _describe(parts[1], kinds)}
    if origin is tuple and parts[-1] is not Ellipsis:
        return {'type': 'array', 'prefixItems': [_describe(part, kinds) for part in parts],
                'minItems': len(parts), 'maxItems': len(parts)}
    return {'type': 'array', 'items': _describe(parts[0], kinds)}


def _join(choices: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the schema of a union: a single list of types if that is enough."""
    if all([*choice] == ['type'] for choice in choices):
        types = [name for choice in choices for name in
                 ([choice['type']] if isinstance(choice['type'], str) else choice['type'])]
        return {'type': [*dict.fromkeys(types)]}
    return {'anyOf': choices}


def _describe_settings() -> dict[str, Any]:
    rules = list_settings(Settings)
    fixed = {name: {'description': 'always this; it was a setting', 'const': value}
             for name, value in Settings.REMOVED.items()}
    return {'type': 'object', 'required': [*(rule.name for rule in rules), *fixed],
            'properties': {rule.name: _describe_setting(rule) for rule in rules} | fixed}


def _describe_setting(rule: Setting) -> dict[str, Any]:
    """Return the schema of a setting: its description, range and choices."""
    numbers = [_PLAIN[kind] for kind in rule.kinds if kind in (int, float)]
    choices: list[dict[str, Any]] = []
    if numbers:
        bounds = {'minimum': rule.lo, 'maximum': rule.hi}
        choices.append({'type': 'number' if 'number' in numbers else 'integer',
                        **{name: to for name, to in bounds.items() if to is not None}})
    if str in rule.kinds:
        choices.append({'enum': [*rule.choices]} if rule.choices else {'type': 'string'})
    choices += [{'type': _PLAIN[kind]} for kind in rule.kinds if kind in (bool, NoneType)]
    described = choices[0] if len(choices) == 1 else {'anyOf': choices}
    return {'description': rule.help, **described}
