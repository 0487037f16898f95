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

"""MCAP files: reading and writing of records, chunks and indexes."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'checksum': ('crc32',),
    'chunk_runs': ('Chunk', 'ChunkRun', 'ChunkRuns', 'count_messages', 'Counts'),
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

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .checksum import crc32 as crc32
    from .chunk_runs import (
        Chunk as Chunk,
        ChunkRun as ChunkRun,
        ChunkRuns as ChunkRuns,
        count_messages as count_messages,
        Counts as Counts,
    )
    from .chunk_writer import ChunkWriter as ChunkWriter, COMPRESSIONS as COMPRESSIONS
    from .chunks import CHUNK_HEAD as CHUNK_HEAD
    from .fragments import (
        BARE as BARE,
        CHUNK_BYTES as CHUNK_BYTES,
        ChunkHead as ChunkHead,
        decompress_begun as decompress_begun,
        find_candidates as find_candidates,
        find_chunk_head as find_chunk_head,
        HEAD_BYTES as HEAD_BYTES,
        measure_leading as measure_leading,
        MESSAGE_LEAST as MESSAGE_LEAST,
    )
    from .index_records import message_index as message_index
    from .mcap_file import (
        mcap_files as mcap_files,
        NeverBegun as NeverBegun,
        Part as Part,
        Stretch as Stretch,
    )
    from .message_batch import Records as Records, Rows as Rows
    from .message_blocks import (
        Block as Block,
        block_of as block_of,
        ENTRY_BYTES as ENTRY_BYTES,
        HEAD as HEAD,
        INDEX_LEAST as INDEX_LEAST,
        MESSAGE_HEAD as MESSAGE_HEAD,
        Record as Record,
    )
    from .record_stream import (
        MAGIC as MAGIC,
        parse_record as parse_record,
        RecordStream as RecordStream,
    )
    from .record_validity import (
        find_attached as find_attached,
        is_disguised as is_disguised,
        is_formed as is_formed,
        SMALL as SMALL,
    )
