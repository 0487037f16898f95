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

"""All signs that both headings of a run come from one sensor, and the conclusion from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.statistics.resolution import find_resolution, LOOKED_AT

from .common_glitches import CommonGlitches, find_common_glitches
from .common_noise import CommonNoise, find_common_noise
from .same_readings import find_same_source, SameSource

__all__ = ['find_one_source', 'OneSource']


@dataclass(frozen=True, slots=True)
class OneSource:
    """
    Signs of one source.

    Attributes
    ----------
    readings : SameSource
        Whether the TS repeats the RS, reading by reading.
    noise : CommonNoise
        Whether one sensor follows the noise of the other.
    glitches : CommonGlitches
        Whether the TS follows the glitches of the RS.

    """

    readings: SameSource
    noise: CommonNoise
    glitches: CommonGlitches

    @property
    def kind(self) -> str:
        """
        Return the conclusion from all signs.

        'common': one source. 'unsure': they share noise, but less than a copy would.
        'independent': both show noise of their own or the RS shows glitches, and the other does
        not follow. 'suspected': the TS repeats the RS, which shows neither, reading by reading;
        so would a copy, but also a second sensor without errors. Otherwise 'not_testable'.
        """
        kinds = self.noise.kind, self.glitches.kind
        if 'common' in kinds:
            return 'common'
        if 'unsure' in kinds:
            return 'unsure'
        if 'independent' in kinds:
            return 'independent'
        is_repeated = self.readings.suspected and self.noise.of_rs.kind != 'independent'
        return 'suspected' if is_repeated else 'not_testable'


def find_one_source(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                    factor: ArrayLike | None = None, interpolates_ts: bool = False,
                    share: float = 0.001) -> OneSource:
    """
    Look for signs of one source in the pairs of a run.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, finite, degrees.
    factor : array_like, shape (n,), optional
        Factor by which interpolation changes the variance of white noise; default 1.
    interpolates_ts : bool
        Whether the TS is interpolated, not the RS.
    share : float
        `detectors.same_source_share`.

    Returns
    -------
    OneSource

    Notes
    -----
    Uses nothing but pairs, so the result is the same live, in replay and offline.

    References
    ----------
    E.20 of ``docs/diagnostics.md``.

    """
    x, rs = (np.asarray(v, dtype=np.float64) for v in (x_deg, rs_deg))
    steps = find_resolution(wrap360(x[:LOOKED_AT] + rs[:LOOKED_AT])), find_resolution(rs)
    return OneSource(
        find_same_source(x, rs, *steps, share),
        find_common_noise(stamp_ns, x, rs, factor=factor, interpolates_ts=interpolates_ts,
                          ts_step_deg=steps[0].step_deg, rs_step_deg=steps[1].step_deg),
        find_common_glitches(stamp_ns, x, rs))
