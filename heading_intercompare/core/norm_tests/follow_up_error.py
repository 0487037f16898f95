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

"""The follow-up error: what a lag of the TS makes at a rate of turn."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Reals
from heading_intercompare.core.timing.heading_track import Track

from .judged_test import Measurement
from .tested_run import exceeding, reach, TestedRun

#: A rate of turn is held if the ship turns so fast over this time.
_HELD_S = 5.0
#: Turns of this time altogether show the rate, seconds.
_LEAST_TURNING_S = 20.0


def measure_follow_up(tested: TestedRun, limit: float, rates_deg_s: tuple[float, float],
                      least_rate_deg_s: float) -> Measurement:
    """
    Return the follow-up error at the highest rate of turn that was sailed.

    Parameters
    ----------
    tested
        The run.
    limit
        Largest permitted error, degrees.
    rates_deg_s
        The rates of turn that the limit holds for, slowest and fastest.
    least_rate_deg_s
        The least rate of turn at which a record says something of it.

    Notes
    -----
    A sensor that lags by tau is off by tau times the rate of turn. The lag is the time skew that
    the pairs show, with its uncertainty, so all turns contribute. The test is not met if the
    error at a rate that was sailed is above the limit. It is met only if the lag also keeps the
    limit at the fastest rate of the norm, which few ships reach.

    References
    ----------
    MSC.116(73) 3.9 and 4.3.2.4; E.8 of ``docs/diagnostics.md``.

    """
    slowest, fastest = rates_deg_s
    alignment, skew = tested.settings.alignment, tested.columns.skew
    if alignment.skew == 'apply' or alignment.skew_s:
        return Measurement(record='a skew is removed from the stamps, and a lag with it; judge '
                           'with alignment.skew: report and alignment.skew_s: 0')
    held = highest_held_rate(tested)
    record = f'turns at up to {held:.2g} deg/s'
    if held <= slowest:
        return Measurement(record=record)
    if not skew.well_determined or skew.skew_s is None or not skew.u_s:
        return Measurement(record=f'{record}; {skew.why_not(alignment.skew_range_s)}')
    rate = min(held, fastest)
    nu = float('inf')
    value, u = abs(skew.skew_s) * rate, skew.u_s * rate
    high = (abs(skew.skew_s) + reach(tested.risks.met, nu) * skew.u_s) * fastest
    return Measurement(
        value, max(0.0, value - reach(0.5 * tested.risks.not_met, nu) * u), high,
        min(1.0, 2.0 * exceeding((value - limit) / u, nu)), rate >= least_rate_deg_s,
        f'{record}; a lag of {skew.skew_s:.3f} s, u = {skew.u_s:.2g} s',
        f'the clocks of the sensors lie {abs(skew.skew_s):.2f} s apart')


def highest_held_rate(tested: TestedRun) -> float:
    """Return the highest rate of turn of the RS that was held for seconds, degrees per second."""
    tracks = tested.columns.tracks
    if tracks is None:
        return 0.0
    rates = np.sort(_rates_over(tracks.rs, _HELD_S))
    samples = max(1, round(_LEAST_TURNING_S / max(tracks.rs.step_s, 1e-3)))
    return float(rates[-samples]) if rates.size >= samples else 0.0


def _rates_over(track: Track, span_s: float) -> Reals:
    """Return the sizes of the mean rates of turn over spans, at each reading with one."""
    ahead = np.searchsorted(track.t_s, track.t_s + span_s)
    at = np.flatnonzero(ahead < track.t_s.size)
    turned = track.heading_deg[ahead[at]] - track.heading_deg[at]
    spans = track.t_s[ahead[at]] - track.t_s[at]
    whole = spans <= 2.0 * span_s
    rates: Reals = np.abs(turned[whole] / spans[whole])
    return rates
