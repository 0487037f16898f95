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

"""The registry of readers: which files can be read, and their headings by stream."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'errors': ('ReaderError',),
    'registry': ('find_format', 'FORMATS', 'open_recording'),
    'stream_recording': ('StreamRecording',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .errors import ReaderError as ReaderError
    from .registry import (
        find_format as find_format,
        FORMATS as FORMATS,
        open_recording as open_recording,
    )
    from .stream_recording import StreamRecording as StreamRecording
