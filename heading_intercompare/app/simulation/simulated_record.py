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

"""The record of a simulated trial in memory, with its true errors, judged whole or cut."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Mapping

import numpy as np

from heading_intercompare.ahrs.sensors import Readings
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.analysis import analyze
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.records import Motion, Reals
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict


@dataclass(frozen=True, slots=True)
class SimulatedRecord:
    """
    The readings of a simulated TS and RS, and what was true.

    Attributes
    ----------
    readings
        Of 'ts' and 'rs', as delivered.
    error_deg
        Their errors against the true heading, degrees; nan where a reading is invalid.
    motion
        What the ship told of its motion.
    start_ns
        Stamp of the start, nanoseconds.

    """

    readings: Mapping[str, Readings]
    error_deg: Mapping[str, Reals]
    motion: Motion
    start_ns: int

    def judge(self, settings: Settings, duration_s: float = math.inf) -> Verdict:
        """Return the verdict on the trial, or on what it had measured after a time, seconds."""
        motion = self.motion
        if duration_s < math.inf:
            motion = motion[motion.stamp_ns <= self.start_ns + round(duration_s * 1e9)]
        ts, rs = (self.readings[name] for name in ('ts', 'rs'))
        return analyze(ts[ts.t_s <= duration_s].headings, rs[rs.t_s <= duration_s].headings,
                       settings, motion=motion)

    def true_std_deg(self, name: str) -> float:
        """Return the standard deviation of the errors of a sensor; nan without a reading."""
        error_deg = self.error_deg[name]
        valid = np.isfinite(error_deg)
        return float(error_deg[valid].std()) if valid.any() else math.nan


def simulate_record(simulation: Simulation) -> SimulatedRecord:
    """Return the record of a trial."""
    readings: dict[str, list[Readings]] = {'ts': [], 'rs': []}
    errors: dict[str, list[Reals]] = {'ts': [], 'rs': []}
    motions = []
    ship = simulation.truth()
    for chunk in simulation.chunks():
        motions.append(chunk.motion)
        for name in readings:
            sent = chunk.sent[name][0]
            readings[name].append(sent)
            errors[name].append(wrap180(sent.headings.heading_deg - ship.heading_deg(sent.t_s)))
    return SimulatedRecord(
        {name: Readings.concatenate(parts) for name, parts in readings.items()},
        {name: np.concatenate(parts) for name, parts in errors.items()},
        Motion.concatenate(motions), simulation.start_ns)
