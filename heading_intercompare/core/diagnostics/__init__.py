# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Further findings from the pairs of a run, and the assumptions of the verdict."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'assumptions': ('Assumption',),
    'deviation': ('HeadingDependence',),
    'run_diagnostics': ('diagnose', 'Diagnostics', 'SETTLED_SHARE', 'with_runs'),
    'run_findings': ('Allan', 'Correlation', 'describe_drift', 'Drift', 'left_in_deg2', 'RunSkew'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .assumptions import Assumption as Assumption
    from .deviation import HeadingDependence as HeadingDependence
    from .run_diagnostics import (
        diagnose as diagnose,
        Diagnostics as Diagnostics,
        SETTLED_SHARE as SETTLED_SHARE,
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
