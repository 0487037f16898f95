# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Use cases without arguments and without output: what the command line and scripts do."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'analysis': ('analyze_bag', 'analyze_bags', 'judge_bags', 'Judgement'),
    'campaign': ('judge_inputs',),
    'cluster': ('open_cluster',),
    'compare_verdicts': ('find_differences',),
    'config': ('load_config', 'settings_for'),
    'inputs': ('analyze_input', 'sha256'),
    'job': ('Job', 'Judged'),
    'outputs': ('check_outputs', 'open_tables', 'Outputs'),
    'run_table': ('assign_runs', 'read_run_table', 'RunTable'),
    'scenarios': ('read_scenario', 'ScenarioFile'),
})
