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
Decide, from recorded data, whether a heading sensor meets its accuracy norm.

It compares a tested sensor (TS) with a reference sensor (RS) on the same ship. Start with
`analyze` for arrays, `analyze_logs` for two logs or `analyze_bag` for a recording. Settings have
the same names as in the parameter file.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

from heading_intercompare.core.version import VERSION as __version__

_OFFERED = {
    'app.analysis': ('analyze', 'analyze_bag', 'analyze_bags', 'analyze_sensors', 'judge_bags'),
    'app.logs.trial_logs': ('analyze_logs', 'judge_logs'),
    'bags.recording.recorded_headings': ('read_bag', 'RecordedHeadings'),
    'bags.rosbag2.bag_reader': ('BagReader',),
    'core.declared_settings': ('SettingsError',),
    'core.decision.trial_plan': ('plan_trial', 'TrialPlan'),
    'core.diagnostics.three_cornered_hat': ('at_common_stamps', 'Hats', 'three_cornered_hat'),
    'core.outcome': ('Outcome',),
    'core.pairing.pairer': ('pair', 'Pairer'),
    'core.pipeline': ('Compliance', 'Intercomparison'),
    'core.records': ('Differences', 'Headings', 'Motion', 'Pairs'),
    'core.sensors.sensors_verdict': ('SensorsVerdict',),
    'core.settings': ('Alignment', 'CampaignRule', 'Detectors', 'MotionRule', 'Norms', 'Pairing',
                      'Risk', 'RunCutting', 'Sequential', 'Settings', 'Trial'),
    'core.verdict.all_runs': ('join',),
    'core.verdict.verdict_document': ('RunVerdict', 'Verdict'),
    'drivers.settings': ('DriverSettings',),
}
"""The names that are offered, by the module that defines them; it is loaded at first use."""
_MODULES = {name: module for module, names in _OFFERED.items() for name in names}
__all__ = list(_MODULES)
__all__ += ['__version__']


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_MODULES[name]}'), name)


def __dir__() -> list[str]:
    return __all__


if TYPE_CHECKING:
    # The same names for type checkers and editors.
    from .app.analysis import (
        analyze as analyze,
        analyze_bag as analyze_bag,
        analyze_bags as analyze_bags,
        analyze_sensors as analyze_sensors,
        judge_bags as judge_bags,
    )
    from .app.logs.trial_logs import analyze_logs as analyze_logs, judge_logs as judge_logs
    from .bags.recording.recorded_headings import (
        read_bag as read_bag,
        RecordedHeadings as RecordedHeadings,
    )
    from .bags.rosbag2.bag_reader import BagReader as BagReader
    from .core.decision.trial_plan import plan_trial as plan_trial, TrialPlan as TrialPlan
    from .core.declared_settings import SettingsError as SettingsError
    from .core.diagnostics.three_cornered_hat import (
        at_common_stamps as at_common_stamps,
        Hats as Hats,
        three_cornered_hat as three_cornered_hat,
    )
    from .core.outcome import Outcome as Outcome
    from .core.pairing.pairer import pair as pair, Pairer as Pairer
    from .core.pipeline import Compliance as Compliance, Intercomparison as Intercomparison
    from .core.records import (
        Differences as Differences,
        Headings as Headings,
        Motion as Motion,
        Pairs as Pairs,
    )
    from .core.sensors.sensors_verdict import SensorsVerdict as SensorsVerdict
    from .core.settings import (
        Alignment as Alignment,
        CampaignRule as CampaignRule,
        Detectors as Detectors,
        MotionRule as MotionRule,
        Norms as Norms,
        Pairing as Pairing,
        Risk as Risk,
        RunCutting as RunCutting,
        Sequential as Sequential,
        Settings as Settings,
        Trial as Trial,
    )
    from .core.verdict.all_runs import join as join
    from .core.verdict.verdict_document import RunVerdict as RunVerdict, Verdict as Verdict
    from .drivers.settings import DriverSettings as DriverSettings
