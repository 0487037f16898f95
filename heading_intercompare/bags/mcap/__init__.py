# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""MCAP files: records, chunks and indexes, read and written."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'checksum': ('crc32',),
    'chunk_runs': ('Chunk', 'ChunkRun', 'ChunkRuns', 'counted', 'Counts', 'records_of'),
    'chunk_writer': ('ChunkWriter', 'COMPRESSIONS'),
    'chunks': ('CHUNK_HEAD',),
    'fragments': ('BARE', 'begun', 'candidates', 'CHUNK_BYTES', 'chunk_head', 'ChunkHead',
                  'HEAD_BYTES', 'leading', 'MESSAGE_LEAST'),
    'index_records': ('message_index',),
    'mcap_file': ('mcap_files', 'NeverBegun', 'Part', 'Stretch'),
    'message_batch': ('Records', 'Rows'),
    'message_blocks': ('Block', 'block_of', 'ENTRY_BYTES', 'gathered', 'HEAD', 'INDEX_LEAST',
                       'MESSAGE_HEAD', 'Record'),
    'record_stream': ('MAGIC', 'parsed', 'RecordStream'),
    'record_validity': ('attached', 'disguised', 'formed', 'SMALL'),
})
