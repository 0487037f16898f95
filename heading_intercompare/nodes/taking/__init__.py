# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
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
