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

"""Simulated ships and heading sensors."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'faults': ('FAULTS',),
    'plans': ('Event', 'EVENTS', 'parse_events', 'parse_fixed'),
    'random_noise': ('Markov', 'open_stream'),
    'sensor_presets': ('errors_of',),
    'sensors': ('Readings',),
    'settings': ('Ahrs', 'Errors', 'Scenario', 'Sensor'),
    'simulator': ('SimulatedChunk', 'Simulation', 'Trial'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .faults import FAULTS as FAULTS
    from .plans import (
        Event as Event,
        EVENTS as EVENTS,
        parse_events as parse_events,
        parse_fixed as parse_fixed,
    )
    from .random_noise import Markov as Markov, open_stream as open_stream
    from .sensor_presets import errors_of as errors_of
    from .sensors import Readings as Readings
    from .settings import Ahrs as Ahrs, Errors as Errors, Scenario as Scenario, Sensor as Sensor
    from .simulator import (
        SimulatedChunk as SimulatedChunk,
        Simulation as Simulation,
        Trial as Trial,
    )
