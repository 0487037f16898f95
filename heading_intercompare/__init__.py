# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Decide, from recorded data, whether a heading sensor meets its accuracy norm.

A tested sensor (TS) is compared with a reference sensor (RS) of the same ship. Start with
`analyze_bag` for a recording, `analyze` for arrays; the settings are those of the configuration
file, by name.
"""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door
from heading_intercompare.core.version import VERSION as __version__

if TYPE_CHECKING:
    # What follows, for who completes names without running anything.
    from heading_intercompare.app.analysis import (  # noqa: F401
        analyze_bag,
        analyze_bags,
        judge_bags,
    )
    from heading_intercompare.bags.rosbag2.bag_reader import BagReader  # noqa: F401
    from heading_intercompare.core.diagnostics.three_cornered_hat import (  # noqa: F401
        three_cornered_hat,
    )
    from heading_intercompare.core.offline import analyze  # noqa: F401
    from heading_intercompare.core.outcome import Outcome  # noqa: F401
    from heading_intercompare.core.pairing.pairer import pair, Pairer  # noqa: F401
    from heading_intercompare.core.pipeline import Compliance, Intercomparison, join  # noqa: F401
    from heading_intercompare.core.records import Differences, Headings, Pairs  # noqa: F401
    from heading_intercompare.core.settings import (  # noqa: F401
        Alignment,
        CampaignRule,
        Detectors,
        Norms,
        Pairing,
        Risk,
        RunCutting,
        Sequential,
        Settings,
        SettingsError,
    )
    from heading_intercompare.core.verdict.verdict_document import (  # noqa: F401
        RunVerdict,
        Verdict,
    )

__getattr__, __dir__, __all__ = door(__name__, {
    'app.analysis': ('analyze_bag', 'analyze_bags', 'judge_bags'),
    'bags.rosbag2.bag_reader': ('BagReader',),
    'core.diagnostics.three_cornered_hat': ('three_cornered_hat',),
    'core.offline': ('analyze',),
    'core.outcome': ('Outcome',),
    'core.pairing.pairer': ('pair', 'Pairer'),
    'core.pipeline': ('Compliance', 'Intercomparison', 'join'),
    'core.records': ('Differences', 'Headings', 'Pairs'),
    'core.settings': ('Alignment', 'CampaignRule', 'Detectors', 'Norms', 'Pairing', 'Risk',
                      'RunCutting', 'Sequential', 'Settings', 'SettingsError'),
    'core.verdict.verdict_document': ('RunVerdict', 'Verdict'),
})
__all__ += ['__version__']
