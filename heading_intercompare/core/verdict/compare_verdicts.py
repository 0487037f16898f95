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

"""Whether two verdicts are the same: equal integers and words, reals to 1e-12 relative."""

from __future__ import annotations

from dataclasses import replace
import math
from typing import Any, Iterator, Mapping

from .verdict_document import Verdict

_REL = 1e-12
#: The end of an interval may be a small difference of larger figures.
_ABS = 1e-14


def find_differences(a: Verdict, b: Verdict) -> Iterator[str]:
    """
    Yield the differences of two verdicts, except those of their sources.

    Yields
    ------
    str
        One difference with the names of the JSON: ``runs[0].n: 3 and 4``.

    """
    yield from compare_plain(drop_sources(a).to_dict(), drop_sources(b).to_dict())


def drop_sources(verdict: Verdict) -> Verdict:
    """Return a verdict without its sources."""
    runs = tuple(replace(run, source='') for run in verdict.runs)
    return replace(verdict, inputs=(), operator_actions=None, recordings=None, chosen=None,
                   runs=runs)


def compare_plain(a: Any, b: Any, path: str = '') -> Iterator[str]:
    """Yield the differences of two plain values, as in JSON, at a path."""
    for place, x, y in list_differences(a, b, path):
        yield f'{place}: {x!r} and {y!r}'


def list_differences(a: Any, b: Any, path: str = '', rel: float = _REL,
                     least: float = _ABS) -> Iterator[tuple[str, Any, Any]]:
    """
    Yield each place where two plain values differ, with both; the order is that of the first.

    Parameters
    ----------
    a, b
        The values.
    path
        Their place.
    rel, least
        Real figures are equal within this share of them, or within this difference.

    """
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        for key in [*a, *(k for k in b if k not in a)]:
            yield from list_differences(a.get(key), b.get(key), f'{path}.{key}'.lstrip('.'), rel,
                                        least)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for at, (x, y) in enumerate(zip(a, b)):
            yield from list_differences(x, y, f'{path}[{at}]', rel, least)
    elif isinstance(a, float) and isinstance(b, (float, int)) and not isinstance(b, bool) or (
            isinstance(b, float) and isinstance(a, int) and not isinstance(a, bool)):
        if not math.isclose(a, b, rel_tol=rel, abs_tol=least):
            yield path, a, b
    elif a != b or isinstance(a, bool) is not isinstance(b, bool):
        yield path, a, b
