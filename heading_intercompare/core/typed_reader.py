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

"""Turns dataclasses into plain mappings and lists, as in JSON, and back, by annotations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass
from enum import Enum, EnumMeta
from functools import cache
import math
import re
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints, Literal, TypeGuard, Union

from .declared_figures import is_left_out, list_keys
from .outcome import Outcome

_WORDS = {bool: 'true or false', float: 'a number', int: 'an integer', str: 'text',
          NoneType: 'null'}
_LONGEST = 60
_MAJOR = re.compile('([1-9][0-9]{0,8})', re.ASCII)
_VERSION = re.compile(rf'{_MAJOR.pattern}\.[0-9]{{1,9}}', re.ASCII)
#: Integers from here on do not fit into a float.
_MOST = 2 ** 1023


_hints_of = cache(get_type_hints)


class VerdictError(ValueError):
    """A mapping is not a verdict; the message gives place, value and what is allowed."""


def make_plain(value: Any, *, exact: bool = False) -> Any:
    """
    Return a value in a form that JSON can hold.

    Dataclasses become dictionaries in the order of their fields, outcomes become words, tuples
    become lists, and a number that is not finite becomes None, unless `exact`. `read_plain`
    reverses this.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: make_plain(getattr(value, f.name), exact=exact) for f in list_keys(value)
                if not is_left_out(f, getattr(value, f.name))}
    if isinstance(value, Outcome):
        return value.value
    if isinstance(value, Mapping):
        return {str(k): make_plain(v, exact=exact) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [make_plain(v, exact=exact) for v in value]
    if isinstance(value, (bool, str)) or value is None:
        return value
    if isinstance(value, int):
        return int(value)
    number = float(value)
    return number if exact or math.isfinite(number) else None


def read_plain(kind: Any, value: Any, where: str = '') -> Any:
    """
    Return a value of a type from its plain form; reverses `make_plain`.

    Parameters
    ----------
    kind : type or annotation
        A dataclass, an enumeration, a plain type, or a union, tuple, sequence or mapping of such.
    value
        The plain form, as in JSON. Keys unknown to the dataclass are ignored.
    where
        Name of the value, such as ``runs[0].guarded``.

    Returns
    -------
    object
        A null becomes nan where None is not allowed, because numbers that were not finite became
        null. Lists become tuples. Integers stay integers where any number is allowed.

    Raises
    ------
    VerdictError
        If a key is missing, or a value is not of its type: one line that names it.

    Examples
    --------
    >>> read_plain(tuple[float, ...], [1, None])
    (1, nan)
    >>> read_plain(Mapping[str, int], {'n': 0.5}, 'counts')
    Traceback (most recent call last):
    heading_intercompare.core.typed_reader.VerdictError: counts.n = 0.5: must be an integer

    """
    if isinstance(kind, type) and is_dataclass(kind):
        return _read_dataclass(kind, value, where)
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        return _read_union(parts, value, where)
    if origin is not None and origin is not Literal:
        return _read_several(origin, parts, value, where)
    if kind is float and value is None:
        return math.nan
    if _is_of(kind, value):
        return kind(value) if _is_enumeration(kind) else value
    raise _make_error(where, value, _name(kind))


def _is_enumeration(kind: Any) -> TypeGuard[type[Enum]]:
    return isinstance(kind, EnumMeta)


def _is_of(kind: Any, value: Any) -> bool:
    """Tell whether a value fits a plain type, enumeration or choice."""
    if kind is Any:
        return True
    if get_origin(kind) is Literal:
        return value in get_args(kind)
    if _is_enumeration(kind):
        return isinstance(value, str) and value in {member.value for member in kind}
    if isinstance(value, bool):
        return kind is bool
    if kind is float and isinstance(value, int):
        return abs(value) < _MOST
    return isinstance(value, kind)


def _read_dataclass(kind: type, value: Any, where: str) -> Any:
    if not isinstance(value, Mapping):
        raise _make_error(where, value, 'an object')
    arguments = {}
    for declared in list_keys(kind):
        name = f'{where}.{declared.name}'.lstrip('.')
        if declared.name in value:
            arguments[declared.name] = read_plain(_hints_of(kind)[declared.name],
                                                  value[declared.name], name)
        elif not is_left_out(declared, None):
            raise VerdictError(f'{name} is missing')
    return kind(**arguments)


def _read_union(parts: tuple[Any, ...], value: Any, where: str) -> Any:
    if value is None and NoneType in parts:
        return None
    plain = [part for part in parts if part is not NoneType]
    if len(plain) == 1:
        return read_plain(plain[0], value, where)
    for part in plain:
        if _is_of(part, value):
            return read_plain(part, value, where)
    raise _make_error(where, value, ' or '.join(map(_name, parts)))


def _read_several(origin: type, parts: tuple[Any, ...], value: Any, where: str) -> Any:
    if issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            raise _make_error(where, value, 'an object')
        return {key: read_plain(parts[1], thing, f'{where}.{key}'.lstrip('.'))
                for key, thing in value.items()}
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise _make_error(where, value, 'a list')
    if origin is tuple and parts[-1] is not Ellipsis:
        if len(parts) != len(value):
            raise _make_error(where, value, f'a list of {len(parts)}')
    else:
        parts = (parts[0],) * len(value)
    return tuple(read_plain(part, thing, f'{where}[{at}]')
                 for at, (part, thing) in enumerate(zip(parts, value)))


def _name(kind: Any) -> str:
    """Return the allowed values of a plain type, enumeration or choice, in words."""
    if _is_enumeration(kind):
        return ' or '.join(repr(member.value) for member in kind)
    if get_origin(kind) is Literal:
        return ' or '.join(map(repr, get_args(kind)))
    return _WORDS.get(kind, str(kind))


def _make_error(where: str, value: Any, allowed: str) -> VerdictError:
    shown = repr(value)
    shown = shown if len(shown) <= _LONGEST else f'{shown[:_LONGEST]}...'
    return VerdictError(f'{where} = {shown}: must be {allowed}' if where else
                        f'{shown}: must be {allowed}')


def check_schema(mapping: Mapping[str, Any], kind: str, newest: int) -> None:
    """
    Raise VerdictError for another kind of document or another major version.

    Parameters
    ----------
    mapping
        With the keys `schema` and `schema_version`.
    kind
        The schema without its major version.
    newest
        The major version that can be read.

    """
    name, stated, readable = 'schema', mapping.get('schema'), f'{kind}{newest}'
    match = (_MAJOR.fullmatch(stated, len(kind))
             if isinstance(stated, str) and stated.startswith(kind) else None)
    if stated == readable:
        name, stated = 'schema_version', mapping.get('schema_version')
        match = _VERSION.fullmatch(stated) if isinstance(stated, str) else None
        if match is None:
            raise VerdictError(f"schema_version = {stated!r}: must be text such as '1.0'")
    if match is None or int(match[1]) < newest:
        raise VerdictError(f'{name} = {stated!r}: must be {readable!r}')
    if int(match[1]) > newest:
        raise VerdictError(f'{name} = {stated!r}: must be {readable!r}; a newer version of '
                           'heading_intercompare wrote it: install that version to read it')
