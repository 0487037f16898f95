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

"""The deviation card: the fitted difference on the headings of the compass, as after a swing."""

from __future__ import annotations

import math

import numpy as np

from heading_intercompare.core.diagnostics.deviation import deviation_at, HeadingDependence
from heading_intercompare.report.formatting import number, with_uncertainty

from .tables import Table

_STEP_DEG = 45.0
_WIDEST_ARC_DEG = 120.0


def make_deviation_card(fit: HeadingDependence) -> Table | None:
    """
    Return the card of a run, a row per 45 deg.

    Parameters
    ----------
    fit
        The harmonics of the run.

    Returns
    -------
    Table or None
        None without coefficients, or if the ship left out more than 120 deg of the compass: there
        the fit would be a guess.

    """
    if fit.coefficients_deg is None or (fit.empty_arc_deg or 0.0) > _WIDEST_ARC_DEG:
        return None
    headings = np.arange(0.0, 360.0, _STEP_DEG)
    x_deg, u_deg = deviation_at(fit, headings)
    mean_deg = fit.coefficients_deg[0]
    return Table(
        ['heading [deg]', 'TS - RS, fitted [deg]', 'correction to add to the TS [deg]',
         'of this by the heading [deg]'],
        [[number(at), with_uncertainty(x, u), with_uncertainty(-x, u), f'{mean_deg - x:.3f}']
         for at, x, u in zip(headings.tolist(), x_deg.tolist(), u_deg.tolist())
         if math.isfinite(x)])
