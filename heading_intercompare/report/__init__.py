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

"""A verdict as a file for people to read: `write` chooses the form by the suffix."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Mapping, Sequence

from heading_intercompare.core.records import Headings, Pairs, Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.replaced_file import replace_file

from . import json
from .figures.drawing import Drawing
from .series_sketch import SegmentSketches, SeriesSketch
from .sketching.track import Trace

__all__ = ['annexes_path', 'check_form', 'check_picture', 'is_protocol', 'SegmentSketches',
           'SeriesSketch', 'write', 'write_chances', 'write_readings', 'write_trial_page',
           'WRITERS']

_PICTURES = ('.png', '.pdf', '.svg')


def _write_html(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch],
                progress: Callable[[str], None], verbose: bool,
                annexes: Path | None) -> None:
    # Its libraries load slowly, and may not be installed.
    from . import html
    html.write(verdict, path, sketches, progress, verbose, annexes)


def _write_json(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch],
                progress: Callable[[str], None], verbose: bool,
                annexes: Path | None) -> None:
    json.write(verdict, path)


def _write_pdf(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch],
               progress: Callable[[str], None], verbose: bool,
               annexes: Path | None) -> None:
    from . import pdf
    pdf.write(verdict, path, sketches, progress, verbose, annexes)


def _write_certificate(verdict: Verdict, path: str | Path, sketches: Sequence[SeriesSketch],
                       progress: Callable[[str], None], verbose: bool,
                       annexes: Path | None) -> None:
    from . import certificate
    certificate.write(verdict, path)


WRITERS = {'.html': _write_html, '.json': _write_json, '.pdf': _write_pdf,
           '.xml': _write_certificate}


def is_protocol(path: str | Path) -> bool:
    """Tell whether a report is a protocol for people, which may have annexes in a second file."""
    return Path(path).suffix.lower() in ('.html', '.pdf')


def check_form(path: str | Path, settings: Settings | None = None) -> None:
    """
    Reject, before any work, a report that cannot be written.

    Raises
    ------
    ValueError
        If the suffix is not a key of `WRITERS`, or a library that the protocol needs is not
        installed; or the settings, if given, lack names that a certificate has.

    """
    path = Path(path)
    form = path.suffix.lower()
    if form == '.xml' and settings is not None:
        from .certificate import check_trial
        check_trial(path, settings)
    if form not in WRITERS:
        raise ValueError(f'{path}: a report must end in {" or ".join(WRITERS)}')
    if is_protocol(path):
        try:
            from . import html  # noqa: F401
            from .figures import style  # noqa: F401
        except ImportError as error:
            raise ValueError(
                f'{path}: the protocol needs Jinja2 and matplotlib: pip install '
                "'heading_intercompare[report]' (or apt: python3-jinja2 python3-matplotlib); "
                f'{path.with_suffix(".json")} needs neither [{error}]') from error
    if form == '.pdf':
        try:
            from . import pdf  # noqa: F401
        except (ImportError, OSError) as error:
            # An OSError names a library of the system that is missing.
            reason = ' '.join(str(error).split())[:160]
            raise ValueError(
                f"{path}: a PDF needs WeasyPrint: pip install 'heading_intercompare[pdf]' (or "
                'apt: weasyprint), and Pango (apt: libpango-1.0-0 libpangoft2-1.0-0); '
                f'{path.with_suffix(".html")} needs neither, and a browser prints it '
                f'[{reason}]') from error


def write(verdict: Verdict, path: str | Path,
          sketches: Sequence[SeriesSketch] = (),
          progress: Callable[[str], None] = lambda text: None, verbose: bool = False,
          annexes_apart: bool = False) -> None:
    """
    Write a verdict in the form that the suffix names.

    Parameters
    ----------
    verdict
        The verdict to write.
    path
        Must end in a key of `WRITERS`.
    sketches
        For the figures, in the forms that have figures.
    progress
        Called with the progress in words.
    verbose
        Show the criteria of GK even if no setting asks for them.
    annexes_apart
        Whether the annexes of a protocol are a second file, `annexes_path`; see
        `html.compose_files`.

    Raises
    ------
    ValueError
        As `check_form`.
    OSError
        If a file cannot be written.

    """
    check_form(path)
    annexes = annexes_path(path) if annexes_apart else None
    WRITERS[Path(path).suffix.lower()](verdict, path, sketches, progress, verbose,
                                       annexes)


def annexes_path(path: str | Path) -> Path:
    """Return where the annexes of a protocol lie, beside it."""
    place = Path(path)
    return place.with_name(f'{place.stem}-annexes{place.suffix}')


def check_picture(path: str | Path) -> None:
    """Raise ValueError, before any work, for a picture that cannot be drawn."""
    if Path(path).suffix.lower() not in _PICTURES:
        raise ValueError(f'{path}: a picture must end in {" or ".join(_PICTURES)}')
    try:
        from .figures import style  # noqa: F401
    except ImportError as error:
        raise ValueError(f"{path}: a picture needs matplotlib: pip install "
                         f"'heading_intercompare[report]' (or apt: python3-matplotlib) [{error}]"
                         ) from error


def write_readings(path: str | Path, streams: Mapping[str, Headings], pairs: Pairs,
                   not_taken: Mapping[str, int]) -> None:
    """
    Write a picture of what was read: see `figures.readings.draw_readings` and `draw_counts`.

    Raises
    ------
    ValueError
        As `check_picture`.
    OSError
        If the file cannot be written.

    """
    check_picture(path)
    from .figures.readings import draw_counts, draw_readings
    from .figures.style import save
    save([*draw_readings(streams, pairs), *draw_counts(not_taken)], path)


def write_chances(path: str | Path, drawing: Drawing) -> None:
    """
    Write the picture of a plan; see `figures.chances.draw_chances`.

    Raises
    ------
    ValueError
        As `check_picture`.
    OSError
        If the file cannot be written.

    """
    check_picture(path)
    from .figures.style import save
    save([drawing], path)


def write_trial_page(path: str | Path, title: str, lines: Sequence[str],
                     traces: Sequence[Trace] = (),
                     seeds: Mapping[str, Sequence[float] | Reals] | None = None,
                     chances: Drawing | None = None) -> None:
    """Write the page of a simulated trial; see `trial_page.compose_trial_page`."""
    from .trial_page import compose_trial_page
    replace_file(path, compose_trial_page(title, lines, traces, seeds, chances))
