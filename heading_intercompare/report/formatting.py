# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Figures, stamps and blocks of a verdict as people read them; what is absent is a dash."""

from __future__ import annotations

from datetime import datetime, timezone
import math
from typing import Any, Iterator, Mapping

from .vocabulary import OUTCOME_WORDS

__all__ = ['ABSENT', 'exact', 'explain_no_run', 'flat', 'interval', 'NO_RUN', 'number', 'outcome',
           'utc', 'value']

ABSENT = '-'
NO_RUN = 'No run: no pair was made, or none in a run long enough.'

_LONGEST_LIST = 12


def number(figure: float | int | None, digits: int = 6) -> str:
    """
    Return a figure with so many significant digits; integers are written out.

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
    """Return the two ends of an interval."""
    return f'{number(low)} .. {number(up)}' if (low, up) != (None, None) else ABSENT


def outcome(word: str | None) -> str:
    """Return the words of an outcome."""
    return ABSENT if word is None else OUTCOME_WORDS.get(word, word)


def explain_no_run(given: Mapping[str, Any]) -> str | None:
    """Return why no run came of an input, which is described as in the JSON; None if some did."""
    if 'same_as' in given:
        return f'it has the data of {given["same_as"]}'
    return given.get('error') or given.get('no_run')


def value(thing: Any) -> str:
    """Return a figure, word, truth value or list, as a cell holds it."""
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


def utc(stamp_ns: int | None) -> str:
    """Return a stamp as UTC text, rounded down to milliseconds."""
    if stamp_ns is None:
        return ABSENT
    seconds, ns = divmod(stamp_ns, 1_000_000_000)
    try:
        moment = datetime.fromtimestamp(seconds, timezone.utc)
    except (OverflowError, OSError, ValueError):
        return f'{stamp_ns} ns'
    return f'{moment:%Y-%m-%d %H:%M:%S}.{ns // 1_000_000:03d}'


def flat(block: Mapping[str, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values of a nested block, lists of blocks numbered from 1."""
    for name, thing in block.items():
        if isinstance(thing, Mapping):
            yield from flat(thing, f'{prefix}{name}.')
        elif isinstance(thing, (list, tuple)) and any(isinstance(v, Mapping) for v in thing):
            yield from flat({str(at): v for at, v in enumerate(thing, 1)}, f'{prefix}{name}.')
        else:
            yield prefix + name, thing
