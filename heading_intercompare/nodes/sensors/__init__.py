# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The graph of several sensors: where its nodes are, and the work of the node that joins them."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'now_publisher': ('NowPublisher',),
    'pair_journals': ('PairJournals',),
    'places': ('called', 'choose_streams', 'count_subscribers', 'place_files', 'remap_rules'),
    'sensors_intake': ('SensorsIntake',),
    'sensors_reporting': ('SensorsReporting',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .now_publisher import NowPublisher as NowPublisher
    from .pair_journals import PairJournals as PairJournals
    from .places import (
        called as called,
        choose_streams as choose_streams,
        count_subscribers as count_subscribers,
        place_files as place_files,
        remap_rules as remap_rules,
    )
    from .sensors_intake import SensorsIntake as SensorsIntake
    from .sensors_reporting import SensorsReporting as SensorsReporting
