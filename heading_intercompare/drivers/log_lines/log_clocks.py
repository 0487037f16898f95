# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What tells the time of the lines of one log: its days, the stamps of lines, and sentences."""

from __future__ import annotations

from heading_intercompare.drivers.settings import DriverSettings

from .days import Days
from .line_stamps import find_date_order, LineStamps, read_offset
from .log_files import LogFiles
from .stream_times import find_first_time, find_kind, TIME_SENTENCES

__all__ = ['choose_time_sentences', 'start_stamps']


def start_stamps(settings: DriverSettings, files: LogFiles | None = None, *,
                 of_log: bool = True) -> tuple[Days, LineStamps]:
    """
    Return what reads the stamps of lines, from the first line on.

    Parameters
    ----------
    settings : DriverSettings
        With the form of the stamps, and the date of a log without one.
    files : LogFiles, optional
        The log, which is searched if its stamps do not say it; none for a live stream.
    of_log : bool
        As for `LineStamps`.

    """
    zone = None if settings.stamp_zone is None else read_offset(settings.stamp_zone)
    if files is None:
        days = Days(settings.date, zone=zone)
        return days, LineStamps(settings, days)
    days = Days(settings.date, lambda: find_first_time(files.bare_blocks()), zone)
    return days, LineStamps(settings, days, lambda: find_date_order(files.bare_blocks()),
                            of_log=of_log)


def choose_time_sentences(files: LogFiles | None, validity: bool) -> tuple[str, ...]:
    """Return the kinds of sentences that tell the time of validity; of a log the one it has."""
    kind = find_kind(files.bare_blocks()) if validity and files is not None else None
    return TIME_SENTENCES if kind is None else (kind,)
