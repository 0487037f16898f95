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

"""Writing of bags, whatever happens to the disk."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bag_writer': ('BagWriter', 'Rows'),
    'disk_sync': ('replace_file',),
    'recorder_losses': ('count_words', 'Counts', 'loss_record', 'loss_words', 'RECORDING',
                        'tell_missing'),
    'resilient_recording': ('Recording',),
    'spool': ('Spool',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bag_writer import BagWriter as BagWriter, Rows as Rows
    from .disk_sync import replace_file as replace_file
    from .recorder_losses import (
        count_words as count_words,
        Counts as Counts,
        loss_record as loss_record,
        loss_words as loss_words,
        RECORDING as RECORDING,
        tell_missing as tell_missing,
    )
    from .resilient_recording import Recording as Recording
    from .spool import Spool as Spool
