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

"""Time: the skew between the sensors, drifting clocks, and interpolation."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bracketing_readings': ('pairs_per_reading', 'readings_per_pair'),
    'clock_drift': ('ClockDrift', 'estimate_clock_drift'),
    'heading_track': ('Track',),
    'interpolation_error': ('estimate_interpolation_error', 'InterpolationError'),
    'realignment': ('realign',),
    'skew_instrument': ('common_tracks',),
    'skew_scan': ('Scan', 'scan_skew'),
    'skew_search': ('coarsen',),
    'stamp_steps': ('measure_stamp_steps', 'StampSteps'),
    'time_skew': ('estimate_skew', 'Skew'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bracketing_readings import (
        pairs_per_reading as pairs_per_reading,
        readings_per_pair as readings_per_pair,
    )
    from .clock_drift import ClockDrift as ClockDrift, estimate_clock_drift as estimate_clock_drift
    from .heading_track import Track as Track
    from .interpolation_error import (
        estimate_interpolation_error as estimate_interpolation_error,
        InterpolationError as InterpolationError,
    )
    from .realignment import realign as realign
    from .skew_instrument import common_tracks as common_tracks
    from .skew_scan import Scan as Scan, scan_skew as scan_skew
    from .skew_search import coarsen as coarsen
    from .stamp_steps import measure_stamp_steps as measure_stamp_steps, StampSteps as StampSteps
    from .time_skew import estimate_skew as estimate_skew, Skew as Skew
