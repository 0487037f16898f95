# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whole bags read: topics, headings, checks, origin, replay."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bag_check': ('BagCheck', 'check_bag'),
    'bag_reader': ('Attachment', 'BagReader'),
    'bag_yaml': ('bag_metadata', 'find_absent_parts', 'metadata_file', 'PartInfo', 'Qos',
                 'TopicRow'),
    'paced_replay': ('Replay',),
    'provenance': ('describe_origin', 'is_note', 'note_lines', 'NOTE_TOPIC', 'Notes',
                   'read_notes', 'read_texts', 'RECORD', 'REPORT_TOPIC', 'TRUTH_TOPIC'),
    'sequence_gaps': ('Numbering',),
})
