# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bags written, whatever happens to the disk."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bag_writer': ('BagWriter', 'Rows'),
    'disk_sync': ('replace_file',),
    'recorder_losses': ('count_words', 'Counts', 'loss_record', 'loss_words', 'RECORDING',
                        'tell_missing'),
    'resilient_recording': ('Recording',),
    'spool': ('Spool',),
})
