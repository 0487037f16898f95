# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""MCAP files: records, chunks and indexes, read and written."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'checksum': ('crc32',),
    'chunk_runs': ('Chunk', 'ChunkRun', 'ChunkRuns', 'count_messages', 'Counts', 'read_records'),
    'chunk_writer': ('ChunkWriter', 'COMPRESSIONS'),
    'chunks': ('CHUNK_HEAD',),
    'fragments': ('BARE', 'CHUNK_BYTES', 'ChunkHead', 'decompress_begun', 'find_candidates',
                  'find_chunk_head', 'HEAD_BYTES', 'measure_leading', 'MESSAGE_LEAST'),
    'index_records': ('message_index',),
    'mcap_file': ('mcap_files', 'NeverBegun', 'Part', 'Stretch'),
    'message_batch': ('Records', 'Rows'),
    'message_blocks': ('Block', 'block_of', 'ENTRY_BYTES', 'HEAD', 'INDEX_LEAST',
                       'MESSAGE_HEAD', 'Record'),
    'record_stream': ('MAGIC', 'parse_record', 'RecordStream'),
    'record_validity': ('find_attached', 'is_disguised', 'is_formed', 'SMALL'),
})
