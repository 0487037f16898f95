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
    return replace(verdict, inputs=(), operator_actions=None, runs=runs)


def compare_plain(a: Any, b: Any, path: str = '') -> Iterator[str]:
    """Yield the differences of two plain values, as in JSON, at a path."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        for key in [*a, *(k for k in b if k not in a)]:
            yield from compare_plain(a.get(key), b.get(key), f'{path}.{key}'.lstrip('.'))
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for at, (x, y) in enumerate(zip(a, b)):
            yield from compare_plain(x, y, f'{path}[{at}]')
    elif isinstance(a, float) and isinstance(b, float):
        if not math.isclose(a, b, rel_tol=_REL, abs_tol=_ABS):
            yield f'{path}: {a!r} and {b!r}'
    elif a != b:
        yield f'{path}: {a!r} and {b!r}'
