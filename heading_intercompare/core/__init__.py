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

"""
The path from headings to a verdict: no clock, thread, file or log.

The rooms build on each other in this order: `statistics`, `raw_streams`, `pairing`, `timing`,
`decision`, `observations`, `runs`, `conditions`, `diagnostics`, `verdict`. The modules `pipeline`
and `offline` join them.
"""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'angles': ('circular_mean', 'heading_from_quaternion', 'quaternion_from_heading',
               'unwrap_deg', 'wrap180', 'wrap360'),
    'offline': ('judge_aligned',),
    'outcome': ('Outcome', 'worst'),
    'pipeline': ('Compliance', 'Intercomparison', 'join'),
    'records': ('Differences', 'Headings', 'Pairs'),
    'settings': ('Checked', 'Detectors', 'explain_unknown', 'flatten', 'from_mapping',
                 'list_settings', 'Norms', 'Pairing', 'Risk', 'RunCutting', 'setting', 'Settings',
                 'settings_sha256', 'SettingsError', 'to_mapping'),
    'version': ('RULE_VERSION', 'VERSION'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .angles import (
        circular_mean as circular_mean,
        heading_from_quaternion as heading_from_quaternion,
        quaternion_from_heading as quaternion_from_heading,
        unwrap_deg as unwrap_deg,
        wrap180 as wrap180,
        wrap360 as wrap360,
    )
    from .offline import judge_aligned as judge_aligned
    from .outcome import Outcome as Outcome, worst as worst
    from .pipeline import (
        Compliance as Compliance,
        Intercomparison as Intercomparison,
        join as join,
    )
    from .records import Differences as Differences, Headings as Headings, Pairs as Pairs
    from .settings import (
        Checked as Checked,
        Detectors as Detectors,
        explain_unknown as explain_unknown,
        flatten as flatten,
        from_mapping as from_mapping,
        list_settings as list_settings,
        Norms as Norms,
        Pairing as Pairing,
        Risk as Risk,
        RunCutting as RunCutting,
        setting as setting,
        Settings as Settings,
        settings_sha256 as settings_sha256,
        SettingsError as SettingsError,
        to_mapping as to_mapping,
    )
    from .version import RULE_VERSION as RULE_VERSION, VERSION as VERSION
