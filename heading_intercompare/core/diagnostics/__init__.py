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

"""Further findings from the pairs of a run, and the assumptions of the verdict."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'assumptions': ('Assumption',),
    'deviation': ('HeadingDependence',),
    'prepare': ('prepare_run', 'PreparedRun', 'SETTLED_SHARE'),
    'run_columns': ('RunColumns',),
    'run_diagnostics': ('diagnose', 'Diagnostics', 'with_runs'),
    'run_findings': ('Allan', 'Correlation', 'describe_drift', 'Drift', 'left_in_deg2', 'RunSkew'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .assumptions import Assumption as Assumption
    from .deviation import HeadingDependence as HeadingDependence
    from .prepare import (
        prepare_run as prepare_run,
        PreparedRun as PreparedRun,
        SETTLED_SHARE as SETTLED_SHARE,
    )
    from .run_columns import RunColumns as RunColumns
    from .run_diagnostics import (
        diagnose as diagnose,
        Diagnostics as Diagnostics,
        with_runs as with_runs,
    )
    from .run_findings import (
        Allan as Allan,
        Correlation as Correlation,
        describe_drift as describe_drift,
        Drift as Drift,
        left_in_deg2 as left_in_deg2,
        RunSkew as RunSkew,
    )
