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

"""What both sensors say of their readings during the run in progress."""

from __future__ import annotations

from typing import Callable

import numpy as np

from heading_intercompare.core.records import Quality

from .growing_columns import Column, Keep

KEPT_BEFORE_NS = 1800 * 10 ** 9
"""What came beside the readings stays from up to this time before a run: pairs may come later."""


class RunQuality:
    """
    The quality that the judging of runs needs, and no more.

    Parameters
    ----------
    keeper
        Returns the store for the pages of a record, or None; as for `Compliance`.

    """

    def __init__(self, keeper: Callable[[], Keep | None] = lambda: None) -> None:
        self._keeper = keeper
        self._columns: dict[str, list[Column]] = {}
        self._oldest_ns: dict[str, int] = {}

    def take(self, stream: str, quality: Quality) -> None:
        """Take rows of ``'ts'`` or ``'rs'``, in any order; a row may come twice."""
        if not len(quality):
            return
        if stream not in self._columns:
            keep = self._keeper()
            self._columns[stream] = [Column(kind, keep) for kind in (
                np.int64, np.float64, np.int64)]
            self._oldest_ns.setdefault(stream, int(quality.stamp_ns.min()))
        for column, name in zip(self._columns[stream], Quality.__slots__):
            column.append(getattr(quality, name))

    def by_stream(self) -> dict[str, Quality]:
        """Return the rows of each sensor that says something; valid until the next `take`."""
        return {stream: Quality(*(column.values for column in columns))
                for stream, columns in self._columns.items()}

    def forget(self, run_start_ns: int | None) -> None:
        """
        Forget what is older than any run to come, or than the run in progress.

        The newest of the old rows stays: a sensor says nothing while nothing changes.
        """
        for stream, (stamps, *_) in [*self._columns.items()]:
            since_ns = int(stamps.last) if run_start_ns is None else run_start_ns
            if self._oldest_ns[stream] >= since_ns - 2 * KEPT_BEFORE_NS:
                continue
            self._oldest_ns[stream] = since_ns - KEPT_BEFORE_NS
            rows = self.by_stream()[stream]
            rows = rows[np.argsort(rows.stamp_ns, kind='stable')]
            n_old = int(np.searchsorted(rows.stamp_ns, self._oldest_ns[stream]))
            if n_old > 1:
                del self._columns[stream]
                self.take(stream, rows[n_old - 1:])
