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

"""The table by heading: sectors centred on N, NE, E..., each with what the verdict has of it."""

from __future__ import annotations

from heading_intercompare.core.diagnostics.by_motion import BySector, SECTORS_DEG
from heading_intercompare.report.contents.heading_sectors import tabulate_sectors

NONE = (None,) * 6
SECTORS = BySector(SECTORS_DEG, (0, 400, *(0,) * 6), (0.0, 400.0, *(0.0,) * 6),
                   (None, 0.2, *NONE), (None, 0.10013, *NONE), (None, 0.168, *NONE),
                   (None, 0.232, *NONE))


def test_a_sector_has_the_figures_of_the_verdict_to_what_its_interval_allows():
    table = tabulate_sectors(SECTORS)
    assert table.rows[1] == ['NE: 22.5 to 67.5', '400', '400', '0.200', '0.168 to 0.232', '0.100']
    assert len(table.rows) == 8 and {len(row) for row in table.rows} == {len(table.head)}
    assert table.rows[7][0] == 'NW: 292.5 to 337.5'


def test_a_heading_that_the_ship_did_not_take_has_only_dashes():
    assert tabulate_sectors(SECTORS).rows[0] == ['N: 337.5 to 22.5', '0', '0', '-', '-', '-']


def test_a_mean_without_an_interval_has_a_dash_for_it():
    without = BySector(*(getattr(SECTORS, key) for key in (
        'heading_deg', 'n', 'duration_s', 'mean_deg', 'std_deg')), (None,) * 8, (None,) * 8)
    assert tabulate_sectors(without).rows[1][3:5] == ['0.2', '-']
