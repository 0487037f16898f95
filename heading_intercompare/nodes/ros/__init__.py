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

"""The ROS side of the nodes: message types, parameters, quality of service, processes."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'batches': ('take_all', 'Unwatched'),
    'message_types': ('HEADING_TYPES', 'MOTION_TYPES', 'PAIRS_TYPES', 'STATUS_TYPES', 'TEXT_TYPES',
                      'TRUTH_TYPES'),
    'parameters': ('declare', 'make_overrides', 'OVERRIDES', 'resolve_topic'),
    'process': ('end', 'run', 'spin_nodes', 'Stop'),
    'qos': ('NOTE', 'STATUS'),
    'remapping': ('published_names',),
    'steady_timer': ('every',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .batches import take_all as take_all, Unwatched as Unwatched
    from .message_types import (
        HEADING_TYPES as HEADING_TYPES,
        MOTION_TYPES as MOTION_TYPES,
        PAIRS_TYPES as PAIRS_TYPES,
        STATUS_TYPES as STATUS_TYPES,
        TEXT_TYPES as TEXT_TYPES,
        TRUTH_TYPES as TRUTH_TYPES,
    )
    from .parameters import (
        declare as declare,
        make_overrides as make_overrides,
        OVERRIDES as OVERRIDES,
        resolve_topic as resolve_topic,
    )
    from .process import end as end, run as run, spin_nodes as spin_nodes, Stop as Stop
    from .qos import NOTE as NOTE, STATUS as STATUS
    from .remapping import published_names as published_names
    from .steady_timer import every as every
