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

"""
Ensembles of pairs as csv, in the columns that UHDAS users know.

They are the columns of `ens_hcorr.asc`, which UHDAS writes next to the data of a current profiler.
There `dh` is the heading of the reliable instrument, usually a gyro, minus that of the accurate
one. With these as TS and RS, `mean_dh` has the same sign.
"""

from __future__ import annotations

from datetime import datetime, timezone
import math
import os

from heading_intercompare.core.pairing.ensembles import Ensembles, Ensembling
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.utc_text import DAY_NS
from heading_intercompare.replaced_file import ReplacedFile

COLUMNS = ('dday', 'mean_hdg', 'last_hdg', 'mean_dh', 'std_dh', 'num', 'badflag')

_SECOND_NS = 1_000_000_000


def find_year(stamp_ns: int) -> int:
    """Return the beginning of the UTC year of a stamp; that of 1970 if no calendar reaches it."""
    try:
        year = datetime.fromtimestamp(stamp_ns // _SECOND_NS, timezone.utc).year
    except (OverflowError, OSError, ValueError):
        return 0
    return int(datetime(year, 1, 1, tzinfo=timezone.utc).timestamp()) * _SECOND_NS


def heading_cell(heading_deg: float) -> str:
    """Return a heading as text, below 360 even after rounding."""
    return 'nan' if math.isnan(heading_deg) else f'{round(heading_deg, 4) % 360.0:.4f}'


class EnsemblesCsvWriter:
    """
    Writes a csv of ensembles; an existing file is replaced.

    The columns:

    - `dday`: decimal day of the year of the last pair. Noon on 1 January is 0.5; the count
      continues from the year of the first pair.
    - `mean_hdg`, `last_hdg`: circular mean of the TS heading, and the last one.
    - `mean_dh`, `std_dh`: mean and standard deviation of TS - RS, installation offset not removed.
    - `num`: number of finite pairs.
    - `badflag`: see `std_limit_deg`.

    Angles are in degrees; a figure that does not exist is nan.

    Parameters
    ----------
    path
        The file.
    span_s
        Length of an ensemble, seconds.
    gap_s
        An ensemble ends at a longer silence, seconds.
    std_limit_deg
        `badflag` is 1 if `std_dh` is larger or `num` is below 2, and 0 otherwise.
    wrap_center_deg
        Centre of the range to which the differences are wrapped, degrees.

    Raises
    ------
    ValueError
        If the length is not allowed.
    OSError
        If the file cannot be written, here and in each method.

    """

    def __init__(self, path: str | os.PathLike[str], span_s: float, *, gap_s: float,
                 std_limit_deg: float, wrap_center_deg: float = 0.0) -> None:
        self._ensembling = Ensembling(span_s, gap_s, wrap_center_deg)
        self._limit_deg = std_limit_deg
        self._year_ns: int | None = None
        self._replaced = ReplacedFile(path)
        self._replaced.write((','.join(COLUMNS) + '\n').encode())

    def __enter__(self) -> 'EnsemblesCsvWriter':
        return self

    def __exit__(self, kind: type | None, *exception: object) -> None:
        self.close() if kind is None else self.discard()

    def write(self, pairs: Pairs) -> None:
        """Take pairs; append a row for each completed ensemble."""
        if self._year_ns is None and len(pairs):
            self._year_ns = find_year(int(pairs.stamp_ns[0]))
        self._append(self._ensembling.update(pairs))

    def _append(self, ensembles: Ensembles) -> None:
        good = (ensembles.num > 1) & (ensembles.std_deg <= self._limit_deg)
        columns = (ensembles.stamp_ns, ensembles.mean_ts_deg, ensembles.last_ts_deg,
                   ensembles.mean_deg, ensembles.std_deg, ensembles.num, ~good)
        for ns, mean_ts, last_ts, mean, std, num, bad in zip(*(c.tolist() for c in columns)):
            self._replaced.write(
                (f'{(ns - self._year_ns) / DAY_NS:.7f},{heading_cell(mean_ts)},'
                 f'{heading_cell(last_ts)},{mean:.4f},{std:.4f},{num},{bad:d}\n').encode())

    def close(self) -> None:
        """Append the last ensemble and put the file in its place; a second call does nothing."""
        if not self._replaced.file.closed:
            self._append(self._ensembling.finish())
            self._replaced.commit()

    def discard(self) -> None:
        """Leave the file as it was before."""
        self._replaced.discard()
