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

"""What comes into a node: each message once, in batches, with a count of what is missing."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'headings_intake': ('HeadingsIntake',),
    'intake': ('Intake',),
    'motion_intake': ('make_motion_intake', 'MotionIntake'),
    'raw_subscription': ('subscribe',),
    'recorded_topics': ('make_intakes', 'report_files', 'text_of'),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .headings_intake import HeadingsIntake as HeadingsIntake
    from .intake import Intake as Intake
    from .motion_intake import (
        make_motion_intake as make_motion_intake,
        MotionIntake as MotionIntake,
    )
    from .raw_subscription import subscribe as subscribe
    from .recorded_topics import (
        make_intakes as make_intakes,
        report_files as report_files,
        text_of as text_of,
    )
