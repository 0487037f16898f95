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

"""The deviation card of the protocol."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from heading_intercompare.core.diagnostics.deviation import fit_deviation
from heading_intercompare.report.contents.findings import make_deviation_card


def fit_of(rng, headings):
    """Return the fit of differences 0.1 + 0.4 sin psi with noise."""
    return fit_deviation(0.1 + 0.4 * np.sin(np.radians(headings))
                         + 0.01 * rng.standard_normal(headings.size), headings)


def test_the_card_has_a_row_per_eighth_of_the_compass(rng):
    """At 90 deg the TS shows 0.1 + 0.4 too much: the correction is -0.5, -0.4 by the heading."""
    card = make_deviation_card(fit_of(rng, np.linspace(0.0, 3600.0, 20_000) % 360.0))
    assert [row[0] for row in card.rows] == ['0', '45', '90', '135', '180', '225', '270', '315']
    east = card.rows[2]
    assert east[1].startswith('0.50') and east[2].startswith('-0.50')
    assert east[3].startswith('-0.40')
    assert all(len(row) == len(card.head) for row in card.rows)


def test_there_is_no_card_without_a_fit_or_for_a_part_of_the_compass(rng):
    wide = fit_of(rng, np.linspace(0.0, 3600.0, 20_000) % 360.0)
    assert make_deviation_card(replace(wide, coefficients_deg=None)) is None
    assert make_deviation_card(replace(wide, empty_arc_deg=200.0)) is None
