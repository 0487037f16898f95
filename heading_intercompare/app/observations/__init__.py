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

"""A table of observations against the readings of one sensor: corrections and decision."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'observation_table': ('ObservationTable', 'read_observation_table'),
    'observed_sensor': ('observe', 'Observed', 'Uncertainties'),
    'targets': ('parse_position', 'Target'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .observation_table import (
        ObservationTable as ObservationTable,
        read_observation_table as read_observation_table,
    )
    from .observed_sensor import (
        observe as observe,
        Observed as Observed,
        Uncertainties as Uncertainties,
    )
    from .targets import parse_position as parse_position, Target as Target
