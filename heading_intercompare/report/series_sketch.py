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

"""A summary of the pairs for the figures of a report, collected in bounded memory."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Integers, Motion, Pairs, Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.time_rules.exclusions import find_excluded, read_exclusions

from .sketching.bins import Bins, Envelope, Histogram
from .sketching.shift_scan import ShiftScan
from .sketching.spectra import Spectra
from .sketching.track import Track
from .sketching.turning import Turning

HEADING_BINS = 144


class SeriesSketch:
    """
    The differences of one input, summarised in bounded memory by time, size and heading.

    Parameters
    ----------
    source
        Name of the input, as in the runs of the verdict.
    segment
        How often a clock was set back before.

    Attributes
    ----------
    n, n_invalid, n_taken_out : int
        Finite differences; pairs left out because they are not finite, or by hand.
    time, rs_time : Envelope
        At most 1000 bins of time: of the differences, and of the RS heading, unwrapped. Only they
        hold what is taken out by hand.
    histogram : Histogram
    heading : Bins
        144 bins of 2.5 degrees of the RS heading, from 0.
    turning : Turning
        The differences against the rate of turn.
    track : Track
        At most 4096 positions.
    shifts
        The scatter at shifts of the RS; None before the first pair.
    spectra
        Spectrum and autocorrelation; None before the first pair.
    offset_deg : float
        The installation offset, which is removed from the differences.

    Notes
    -----
    All pairs count, including those of the stabilisation period. The memory is some 3 MB, however
    many pairs come, but for rates of turn until their pairs come. Counts, extremes and bin widths
    do not depend on the chunks; means and deviations depend on them only by rounding.

    """

    def __init__(self, source: str = '', segment: int = 0) -> None:
        self.source, self.segment = source, segment
        self.n = self.n_invalid = self.n_taken_out = 0
        self.newest_ns: int | None = None
        self.time = Envelope()
        self.histogram = Histogram()
        self.heading = Bins.of(HEADING_BINS, np.zeros(0, np.int64), np.zeros(0))
        self.rs_time = Envelope()
        self.turning = Turning()
        self.track = Track()
        self.shifts: ShiftScan | None = None
        self.spectra: Spectra | None = None
        self.offset_deg = 0.0
        self._turns = 0
        self._rs_deg: float | None = None

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship, before the pairs of the same time."""
        self.track.update(motion)
        self.turning.take_rates(motion.rates())

    def update(self, pairs: Pairs, settings: Settings) -> None:
        """
        Take pairs in stamp order.

        Parameters
        ----------
        pairs
            n >= 0.
        settings
            The installation offset and the wrap centre are used, as in the analysis.

        Raises
        ------
        ValueError
            If the stamps go back.

        References
        ----------
        GK (1).

        """
        if not len(pairs):
            return
        newest = self.newest_ns if self.newest_ns is not None else int(pairs.stamp_ns[0])
        if int(pairs.stamp_ns[0]) < newest or np.any(np.diff(pairs.stamp_ns) < 0):
            raise ValueError(f'stamp_ns goes back before {newest}: pairs must come in stamp order')
        self.newest_ns = int(pairs.stamp_ns[-1])
        x = subtract(pairs, settings.installation_offset_deg, settings.wrap_center_deg).x_deg
        good = np.isfinite(x)
        x, n = x[good], int(np.count_nonzero(good))
        self.n_invalid += len(pairs) - n
        stamps, rs = pairs.stamp_ns[good], wrap360(pairs.rs_deg[good])
        self.time.update(stamps, x)
        line = self._unwrap(rs)
        self.rs_time.update(stamps, line)
        included = find_excluded(stamps, read_exclusions(settings.exclusions)) < 0
        self.n_taken_out += n - int(np.count_nonzero(included))
        self._take_kept(stamps[included], x[included], line[included], settings)

    def _unwrap(self, rs_deg: Reals) -> Reals:
        """Return the RS headings without their jumps at north."""
        if not len(rs_deg):
            return rs_deg
        before = float(rs_deg[0]) if self._rs_deg is None else self._rs_deg
        steps = np.diff(rs_deg, prepend=before)
        turns = self._turns + np.cumsum((steps < -180.0).astype(np.int64) - (steps >= 180.0))
        self._turns, self._rs_deg = int(turns[-1]), float(rs_deg[-1])
        line: Reals = rs_deg + 360.0 * turns
        return line

    def _take_kept(self, stamp_ns: Integers, x_deg: Reals, line_deg: Reals,
                   settings: Settings) -> None:
        """Take what is not taken out by hand."""
        if self.shifts is None or self.spectra is None:
            self.shifts = ShiftScan(settings.alignment.skew_range_s,
                                    settings.pairing.longest_gap_s)
            self.spectra = Spectra(settings.runs.gap_s)
            self.offset_deg = settings.installation_offset_deg
        self.n += len(x_deg)
        self.histogram.update(x_deg)
        at = (wrap360(line_deg) // (360.0 / HEADING_BINS)).astype(np.int64)
        self.heading = self.heading + Bins.of(HEADING_BINS, at, x_deg)
        self.turning.update(stamp_ns, x_deg, line_deg)
        self.shifts.update(stamp_ns, x_deg, line_deg)
        self.spectra.update(stamp_ns, x_deg)


class SegmentSketches:
    """
    Sketches of one input, a sketch for each clock segment.

    Parameters
    ----------
    source
        As for `SeriesSketch`.

    Attributes
    ----------
    sketches : list of SeriesSketch
        In the order of the segments, n >= 1.

    """

    def __init__(self, source: str = '') -> None:
        self.sketches = [SeriesSketch(source)]
        self._motion: list[Motion] = []

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship, before the pairs of the same time."""
        self._motion.append(motion)
        self.sketches[-1].take_motion(motion)

    def update(self, pairs: Pairs, settings: Settings) -> None:
        """Take pairs in the order of their segments and stamps; see `SeriesSketch.update`."""
        for part in pairs.in_segments():
            if part.segment[0] != self.sketches[-1].segment:
                self.sketches.append(SeriesSketch(self.sketches[0].source, int(part.segment[0])))
                for motion in self._motion:
                    self.sketches[-1].take_motion(motion)
            self.sketches[-1].update(part, settings)
