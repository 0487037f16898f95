# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Figures of a record and its verdict: a module a family, one for their style."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'drawing': ('Drawing', 'LeftOut'),
    'gallery': ('collect', 'draw_figures', 'Drawn', 'NAMES'),
    'notebook': ('Figures', 'Plotter'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .drawing import Drawing as Drawing, LeftOut as LeftOut
    from .gallery import (
        collect as collect,
        draw_figures as draw_figures,
        Drawn as Drawn,
        NAMES as NAMES,
    )
    from .notebook import Figures as Figures, Plotter as Plotter
