# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Figures and blocks of a verdict as text for people; a missing value is a dash."""

from __future__ import annotations

import math
from typing import Any, Iterator, Mapping

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.verdict.typed_reader import make_plain
from heading_intercompare.core.verdict.vocabulary import OUTCOME_WORDS

__all__ = ['ABSENT', 'exact', 'flatten', 'interval', 'number', 'outcome', 'value']

ABSENT = '-'

_LONGEST_LIST = 12


def number(figure: float | int | None, digits: int = 6) -> str:
    """
    Return a figure as text with `digits` significant digits; integers are written in full.

    Examples
    --------
    >>> number(0.0123456789), number(7200), number(None), number(float('nan'))
    ('0.0123457', '7200', '-', '-')

    """
    if figure is None or isinstance(figure, float) and not math.isfinite(figure):
        return ABSENT
    if isinstance(figure, int):
        return str(figure)
    return f'{figure:.{digits}g}'


def interval(low: float | None, up: float | None) -> str:
    """Return the two ends of an interval as text."""
    return f'{number(low)} .. {number(up)}' if (low, up) != (None, None) else ABSENT


def outcome(found: Outcome | None) -> str:
    """Return the words of an outcome."""
    return ABSENT if found is None else OUTCOME_WORDS[found]


def value(thing: Any) -> str:
    """Return a figure, word, truth value or list as the text of a cell."""
    if thing is None or thing == '':
        return ABSENT
    if isinstance(thing, bool):
        return 'yes' if thing else 'no'
    if isinstance(thing, (int, float)):
        return number(thing)
    if isinstance(thing, (list, tuple)):
        if len(thing) > _LONGEST_LIST:
            return f'{len(thing)} values, see the JSON'
        return ', '.join(value(v) for v in thing) or ABSENT
    return OUTCOME_WORDS.get(thing, str(thing))


def exact(thing: Any) -> str:
    """Return a setting with all its digits."""
    return repr(thing) if isinstance(thing, float) and math.isfinite(thing) else value(thing)


def flatten(block: Any) -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values of a nested dataclass; items of lists count from 1."""
    yield from _flatten_mapping(make_plain(block), '')


def _flatten_mapping(block: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name, thing in block.items():
        if isinstance(thing, Mapping):
            yield from _flatten_mapping(thing, f'{prefix}{name}.')
        elif isinstance(thing, (list, tuple)) and any(isinstance(v, Mapping) for v in thing):
            yield from _flatten_mapping({str(at): v for at, v in enumerate(thing, 1)},
                                        f'{prefix}{name}.')
        else:
            yield prefix + name, thing
