# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Ensembles of pairs as comma-separated values, in the columns that UHDAS users know.

They are those of `ens_hcorr.asc`, which UHDAS writes beside the data of a current profiler: there
`dh` is the heading of the reliable instrument, usually a gyro, minus that of the accurate one.
With these as TS and RS, `mean_dh` has the same sign.
"""

from __future__ import annotations

from datetime import datetime, timezone
import math
import os

from heading_intercompare.core.pairing.ensembles import Ensembles, Ensembling
from heading_intercompare.core.records import Pairs

__all__ = ['COLUMNS', 'EnsemblesCsvWriter']

COLUMNS = ('dday', 'mean_hdg', 'last_hdg', 'mean_dh', 'std_dh', 'num', 'badflag')

_SECOND_NS = 1_000_000_000
_DAY_NS = 86400 * _SECOND_NS


def _year_ns(stamp_ns: int) -> int:
    """Return the beginning of the UTC year of a stamp; of 1970 where no calendar reaches."""
    try:
        year = datetime.fromtimestamp(stamp_ns // _SECOND_NS, timezone.utc).year
    except (OverflowError, OSError, ValueError):
        return 0
    return int(datetime(year, 1, 1, tzinfo=timezone.utc).timestamp()) * _SECOND_NS


def _heading(heading_deg: float) -> str:
    """Return a heading, below 360 also when it is rounded."""
    return 'nan' if math.isnan(heading_deg) else f'{round(heading_deg, 4) % 360.0:.4f}'


class EnsemblesCsvWriter:
    """
    A csv of ensembles being written; an existing file is replaced.

    The columns are `dday`, day of the year with decimals at the last pair (noon on 1 January is
    0.5; counted on from the year of the first pair); `mean_hdg`, circular mean of the TS heading;
    `last_hdg`, the last one; `mean_dh` and `std_dh`, mean and standard deviation of TS - RS,
    installation offset not removed; `num`, finite pairs; `badflag`. Angles are in degrees; a
    figure that does not exist is nan.

    Parameters
    ----------
    path : str or path
        The file.
    span_s : float
        Length of an ensemble, seconds.
    gap_s : float
        No ensemble reaches across a longer silence, seconds.
    std_limit_deg : float
        `badflag` is 1 if `std_dh` is larger, or if `num` is below 2; else 0.
    wrap_center_deg : float
        Middle of the range to which the differences are reduced, degrees.

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
        self._file = open(path, 'w', encoding='ascii', newline='')
        self._file.write(','.join(COLUMNS) + '\n')

    def __enter__(self) -> 'EnsemblesCsvWriter':
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def write(self, pairs: Pairs) -> None:
        """Take pairs; append a row for each ensemble that is complete."""
        if self._year_ns is None and len(pairs):
            self._year_ns = _year_ns(int(pairs.stamp_ns[0]))
        self._append(self._ensembling.update(pairs))

    def _append(self, ensembles: Ensembles) -> None:
        good = (ensembles.num > 1) & (ensembles.std_deg <= self._limit_deg)
        columns = (ensembles.stamp_ns, ensembles.mean_ts_deg, ensembles.last_ts_deg,
                   ensembles.mean_deg, ensembles.std_deg, ensembles.num, ~good)
        for ns, mean_ts, last_ts, mean, std, num, bad in zip(*(c.tolist() for c in columns)):
            self._file.write(f'{(ns - self._year_ns) / _DAY_NS:.7f},{_heading(mean_ts)},'
                             f'{_heading(last_ts)},{mean:.4f},{std:.4f},{num},{bad:d}\n')

    def close(self) -> None:
        """Append the last ensemble and close the file; a second time does nothing."""
        if not self._file.closed:
            with self._file:
                self._append(self._ensembling.finish())
