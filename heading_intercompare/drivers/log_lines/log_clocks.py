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

"""What tells the time of the lines of one log: its days, the stamps of lines, and sentences."""

from __future__ import annotations

from datetime import tzinfo
from typing import Callable, Iterable

from heading_intercompare.drivers.settings import DriverSettings

from .days import Days
from .line_stamps import find_date_order, LineStamps, read_offset
from .log_files import LogFiles
from .stream_times import find_first_time, find_kind, TIME_SENTENCES


def start_stamps(settings: DriverSettings, files: LogFiles | None = None, *,
                 of_log: bool = True) -> tuple[Days, LineStamps]:
    """
    Return what reads the stamps of lines, from the first line on.

    Parameters
    ----------
    settings
        With the form of the stamps, and the date of a log without one.
    files
        The log, which is searched if its stamps do not say it; none for a live stream.
    of_log
        As for `LineStamps`.

    """
    if files is None:
        days = Days(settings.date, zone=_read_zone(settings))
        return days, LineStamps(settings, days)
    days = Days(settings.date, lambda: find_first_time(files.bare_blocks()), _read_zone(settings))
    return days, LineStamps(settings, days, lambda: find_date_order(files.bare_blocks()),
                            of_log=of_log)


def start_stamps_of_file(settings: DriverSettings, path: str,
                         texts: Callable[[], Iterable[bytes]] = lambda: (),
                         ) -> tuple[Days, LineStamps]:
    """
    Return what reads the stamps of a file of another program, such as the cells of a table.

    Parameters
    ----------
    settings
        With the form of the stamps, and the date of a file without one.
    path
        The file, whose name may tell the date.
    texts
        Returns all its stamps, which may tell whether the day or the month comes first.

    """
    days = Days(settings.date, zone=_read_zone(settings))
    days.begin_file(path)
    return days, LineStamps(settings, days, lambda: find_date_order(texts()))


def _read_zone(settings: DriverSettings) -> tzinfo | None:
    return None if settings.stamp_zone is None else read_offset(settings.stamp_zone)


def choose_time_sentences(files: LogFiles | None, settings: DriverSettings) -> tuple[str, ...]:
    """Return the kinds of sentences that tell the time of validity; of a log the one it has."""
    kind = (None if files is None or settings.time != 'validity' else
            find_kind(files.bare_blocks(), settings.checksum == 'if_present'))
    return TIME_SENTENCES if kind is None else (kind,)
