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

"""The motion of the ship during the run in progress: it grows for hours, and forgets."""

from __future__ import annotations

from typing import Callable, Mapping

import numpy as np

from heading_intercompare.core.records import Motion, MOTION_COLUMNS
from heading_intercompare.core.runs.growing_columns import Column, Keep
from heading_intercompare.core.runs.run_quality import KEPT_BEFORE_NS


class MotionRecord:
    """
    Rows of motion in any order, by what they tell: a row takes 24 bytes, or 16 for a rate.

    Parameters
    ----------
    keep
        Stores full pages, so that memory does not grow (see `Column`).

    Attributes
    ----------
    oldest_ns, newest_ns
        The smallest and the largest stamp; None without rows.

    """

    def __init__(self, keep: Keep | None = None) -> None:
        self._keep = keep
        self._columns: dict[str, dict[str, Column]] = {}
        self.oldest_ns: int | None = None
        self.newest_ns: int | None = None

    def __len__(self) -> int:
        return sum(len(columns['stamp_ns']) for columns in self._columns.values())

    def take(self, motion: Motion) -> None:
        """Add rows."""
        if not len(motion):
            return
        for what, rows in motion.split().items():
            if len(rows):
                for name, column in self._columns_of(what).items():
                    column.append(getattr(rows, name))
        first, last = int(motion.stamp_ns.min()), int(motion.stamp_ns.max())
        self.oldest_ns = first if self.oldest_ns is None else min(self.oldest_ns, first)
        self.newest_ns = last if self.newest_ns is None else max(self.newest_ns, last)

    def _columns_of(self, what: str) -> dict[str, Column]:
        if what not in self._columns:
            self._columns[what] = {
                'stamp_ns': Column(np.int64, self._keep),
                **{name: Column(np.float64, self._keep) for name in MOTION_COLUMNS[what]}}
        return self._columns[what]

    def by_thing(self) -> dict[str, Motion]:
        """Return the rows by what they tell, as they came; valid until the next `take`."""
        return {what: Motion.of(what, *[column.values for column in columns.values()])
                for what, columns in self._columns.items()}

    def after(self, stamp_ns: int, keep: Keep | None = None) -> 'MotionRecord':
        """Return a record of the rows after a stamp; this record stays as it is."""
        left = MotionRecord(keep)
        for rows in self.by_thing().values():
            left.take(rows[rows.stamp_ns > stamp_ns])
        return left


class RunMotion:
    """
    The motion that the judging of runs needs, and no more.

    Parameters
    ----------
    keeper
        Returns the store for the pages of a record, or None; as for `Compliance`.

    Attributes
    ----------
    late : int
        Rows that came after their run was judged, and are not used.

    """

    def __init__(self, keeper: Callable[[], Keep | None] = lambda: None) -> None:
        self._keeper = keeper
        self._record: MotionRecord | None = None
        self._judged_ns: int | None = None
        self._repeats = False
        self.late = 0

    def take(self, motion: Motion) -> None:
        """Take rows in any order."""
        if self._judged_ns is not None:
            late = motion.stamp_ns <= self._judged_ns
            self.late += 0 if self._repeats else int(np.count_nonzero(late))
            motion = motion[~late]
        if len(motion):
            if self._record is None:
                self._record = MotionRecord(self._keeper())
            self._record.take(motion)

    def by_thing(self) -> dict[str, Motion] | None:
        """Return the rows after the last judged run, by what they tell; None if none ever came."""
        return None if self._record is None else self._record.by_thing()

    @property
    def rows(self) -> Motion | None:
        """Return these rows as one chunk."""
        things = self.by_thing()
        return None if things is None else Motion.concatenate(things.values())

    def end_run(self, end_ns: int) -> None:
        """Forget what belongs to a run that was judged, given the stamp of its last pair."""
        self._judged_ns = max(end_ns, self._judged_ns or 0)
        if self._record is not None:
            self._record = self._record.after(end_ns, self._keeper())

    def begin_segment(self) -> None:
        """Go on after a clock was set back: rows of times that were judged say nothing more."""
        self._repeats = True

    def forget(self, run_start_ns: int | None) -> None:
        """Forget what is older than any run to come, or than the run in progress."""
        record = self._record
        if record is None or record.newest_ns is None or record.oldest_ns is None:
            return
        since_ns = record.newest_ns if run_start_ns is None else run_start_ns
        if record.oldest_ns < since_ns - 2 * KEPT_BEFORE_NS:
            self._record = record.after(since_ns - KEPT_BEFORE_NS, self._keeper())


def find_newest(motion: Motion) -> dict[str, int]:
    """
    Return the newest stamp of each thing that motion tells.

    Examples
    --------
    >>> find_newest(Motion.of_rates([3, 5], [0.1, 0.2]))
    {'rate': 5}

    """
    return {what: int(rows.stamp_ns.max()) for what, rows in motion.split().items() if len(rows)}


def leave_out_known(motion: Motion, newest_ns: Mapping[str, int]) -> Motion:
    """
    Return the rows after the newest stamps of what is known already.

    Parameters
    ----------
    motion
        In any order.
    newest_ns
        Of `find_newest`.

    Notes
    -----
    A publisher sends its newest messages again to a new subscription. So a node that was started
    again gets some rows for a second time.

    """
    is_known = np.zeros(len(motion), bool)
    for what, column in (('fix', motion.latitude_deg), ('velocity', motion.east_m_s),
                         ('rate', motion.rate_deg_s)):
        if what in newest_ns:
            is_known |= np.isfinite(column) & (motion.stamp_ns <= newest_ns[what])
    return motion[~is_known]
