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

"""Trials that sail the tests of a norm, with sensors whose errors are known."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from heading_intercompare.core.records import Headings

START_NS = 1_700_000_000_000_000_000


def sail(*, seed: int = 1, hours: float = 2.0, rate_hz: float = 2.0, lag_s: float = 0.0,
         step_deg: float = 0.0, static_deg: float = 0.0, dynamic_deg: float = 0.0,
         period_s: float = 12.0, noise_deg: float = 0.1, turn_deg_s: float = 3.0,
         yaw_deg: float = 1.5, leg_s: float = 600.0) -> tuple[Headings, Headings]:
    """Return TS and RS of legs 45 deg apart in a swell, with the errors of the TS."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(round(hours * 3600.0 * rate_hz)) / rate_hz

    def turn_ship(at_s: np.ndarray) -> np.ndarray:
        legs = np.floor(at_s / leg_s)
        turned = np.clip((at_s - leg_s * legs) * turn_deg_s, 0.0, 45.0)
        return 45.0 * legs + turned + yaw_deg * np.sin(2.0 * np.pi * at_s / 9.0)

    ts_deg = (turn_ship(t_s - lag_s) + static_deg + noise_deg * rng.standard_normal(t_s.size)
              + dynamic_deg * np.sin(2.0 * np.pi * t_s / period_s + 1.0))
    rs_deg = turn_ship(t_s) + 0.05 * rng.standard_normal(t_s.size)
    if step_deg:
        ts_deg = np.round(ts_deg / step_deg) * step_deg
    stamp_ns = START_NS + np.round(t_s * 1e9).astype(np.int64)
    return Headings.of(stamp_ns, ts_deg % 360.0), Headings.of(stamp_ns, rs_deg % 360.0)


def lie_alongside(*, points_deg: Sequence[float] = (0.1, 0.15, 0.05), hours: float = 8.0,
                  tau_s: float = 2400.0, amplitude_deg: float = 20.0, noise_deg: float = 0.08,
                  headings_deg: Sequence[float] = (73.6,),
                  seed: int = 1) -> tuple[Headings, Headings]:
    """Return TS and RS, read every 30 s, of a sensor that is started once for each point."""
    rng, t_s = np.random.default_rng(seed), np.arange(0.0, 3600.0 * hours, 30.0)
    stamps, x, rs = [], [], []
    for start, point_deg in enumerate(points_deg):
        begin_s = start * (3600.0 * hours + 1800.0)
        stamps.append(START_NS + np.rint((begin_s + t_s) * 1e9).astype(np.int64))
        x.append(point_deg + amplitude_deg * np.exp(-t_s / tau_s)
                 + noise_deg * rng.standard_normal(t_s.size))
        rs.append(headings_deg[start % len(headings_deg)] + 0.05 * rng.standard_normal(t_s.size))
    stamp_ns, rs_deg = np.concatenate(stamps), np.concatenate(rs)
    return (Headings(stamp_ns, (rs_deg + np.concatenate(x)) % 360.0),
            Headings(stamp_ns, rs_deg % 360.0))
