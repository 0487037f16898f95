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

"""Several heading sensors of one ship: all pairs of them, and which sensor is wrong."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'compare_sensors': ('find_sensor_differences',),
    'comparison': ('SensorsComparison',),
    'judging': ('judge_sensors',),
    'sensors_verdict': ('SensorsVerdict',),
    'variance_split': ('PairVariance', 'SensorVariance', 'split_variances'),
    'vote': ('find_wrong', 'Vote'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .compare_sensors import find_sensor_differences as find_sensor_differences
    from .comparison import SensorsComparison as SensorsComparison
    from .judging import judge_sensors as judge_sensors
    from .sensors_verdict import SensorsVerdict as SensorsVerdict
    from .variance_split import (
        PairVariance as PairVariance,
        SensorVariance as SensorVariance,
        split_variances as split_variances,
    )
    from .vote import find_wrong as find_wrong, Vote as Vote
