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

"""The figures of a verdict in a notebook, with their captions."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Any, Sequence

from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.report.series_sketch import SeriesSketch

from .drawing import Drawing, LeftOut
from .gallery import collect, NAMES


class Figures(list[Any]):
    """Figures of matplotlib, which a notebook shows one below the other with their captions."""

    def __init__(self, drawings: Sequence[Drawing], left_out: Sequence[LeftOut] = ()) -> None:
        from .style import to_figure
        super().__init__(to_figure(drawing) for drawing in drawings)
        self._drawings, self._left_out = drawings, left_out

    def _repr_html_(self) -> str:
        """Return the figures as SVG, and what is left out with the reason."""
        from .style import to_svg
        shown = [f'<figure>{to_svg(drawing, f"{drawing.name}{k}")}<figcaption>'
                 f'{escape(drawing.caption)}</figcaption></figure>'
                 for k, drawing in enumerate(self._drawings)]
        shown += [f'<p>{escape(omission.title)}. Left out: {escape(omission.reason)}.</p>'
                  for omission in self._left_out]
        return ''.join(shown)


@dataclass(frozen=True, slots=True)
class Plotter:
    """
    Draws the figures of a verdict; `Verdict.plot` calls it.

    Attributes
    ----------
    sketches
        One per record.

    """

    sketches: tuple[SeriesSketch, ...]

    def __call__(self, verdict: Verdict, name: str | None = None) -> Any:
        """
        Return the figures of the verdict.

        Parameters
        ----------
        verdict
            The verdict whose figures are drawn.
        name
            One of `NAMES`; default all.

        Returns
        -------
        Figures, or Figure of matplotlib
            The figure, if there is one record and a name. Otherwise a list of the figures.

        Raises
        ------
        ValueError
            If there is no such figure, it cannot be drawn, or matplotlib is not installed.

        """
        if name is not None and name not in NAMES:
            raise ValueError(f'plot({name!r}): must be one of {", ".join(NAMES)}')
        try:
            from . import style  # noqa: F401
        except ImportError as error:
            raise ValueError("plot: figures need matplotlib: pip install 'heading_intercompare"
                             f"[report]' [{error}]") from error
        candidates = [candidate for sketch in self.sketches
                      for candidate in collect(sketch, verdict, name)]
        drawings = [drawing for drawing in candidates if isinstance(drawing, Drawing)]
        left_out = [omission for omission in candidates if isinstance(omission, LeftOut)]
        if not drawings:
            why = left_out[0].reason if left_out else 'there is no difference to draw'
            raise ValueError(f'plot({"" if name is None else repr(name)}): {why}')
        figures = Figures(drawings, left_out)
        return figures[0] if name is not None and len(self.sketches) == 1 else figures
