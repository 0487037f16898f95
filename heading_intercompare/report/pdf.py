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

"""The protocol as PDF, printed from its HTML without a browser."""

from __future__ import annotations

from contextlib import contextmanager
import logging
from pathlib import Path
import re
from typing import Callable, Iterator, NoReturn, Sequence

import weasyprint

from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import replace_file

from . import html
from .series_sketch import SeriesSketch

_STEP = re.compile(r'Step (\d)(?:.*Page (\d+))?')
#: Part of the time before each step of WeasyPrint, and that of a page of a usual protocol.
_BEFORE = {2: 0.05, 3: 0.1, 4: 0.25, 5: 0.3, 6: 0.65, 7: 1.0}
_PAGES, _PER_PAGE = 5, 0.018


def write(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch] = (),
          progress: Callable[[str], None] = lambda text: None, verbose: bool = False,
          annexes: Path | None = None) -> None:
    """
    Write the protocol on pages of A4.

    Parameters
    ----------
    verdict
        The verdict to show.
    path
        The file.
    sketches
        One per input, for the figures; without any there are no figures.
    progress
        Called with the progress in words.
    verbose
        Show the criteria of GK even if no setting asks for them.
    annexes
        A second file for the annexes; see `html.compose_files`.

    Raises
    ------
    OSError
        If a file cannot be written.

    """
    for place, text in html.compose_files(verdict, path, sketches, progress, verbose,
                                          annexes):
        print_page(text, place, progress)


def print_page(text: str, path: str | Path,
               progress: Callable[[str], None] = lambda text: None) -> None:
    """Write a page of HTML that needs nothing from elsewhere as PDF; OSError if that fails."""
    with _told_to(progress):
        document = weasyprint.HTML(string=text, url_fetcher=_refuse).write_pdf()
    replace_file(path, document)


class _ProgressHandler(logging.Handler):
    """Says how much of the layout is done, from the steps that WeasyPrint logs."""

    def __init__(self, progress: Callable[[str], None]) -> None:
        super().__init__()
        self._progress, self._share = progress, 0.0

    def emit(self, record: logging.LogRecord) -> None:
        if (match := _STEP.match(record.getMessage())) is None:
            return
        step, page = int(match[1]), int(match[2] or 0)
        share = _BEFORE.get(step, 0.0)
        if step == _PAGES:
            share = min(share + _PER_PAGE * page, _BEFORE[_PAGES + 1])
        # Pages are laid out again when their number has become known.
        self._share = max(share, self._share)
        self._progress(f'{self._share:.0%} of the pages laid out')


@contextmanager
def _told_to(progress: Callable[[str], None]) -> Iterator[None]:
    logger, handler = logging.getLogger('weasyprint.progress'), _ProgressHandler(progress)
    before = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(handler)


def _refuse(url: str, *rest: object, **more: object) -> NoReturn:
    """Refuse to fetch anything: the page holds all it needs."""
    raise ValueError(f'{url}: the protocol needs nothing from elsewhere')
