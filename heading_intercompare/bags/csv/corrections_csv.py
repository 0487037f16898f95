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
The correction of the heading as a time series in csv, for current profilers and survey programs.

A row is an ensemble of pairs, as UHDAS has them. The correction is C - O: it is added to the TS.
"""

from __future__ import annotations

import math
import os

import numpy as np

from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.pairing.ensembles import Ensembles, Ensembling
from heading_intercompare.core.records import Pairs, Reals
from heading_intercompare.core.statistics.blocking import student_95
from heading_intercompare.core.utc_text import DAY_NS, utc
from heading_intercompare.replaced_file import ReplacedFile

from .ensembles_csv import find_year, heading_cell

COLUMNS = ('dday', 'utc', 'mean_hdg', 'correction', 'u', 'num', 'flag', 'running', 'running_low',
           'running_high', 'running_num')
FEW_PAIRS, SCATTER, TURN = 1, 2, 4
"""The parts of the flag, which are added."""

_FEW = 0.5
#: The headings of an ensemble without a turn scatter by less than 5 degrees.
_LEAST_LENGTH = math.exp(-0.5 * math.radians(5.0) ** 2)
_LEAST = 3
_MOST_CORRELATED = 0.9


class CorrectionsCsvWriter:
    """
    Writes the corrections of the ensembles of a record; an existing file is replaced.

    The columns, angles in degrees; a figure that does not exist is nan:

    - `dday`, `utc`: time of the last pair; decimal day as in the csv of ensembles.
    - `mean_hdg`: circular mean of the TS heading.
    - `correction`: minus the mean of TS - RS, installation offset not removed.
    - `u`: standard uncertainty of this correction, by the scatter of the good ensembles within the
      running window.
    - `num`: number of finite pairs.
    - `flag`: 0 if good; otherwise the sum of 1 (fewer pairs than half of the usual number), 2 (the
      differences scatter by more than `std_limit_deg`) and 4 (a turn: the RS headings scatter by
      more than 5 degrees).
    - `running`, `running_low`, `running_high`: mean correction of the good ensembles within half a
      window before and after, and its 95 % interval, which allows for their correlation.
    - `running_num`: how many these are.

    Parameters
    ----------
    path
        The file.
    span_s
        Length of an ensemble, seconds.
    gap_s
        An ensemble ends at a longer silence, seconds.
    running_s
        The running window, seconds.
    std_limit_deg
        Largest standard deviation of the differences of a good ensemble, degrees.
    wrap_center_deg
        Centre of the range to which the differences are wrapped, degrees.

    Raises
    ------
    ValueError
        If a length is not allowed.
    OSError
        If the file cannot be written, here and in each method.

    """

    def __init__(self, path: str | os.PathLike[str], span_s: float, *, gap_s: float,
                 running_s: float, std_limit_deg: float, wrap_center_deg: float = 0.0) -> None:
        if not running_s >= span_s:
            raise ValueError(f'running window = {running_s!r} s: must be at least the length of '
                             f'an ensemble, {span_s:g}')
        self._ensembling = Ensembling(span_s, gap_s, wrap_center_deg)
        self._half_ns, self._limit_deg = round(0.5e9 * running_s), std_limit_deg
        self._ensembles: list[Ensembles] = []
        self._first_ns: int | None = None
        self._replaced = ReplacedFile(path)

    def write(self, pairs: Pairs) -> None:
        """Take pairs."""
        if self._first_ns is None and len(pairs):
            self._first_ns = int(pairs.stamp_ns[0])
        self._ensembles.append(self._ensembling.update(pairs))

    def close(self) -> None:
        """Write the rows and put the file in its place; a second call does nothing."""
        if self._replaced.file.closed:
            return
        ensembles = Ensembles.concatenate([*self._ensembles, self._ensembling.finish()])
        self._replaced.write((','.join(COLUMNS) + '\n').encode())
        flags = _flag(ensembles, self._limit_deg)
        year_ns = find_year(self._first_ns or 0)
        corrections: Reals = -wrap180(ensembles.mean_deg)
        running = _run(ensembles.stamp_ns, corrections, flags == 0, self._half_ns)
        columns = (ensembles.stamp_ns, ensembles.mean_ts_deg, corrections, ensembles.num, flags,
                   running)
        for ns, hdg, correction, num, flag, (u, mean, half, count) in zip(
                *(column.tolist() for column in columns)):
            self._replaced.write((
                f'{(ns - year_ns) / DAY_NS:.7f},{utc(ns)},{heading_cell(hdg)},'
                f'{correction:.4f},{u:.4f},{num},{flag},{mean:.4f},{mean - half:.4f},'
                f'{mean + half:.4f},{count:.0f}\n').encode())
        self._replaced.commit()

    def discard(self) -> None:
        """Leave the file as it was before."""
        self._replaced.discard()


def _flag(ensembles: Ensembles, limit_deg: float) -> np.ndarray:
    """Return the flag of each ensemble."""
    if not len(ensembles):
        return np.zeros(0, np.int64)
    few = (ensembles.num < 2) | (ensembles.num < _FEW * np.median(ensembles.num))
    flags: np.ndarray = (FEW_PAIRS * few + SCATTER * (ensembles.std_deg > limit_deg)
                         + TURN * (ensembles.rs_length < _LEAST_LENGTH))
    return flags


def _run(stamp_ns: np.ndarray, values: Reals, good: np.ndarray, half_ns: int) -> Reals:
    """Return scatter, mean, half of its 95 % interval and number of the good values about each."""
    good_ns, good_values = stamp_ns[good], values[good]
    first = np.searchsorted(good_ns, stamp_ns - half_ns)
    end = np.searchsorted(good_ns, stamp_ns + half_ns, side='right')
    rows: Reals = np.full((stamp_ns.size, 4), np.nan)
    for row, lo, hi in zip(rows, first.tolist(), end.tolist()):
        row[3] = hi - lo
        if hi > lo:
            row[1] = good_values[lo:hi].mean()
        if hi - lo >= _LEAST:
            row[0] = good_values[lo:hi].std(ddof=1)
    worth = rows[:, 3] * _worth_of_each(good_values - rows[good, 1])
    for row, number in zip(rows, worth.tolist()):
        if number >= _LEAST:
            row[2] = student_95(number - 1.0) * row[0] / np.sqrt(number)
    return rows


def _worth_of_each(rest: Reals) -> float:
    """Return how many independent values one is worth, by the correlation of neighbours."""
    power = float(rest @ rest)
    r = float(rest[1:] @ rest[:-1]) / power if power > 0.0 else 0.0
    r = min(_MOST_CORRELATED, max(0.0, r))
    return (1.0 - r) / (1.0 + r)
