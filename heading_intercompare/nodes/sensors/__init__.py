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
