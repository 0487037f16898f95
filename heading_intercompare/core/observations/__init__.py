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

"""Observations of the true heading as a reference: corrections, their budget, the decision."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'budget': ('Budget', 'Component', 'make_budget'),
    'corrections': ('Corrections', 'find_corrections', 'Observations'),
    'sight_lines': ('bearing_between', 'bearing_uncertainty', 'line_bearing', 'quay_angle'),
    'systematic_error': ('judge_corrections', 'SystematicError'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .budget import Budget as Budget, Component as Component, make_budget as make_budget
    from .corrections import (
        Corrections as Corrections,
        find_corrections as find_corrections,
        Observations as Observations,
    )
    from .sight_lines import (
        bearing_between as bearing_between,
        bearing_uncertainty as bearing_uncertainty,
        line_bearing as line_bearing,
        quay_angle as quay_angle,
    )
    from .systematic_error import (
        judge_corrections as judge_corrections,
        SystematicError as SystematicError,
    )
