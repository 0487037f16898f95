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

"""Reading whole bags: topics, headings, checks, origin, replay."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bag_check': ('BagCheck', 'check_bag'),
    'bag_files': ('find_files',),
    'bag_reader': ('Attachment', 'BagReader'),
    'bag_yaml': ('bag_metadata', 'list_parts', 'metadata_file', 'PartInfo', 'Qos', 'TopicRow'),
    'paced_replay': ('Replay',),
    'provenance': ('describe_origin', 'is_note', 'note_lines', 'NOTE_TOPIC', 'Notes',
                   'read_notes', 'read_texts', 'RECORD', 'REPORT_TOPIC', 'TRUTH_TOPIC'),
    'sequence_gaps': ('Numbering',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bag_check import BagCheck as BagCheck, check_bag as check_bag
    from .bag_files import find_files as find_files
    from .bag_reader import Attachment as Attachment, BagReader as BagReader
    from .bag_yaml import (
        bag_metadata as bag_metadata,
        list_parts as list_parts,
        metadata_file as metadata_file,
        PartInfo as PartInfo,
        Qos as Qos,
        TopicRow as TopicRow,
    )
    from .paced_replay import Replay as Replay
    from .provenance import (
        describe_origin as describe_origin,
        is_note as is_note,
        note_lines as note_lines,
        NOTE_TOPIC as NOTE_TOPIC,
        Notes as Notes,
        read_notes as read_notes,
        read_texts as read_texts,
        RECORD as RECORD,
        REPORT_TOPIC as REPORT_TOPIC,
        TRUTH_TOPIC as TRUTH_TOPIC,
    )
    from .sequence_gaps import Numbering as Numbering
