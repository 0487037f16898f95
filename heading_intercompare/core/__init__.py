# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The path from headings to a verdict: no clock, thread, file or log.

The rooms stand on each other in this order: `statistics`, `pairing`, `timing`,
`decision`, `runs`, `conditions`, `diagnostics`, `verdict`; then `pipeline` and `offline` join
them.
"""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'angles': ('circular_mean', 'heading_from_quaternion', 'quaternion_from_heading',
               'unwrap_deg', 'wrap180', 'wrap360'),
    'offline': ('analyze', 'judge_aligned'),
    'outcome': ('Outcome', 'worst'),
    'pipeline': ('Compliance', 'Intercomparison', 'join'),
    'records': ('Differences', 'Headings', 'Pairs'),
    'settings': ('Checked', 'Detectors', 'explain_unknown', 'flatten', 'from_mapping',
                 'list_settings', 'Norms', 'Pairing', 'Risk', 'RunCutting', 'setting', 'Settings',
                 'SettingsError', 'to_mapping'),
    'version': ('VERSION',),
})
