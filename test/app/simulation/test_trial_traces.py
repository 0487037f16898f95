# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a trial showed, in columns."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.simulation.trial_traces import COLUMNS, TrialTraces
from heading_intercompare.core.angles import wrap180

SCENARIO = Scenario.from_mapping({
    'duration_s': 240.0, 'legs': '0 350 10; 60 20 10', 'seed': 3,
    'ts.model': 'marine_0p1', 'ts.ahrs.initial_state': 'aligned',
    'ts.ahrs.events': '120 gyro_azimuth', 'ts.faults': '200 invalid 0 20',
    'rs.offset_deg': 0.5, 'rs.claimed_sigma_deg': 0.3})


def gather(chunk_s):
    """Return the traces of the trial, delivered in spans of this length."""
    simulation = Simulation(SCENARIO)
    traces = TrialTraces(simulation.truth(), 240.0)
    for chunk in simulation.chunks(chunk_s):
        traces.take(chunk)
    return traces.traces()


def test_errors_lie_between_the_columns_limits():
    """Against all readings of the trial; each column holds those of 0.2 s."""
    ts, rs = gather(60.0)
    chunk = next(Simulation(SCENARIO).chunks(1000.0))
    readings, ship = chunk.ts_readings, Simulation(SCENARIO).truth()
    error = wrap180(readings.headings.heading_deg - ship.heading_deg(readings.t_s))
    given = np.isfinite(error)
    assert np.nanmax(ts.high_deg) == error[given].max()
    assert np.nanmin(ts.low_deg) == error[given].min()
    assert rs.low_deg == pytest.approx(np.full(COLUMNS, 0.5), abs=1e-9)
    assert np.nanmax(rs.sigma_deg) == 0.3
    assert wrap180(rs.heading_deg - rs.true_deg) == pytest.approx(np.full(COLUMNS, 0.5), abs=1e-9)
    assert (ts.name, rs.name, rs.n) == ('TS', 'RS', 2400)


def test_modes_are_told_and_invalid_readings_leave_a_hole():
    ts, rs = gather(60.0)
    assert [name for _, name in ts.modes] == ['GYROCOMPASS', 'GYRO_AZIMUTH']
    assert ts.modes[1][0] == pytest.approx(120.0 / 3600.0, abs=1e-3)
    assert rs.modes == ()
    hole = (ts.t_h * 3600.0 > 200.1) & (ts.t_h * 3600.0 < 219.9)
    assert np.isnan(ts.low_deg[hole]).all() and not np.isnan(ts.low_deg[~hole]).all()


def test_traces_do_not_depend_on_the_chunks():
    for one, other in zip(gather(7.0), gather(240.0)):
        for name in ('true_deg', 'heading_deg', 'low_deg', 'high_deg', 'sigma_deg'):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert one.modes == other.modes
