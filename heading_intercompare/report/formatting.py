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

"""Figures and blocks of a verdict as text for people; a missing value is a dash."""

from __future__ import annotations

import math
from typing import Any, Iterator, Mapping

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.verdict.headline import OUTCOME_WORDS

ABSENT = '-'

_LONGEST_LIST = 12
_LARGE = 1e9


def number(figure: float | int | None, digits: int = 6) -> str:
    """
    Return a figure as text with `digits` significant digits; integers are written in full.

    Examples
    --------
    >>> number(0.0123456789), number(7200), number(None), number(93521.4, 4)
    ('0.0123457', '7200', '-', '93520')

    """
    if figure is None or isinstance(figure, float) and not math.isfinite(figure):
        return ABSENT
    if isinstance(figure, int):
        return str(figure)
    text = f'{figure:.{digits}g}'
    return f'{float(text):.0f}' if 'e+' in text and abs(figure) < _LARGE else text


def fixed(figure: float | None, form: str) -> str:
    """Return a figure in a form of `format`; a dash if there is none."""
    return ABSENT if figure is None or not math.isfinite(figure) else format(figure, form)


def interval(low: float | None, up: float | None) -> str:
    """Return the two ends of an interval as text."""
    return f'{number(low)} .. {number(up)}' if (low, up) != (None, None) else ABSENT


def rounded(figure: float | None, u: float | None) -> str:
    """
    Return a figure rounded to the second significant digit of its uncertainty.

    Parameters
    ----------
    figure, u
        Without an uncertainty above 0 the figure has four significant digits.

    Examples
    --------
    >>> rounded(0.0061837, 0.021349), rounded(1.2, 0.04), rounded(1234.5, 167.0)
    ('0.006', '1.200', '1230')

    """
    if figure is None or not math.isfinite(figure):
        return ABSENT
    if u is None or not math.isfinite(u) or u <= 0.0:
        return number(figure, 4)
    # Rounding may carry: 0.0996 is 0.10.
    places = 1 - int(f'{u:.1e}'.partition('e')[2])
    # Zero has no sign.
    return f'{round(figure, places) + 0.0:.{max(0, places)}f}'


def with_uncertainty(figure: float | None, u: float | None) -> str:
    """
    Return a figure and its standard uncertainty, both to its second significant digit.

    Examples
    --------
    >>> with_uncertainty(0.0061837, 0.021349), with_uncertainty(1.2, 0.04)
    ('0.006 ± 0.021', '1.200 ± 0.040')
    >>> with_uncertainty(0.5, None), with_uncertainty(None, 0.1)
    ('0.5', '-')

    """
    shown = rounded(figure, u)
    if shown == ABSENT or u is None or not math.isfinite(u) or u <= 0.0:
        return shown
    return f'{shown} ± {rounded(u, u)}'


def with_unit(text: str, unit: str) -> str:
    """
    Return a figure in text with its unit; a missing one is unknown and has none.

    Examples
    --------
    >>> with_unit('0.1', 'deg'), with_unit(ABSENT, 'deg')
    ('0.1 deg', 'unknown')

    """
    return 'unknown' if text == ABSENT else f'{text} {unit}'


def bounds(low: float | None, up: float | None) -> str:
    """
    Return the ends of an interval, rounded to the second digit of half its width.

    Examples
    --------
    >>> bounds(0.072718, 0.130505), bounds(1.0, None)
    ('0.073 to 0.131', '1 to -')

    """
    half = None if low is None or up is None else 0.5 * (up - low)
    return f'{rounded(low, half)} to {rounded(up, half)}' if (low, up) != (None, None) else ABSENT


def outcome(decision: Outcome | None) -> str:
    """Return the words of an outcome."""
    return ABSENT if decision is None else OUTCOME_WORDS[decision]


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
