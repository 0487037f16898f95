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

"""How a figure of a verdict is declared: key of the JSON, words, unit, row and explanation."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, is_dataclass, MISSING, replace
from functools import cache
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints, Iterator, Mapping, Union

_FIGURE, _UNIT, _NO_KEY = 'figure', 'unit', 'no_key'

#: The end of a key carries its unit; the first that fits.
_UNITS = {'_deg_per_h': 'deg/h', '_deg_s': 'deg/s', '_deg2': 'deg²', '_deg': 'deg', '_kn': 'kn',
          '_ns': 'UTC', '_s': 's', '_h': 'h'}


@dataclass(frozen=True, slots=True)
class Figure:
    """
    A declared figure: what schema, docs, terminal and protocol say of it.

    Attributes
    ----------
    words
        What it is, as in a row of the protocol.
    note
        What the docs and the schema add.
    unit
        '1' is the unit of a number without dimension, '' that of anything else.
    u_key, up_key
        Keys of its standard uncertainty, and of the upper end of the interval that it begins,
        which stand beside it; empty if there is none.
    row
        What it is in the narrow table of a terminal; empty for the words.
    prefix
        What stands before the words of the figures in it.
    absent
        When its key is left out, because it is None; empty if never.
    choices
        The words of the JSON that it may be, and what they mean.

    """

    words: str
    note: str
    unit: str
    u_key: str
    up_key: str
    row: str
    prefix: str
    absent: str
    choices: Mapping[str, str]

    @property
    def text(self) -> str:
        """Return the explanation in docs and schema."""
        unit = {'': '', '1': '', 'UTC': ' [ns, UTC]'}.get(self.unit, f' [{self.unit}]')
        parts = [f'{self.words}{unit}', self.note, self.absent and f'absent {self.absent}']
        parts[1:1] = [f'`{key}`' if key == words else f'`{key}`: {words}'
                      for key, words in self.choices.items()]
        return '; '.join(filter(None, parts))


def figure(words: str, note: str = '', *, default: Any = MISSING, unit: str | None = None,
           u: str = '', up: str = '', row: str = '', prefix: str = '', absent: str = '',
           choices: Mapping[str, str] | None = None) -> Any:
    """
    Declare a figure of a verdict as a dataclass field, whose name is its key in the JSON.

    Parameters
    ----------
    words, note
        What it is, and what docs and schema add.
    default
        None if it may be absent.
    unit
        Without it the end of the name and the type say the unit.
    u, up, row, prefix, absent, choices
        See `Figure`.

    """
    return field(default=None if absent else default, metadata={
        _FIGURE: Figure(words=words, note=note, unit='', u_key=u, up_key=up, row=row,
                        prefix=prefix, absent=absent, choices=choices or {}), _UNIT: unit})


def no_key() -> Any:
    """Declare a field of a dataclass that is no key of the JSON, and None when read."""
    return field(default=None, compare=False, repr=False, metadata={_NO_KEY: True})


def list_keys(kind: Any) -> list[Any]:
    """Return the fields of a dataclass, or of an instance, that are keys of the JSON."""
    return [f for f in fields(kind) if not f.metadata.get(_NO_KEY, False)]


def is_left_out(declared: Any, value: Any) -> bool:
    """Tell whether the key of a field, from `dataclasses.fields`, is left out."""
    block = declared.metadata.get(_FIGURE)
    return value is None and block is not None and block.absent != ''


@cache
def list_figures(kind: Any) -> Mapping[str, Figure]:
    """Return the declared figures of a dataclass, and those of its parts by dotted keys."""
    figures: dict[str, Figure] = {}
    hints = get_type_hints(kind)
    for declared in list_keys(kind):
        if _FIGURE not in declared.metadata:
            continue
        key, hint = declared.name, hints[declared.name]
        block: Figure = declared.metadata[_FIGURE]
        unit = declared.metadata[_UNIT]
        figures[key] = replace(block, unit=find_unit(key, hint) if unit is None else unit)
        for part in get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,):
            if isinstance(part, type) and is_dataclass(part):
                figures |= {f'{key}.{name}': replace(
                    inner, words=block.prefix + inner.words,
                    u_key=inner.u_key and f'{key}.{inner.u_key}',
                    up_key=inner.up_key and f'{key}.{inner.up_key}')
                    for name, inner in list_figures(part).items()}
    return figures


def find_figure(record: Any, key: str) -> Any:
    """Return the figure of a dotted key; None if its block is missing."""
    for name in key.split('.'):
        record = None if record is None else getattr(record, name)
    return record


def find_unit(key: str, hint: Any) -> str:
    """Return the unit that the end of a key and the type of its value say; see `Figure`."""
    for end, unit in _UNITS.items():
        if key.endswith(end):
            return unit
    kinds = {*_list_kinds(hint)}
    return '1' if kinds & {int, float} and bool not in kinds else ''


def _list_kinds(hint: Any) -> Iterator[Any]:
    yield hint
    for part in get_args(hint):
        yield from _list_kinds(part)
