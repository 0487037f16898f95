# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A verdict as a file for people: `write` picks the form by the suffix."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

from heading_intercompare.core.verdict.verdict_document import Verdict

from . import html, json
from .series_sketch import SeriesSketch

__all__ = ['SeriesSketch', 'write', 'WRITERS']

WRITERS = {'.html': html.write, '.json': json.write}


def write(verdict: Verdict, path: str | Path,
          sketches: Sequence[SeriesSketch] = ()) -> None:
    """
    Write a verdict in the form that the suffix names.

    Parameters
    ----------
    verdict : Verdict
    path : str or Path
        Ending in a key of `WRITERS`.
    sketches : sequence of SeriesSketch
        For the figures of the forms that have some.

    Raises
    ------
    ValueError, OSError
        If the suffix is unknown, or the file cannot be written.

    """
    writer = WRITERS.get(Path(path).suffix.lower())
    if writer is None:
        raise ValueError(f'{path}: a report must end in {" or ".join(WRITERS)}')
    writer(verdict, path, sketches)
