# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Use cases of the command line, without arguments and without output."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'cluster': ('Cluster',),
    'compare_verdicts': ('find_differences',),
    'config': ('load_config', 'settings_for'),
    'inputs': ('analyze_input', 'sha256'),
    'job': ('Job', 'Judged'),
    'run_table': ('assign_runs', 'read_run_table', 'RunTable'),
    'scenarios': ('read_scenario', 'ScenarioFile'),
})
