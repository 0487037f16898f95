# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of the runs of a verdict as a data frame of pandas, which is optional."""

from __future__ import annotations

from typing import Any, Iterator, Mapping, TYPE_CHECKING

from .typed_reader import make_plain
from .verdict_document import Verdict

if TYPE_CHECKING:
    import pandas

__all__ = ['frame_of_runs']


def frame_of_runs(verdict: Verdict) -> 'pandas.DataFrame':
    """Return a data frame with a row per run; see `Verdict.to_frame`."""
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise ValueError(f'to_frame needs pandas (no module {error.name}): install it, or use '
                         'the attributes of the runs') from error
    rows = [dict(_figures(make_plain(run))) for run in verdict.runs]
    frame = pandas.DataFrame(rows)
    return frame.set_index('run') if rows else frame


def _figures(block: Mapping[str, Any], prefix: str = '') -> Iterator[tuple[str, Any]]:
    """Yield dotted names and values, without lists."""
    for name, thing in block.items():
        if isinstance(thing, Mapping):
            yield from _figures(thing, f'{prefix}{name}.')
        elif not isinstance(thing, list):
            yield prefix + name, thing
