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

"""Run a gimballed AHRS and observe its true state, which no sensor shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from heading_intercompare.ahrs.gimballed.gimballed_ahrs import GimballedAhrs
from heading_intercompare.ahrs.gimballed.modes import AhrsStatus, Mode
from heading_intercompare.ahrs.sensor_presets import errors_of
from heading_intercompare.ahrs.settings import Ahrs, Errors
from heading_intercompare.ahrs.ship.course import NO_CURRENT
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg


@dataclass
class Run:
    """An AHRS after a while, and its true state at the start of each control step."""

    ahrs: GimballedAhrs
    t_s: np.ndarray
    heading_error_arcmin: np.ndarray
    tilt_arcmin: np.ndarray
    beta_arcsec: np.ndarray
    mode: np.ndarray
    validity: np.ndarray
    statuses: list[AhrsStatus]

    def first(self, mode: Mode) -> int:
        """Return the first step in a mode."""
        assert mode in self.mode, f'{mode.name} was not reached'
        return int(np.argmax(self.mode == mode))


@pytest.fixture
def make_ahrs():
    """Return a function that builds an AHRS; default: no noise, calm sea, 45 degrees."""
    def make(latitude_deg=45.0, legs=((0.0, 0.0, 0.0),), seaway='calm', seed=1,
             model='dtg_precision', errors=None, current=NO_CURRENT, **settings):
        settings.setdefault('noise', False)
        ship = ShipTruth([Leg(*leg) for leg in legs], latitude_deg, 0.0, seaway, seed,
                         current=current)
        return GimballedAhrs(Ahrs(**settings), errors_of(model, Errors(**(errors or {}))), ship,
                             seed, 'ts')
    return make


@pytest.fixture
def run_for():
    """Return a function that runs an AHRS for some seconds."""
    def run(ahrs, span_s):
        tracks = []
        end_s = ahrs.now_s + span_s
        while ahrs.now_s < end_s - 1e-6:
            tracks.append(ahrs.block())

        def joined(name):
            return np.concatenate([getattr(track, name)[:100] for track in tracks])

        arcmin = np.degrees(1.0) * 60.0
        return Run(ahrs, np.concatenate([k.start_s + 0.1 * np.arange(100) for k in tracks]),
                   joined('error_rad') * arcmin,
                   np.hypot(joined('alpha_rad'), joined('beta_rad')) * arcmin,
                   joined('beta_rad') * 60.0 * arcmin, joined('mode'), joined('validity'),
                   [status for track in tracks for status in track.statuses])
    return run
