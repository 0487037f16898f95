# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Satellite fixes find the drift of a free azimuth, in fine levelling as in gyro azimuth."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from heading_intercompare.ahrs.gimballed.fixes import Fixes
from heading_intercompare.ahrs.gimballed.modes import Mode
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H


class FreeAzimuth:
    """A platform whose azimuth moves with the drift that the estimate leaves."""

    def __init__(self, drift_deg_h, method='rls'):
        self.computer = SimpleNamespace(
            settings=SimpleNamespace(gps_correction=method), drift_z_rad_s=0.0, azimuth_rad=0.0,
            gps_ok=True)
        self.platform = SimpleNamespace(pick_off_rad=0.0, satellite_rad=0.0)
        self.drift_rad_s, self.said = drift_deg_h * RAD_PER_DEG_H, []
        self.fixes = Fixes(self.computer, self.platform, self.said.append)

    def wait(self, span_s):
        """Let time pass; return the estimate in deg/h."""
        for _ in range(round(span_s * 10.0)):
            self.platform.pick_off_rad -= 0.1 * (self.drift_rad_s - self.computer.drift_z_rad_s)
            self.fixes.step()
        return self.computer.drift_z_rad_s / RAD_PER_DEG_H


@pytest.mark.parametrize('method, first, second', [('rls', 0.3, 0.3), ('pair', 0.15, 0.225)])
def test_two_fixes_half_an_hour_apart_show_the_drift(method, first, second):
    """The line has it all at once; a pair takes half of what it sees, the next half of that."""
    free = FreeAzimuth(0.3, method)
    assert free.wait(3599.9) == 0.0
    assert free.wait(0.1) == pytest.approx(first, rel=1e-6)
    # The correction came at the end of the fix, so the next pair has 1500 of 1800 s without it.
    assert free.wait(1800.0) == pytest.approx(second, rel=0.06)
    assert len(free.said) == 2


def test_fix_that_misses_the_satellites_does_not_count():
    free = FreeAzimuth(0.3)
    free.wait(1500.0)
    free.computer.gps_ok = False
    free.wait(10.0)
    free.computer.gps_ok = True
    assert free.wait(2090.0) == 0.0
    assert free.wait(1800.0) == pytest.approx(0.3, rel=1e-6)


def test_correction_in_between_is_undone():
    """A calibration that finds 0.2 of 0.3 deg/h between two fixes does not disturb the line."""
    free = FreeAzimuth(0.3)
    free.wait(2500.0)
    free.computer.drift_z_rad_s = 0.2 * RAD_PER_DEG_H
    assert free.wait(1100.0) == pytest.approx(0.3, rel=1e-6)


def sailing(make_ahrs, **settings):
    """Return an AHRS under way with a good satellite heading and short procedures."""
    return make_ahrs(legs=((0.0, 60.0, 10.0),), initial_state='warm', hold_s=20.0,
                     alignment_s=60.0, gps=True, accelerometer_calibration='off',
                     fixed='drift_z 0.2', errors={'gps_deg': 0.0}, **settings)


@pytest.mark.slow
def test_fixes_begin_with_fine_levelling_and_go_on_in_gyro_azimuth(make_ahrs, run_for):
    """The calibration S (15) takes 2700 s of fine levelling; the second fix is 900 s later."""
    ahrs = sailing(make_ahrs, operation='gyro_azimuth')
    run = run_for(ahrs, 4400.0)
    start_s = run.t_s[run.first(Mode.FINE_LEVELLING)]
    assert run.t_s[run.first(Mode.GYRO_AZIMUTH)] == pytest.approx(start_s + 2700.0, abs=0.2)
    (fixed,) = (status for status in run.statuses if 'corrected by satellite' in status.message)
    assert fixed.t_s == pytest.approx(start_s + 3600.0, abs=1.1)
    assert fixed.drifts_deg_h[2] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.slow
def test_fixes_correct_the_drift_in_fine_levelling(make_ahrs, run_for):
    """In an hour of fine levelling; the calibration S (15) ends when the satellites are lost."""
    ahrs = sailing(make_ahrs, fine_s=3600.0)
    run_for(ahrs, 1000.0)
    ahrs.command('gps_lost', 1000.0)
    ahrs.command('gps_found', 1020.0)
    assert ahrs.mode is Mode.FINE_LEVELLING
    run = run_for(ahrs, 3260.0)
    (fixed,) = (status for status in run.statuses if 'corrected by satellite' in status.message)
    assert fixed.t_s == pytest.approx(run.t_s[run.first(Mode.GYROCOMPASS)], abs=0.2)
    assert fixed.drifts_deg_h[2] == pytest.approx(0.2, abs=1e-3)


def test_fixes_start_afresh_after_the_gyrocompass(make_ahrs, run_for):
    """The gyrocompass corrects the azimuth, so what was fixed before no longer counts."""
    ahrs = make_ahrs(initial_state='aligned', operation='gyro_azimuth', gps=True,
                     events='20 gyrocompass')
    ahrs.fixes = before = Fixes(ahrs.computer, ahrs.platform, ahrs.say)
    run_for(ahrs, 30.0)
    assert ahrs.fixes is None and before is not None
