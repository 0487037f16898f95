# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two verdicts are the same: equal integers and words, reals to 1e-12 relative."""

from __future__ import annotations

import math
from typing import Any, Iterator, Mapping

__all__ = ['find_differences']

_REL = 1e-12
# Where the data came from, not what they say.
_APART = ('inputs', 'source')


def find_differences(a: Any, b: Any, path: str = '') -> Iterator[str]:
    """
    Yield where two verdicts, as mappings, differ.

    Parameters
    ----------
    a, b : mapping
        `Verdict.to_dict()` or the JSON of a report.
    path : str
        Of the part compared.

    Yields
    ------
    str
        ``runs[0].n: 3 and 4``.

    Examples
    --------
    >>> list(find_differences({'n': 3, 'source': 'x'}, {'n': 4, 'source': 'y'}))
    ['n: 3 and 4']

    """
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        for key in [*a, *(k for k in b if k not in a)]:
            if key not in _APART:
                yield from find_differences(a.get(key), b.get(key), f'{path}.{key}'.lstrip('.'))
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for at, (x, y) in enumerate(zip(a, b)):
            yield from find_differences(x, y, f'{path}[{at}]')
    elif isinstance(a, float) and isinstance(b, float):
        if not math.isclose(a, b, rel_tol=_REL, abs_tol=1e-15):
            yield f'{path}: {a!r} and {b!r}'
    elif a != b:
        yield f'{path}: {a!r} and {b!r}'
