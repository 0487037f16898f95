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

"""Use cases of the command line and of scripts, without arguments or output."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'analysis': ('analyze_bag', 'analyze_bags', 'judge_bags', 'Judgement'),
    'campaign': ('judge_inputs',),
    'cluster': ('open_cluster',),
    'config': ('load_config', 'settings_for'),
    'inputs': ('judge_input', 'sha256'),
    'job': ('Job',),
    'outputs': ('check_outputs', 'open_tables', 'Outputs'),
    'rejudge': ('rejudge_bag', 'Rejudged'),
    'run_table': ('assign_runs', 'read_run_table', 'RunTable'),
    'scenarios': ('read_scenario', 'ScenarioFile'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .analysis import (
        analyze_bag as analyze_bag,
        analyze_bags as analyze_bags,
        judge_bags as judge_bags,
        Judgement as Judgement,
    )
    from .campaign import judge_inputs as judge_inputs
    from .cluster import open_cluster as open_cluster
    from .config import load_config as load_config, settings_for as settings_for
    from .inputs import judge_input as judge_input, sha256 as sha256
    from .job import Job as Job
    from .outputs import (
        check_outputs as check_outputs,
        open_tables as open_tables,
        Outputs as Outputs,
    )
    from .rejudge import rejudge_bag as rejudge_bag, Rejudged as Rejudged
    from .run_table import (
        assign_runs as assign_runs,
        read_run_table as read_run_table,
        RunTable as RunTable,
    )
    from .scenarios import read_scenario as read_scenario, ScenarioFile as ScenarioFile
