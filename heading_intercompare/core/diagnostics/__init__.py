# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What else the pairs of a run say: findings and assumptions."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'assumptions': ('Assumption',),
    'deviation': ('HeadingDependence',),
    'run_diagnostics': ('diagnose', 'Diagnostics', 'SETTLED_SHARE', 'with_runs'),
    'run_findings': ('Allan', 'Correlation', 'describe_drift', 'Drift', 'left_in_deg2', 'RunSkew'),
})
