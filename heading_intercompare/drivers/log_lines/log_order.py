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

"""Which files of a folder are logs, and their order in time."""

from __future__ import annotations

import re

from heading_intercompare.drivers.framing import split
from heading_intercompare.drivers.sentences import Rejected
from heading_intercompare.drivers.settings import DriverError, DriverSettings

from .days import Days
from .line_stamps import find_date_order, LineStamps
from .log_files import head_of, is_several, LogFiles

_MCAP = b'\x89MCAP'
_SENTENCE = re.compile(rb'[$!](?:[A-Z]{2}|[0-9A-Z]{2}[A-Z]{3})[A-Z0-9]*,'
                       rb'|[#%][A-Z][A-Z0-9]*A,[^;*\r\n]*;')


def holds_sentences(path: str) -> bool:
    """Tell whether the beginning of a file has a sentence; an MCAP file has none."""
    head = head_of(path)
    return not head.startswith(_MCAP) and _SENTENCE.search(head) is not None


def open_log(path: str, settings: DriverSettings) -> LogFiles:
    """
    Return the files of a log: of a folder or a pattern those with sentences, in order of time.

    The first stamp of each file decides. If one has none, the names do.

    Raises
    ------
    OSError
        If a folder or a file in it cannot be read.
    DriverError
        If no file of a folder or a pattern has a sentence.

    """
    files = LogFiles(path)
    if not is_several(path):
        return files
    days = Days(settings.date)
    stamps = LineStamps(settings, days, lambda: find_date_order(files.bare_blocks()))

    def first_ns(name: str) -> int | None:
        stamps.begin_file(name)
        for line in head_of(name).split(b'\n'):
            prefix, _, suffix = split(line) or (line, b'', b'')
            try:
                ns = stamps.own_ns(prefix, suffix)
            except Rejected:
                continue
            if ns is not None:
                return ns if not stamps.by_clock or 'name' in days.origin else None
        return None
    files.keep(holds_sentences, first_ns)
    if not files.paths:
        raise DriverError(f'{path}: no file in it has an NMEA sentence')
    return files
