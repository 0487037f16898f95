# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The protocol as PDF, printed from its HTML without a browser."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn, Sequence

import weasyprint

from heading_intercompare.core.verdict.verdict_document import Verdict

from . import html
from .series_sketch import SeriesSketch

__all__ = ['write']


def write(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch] = ()) -> None:
    """
    Write the protocol on pages of A4.

    Parameters
    ----------
    verdict : Verdict
    path : str or Path
    sketches : sequence of SeriesSketch
        One per input, for the figures; without any there are no figures.

    Raises
    ------
    OSError
        If the file cannot be written.

    """
    page = weasyprint.HTML(string=html.render(verdict, sketches), url_fetcher=_refuse)
    # Made first, so that a fault leaves no half-written file.
    Path(path).write_bytes(page.write_pdf())


def _refuse(url: str, *rest: object, **more: object) -> NoReturn:
    """Refuse to fetch anything: the page holds all it needs."""
    raise ValueError(f'{url}: the protocol needs nothing from elsewhere')
