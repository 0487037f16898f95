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

"""What the stream of one sensor shows by itself, before its readings are paired."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'decimal_steps': ('DECIMAL_STEPS', 'find_decimal_step', 'StepCount'),
    'held_values': ('HoldFilter', 'Unfolded'),
    'sequence_match': ('Matched', 'SequenceMatch'),
    'stamp_jumps': ('is_rising', 'JumpFilter', 'SetBack'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .decimal_steps import (
        DECIMAL_STEPS as DECIMAL_STEPS,
        find_decimal_step as find_decimal_step,
        StepCount as StepCount,
    )
    from .held_values import HoldFilter as HoldFilter, Unfolded as Unfolded
    from .sequence_match import Matched as Matched, SequenceMatch as SequenceMatch
    from .stamp_jumps import is_rising as is_rising, JumpFilter as JumpFilter, SetBack as SetBack
