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

"""What the AHRS says of itself is true: heater watch, validity, flags, refusals, claims."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.gimballed.calibration import hann
from heading_intercompare.ahrs.gimballed.claims import FreeAzimuth, satellite_sigma
from heading_intercompare.ahrs.gimballed.modes import Mode, Validity
from heading_intercompare.ahrs.random_noise import Markov
from heading_intercompare.ahrs.sensor_presets import ERRORS, ModelErrors
from heading_intercompare.ahrs.ship.earth import RAD_PER_DEG_H


def messages(run):
    """Return everything that the AHRS said."""
    return '; '.join(status.message for status in run.statuses if status.message)


@pytest.mark.parametrize('events', ['5 force_on', '5 force_on; 10 power_dip'])
def test_force_on_in_operation_leaves_the_heater_watch_on(make_ahrs, run_for, events):
    """The heater fails at 40 s: 2 of 40 K are lost after 200 s ln(40/38) = 10.3 s."""
    ahrs = make_ahrs(initial_state='aligned', events=f'{events}; 40 fail_thermostat')
    run = run_for(ahrs, 70.0)
    assert 'force_on refused: only THERMOSTAT_WAIT' in messages(run)
    assert run.t_s[run.first(Mode.FAULT)] == pytest.approx(51.0, abs=1.5)
    assert run.statuses[-1].faults == ('thermostat',)


def test_forced_start_ends_with_a_restart(make_ahrs, run_for):
    """After the dip the instruments are still cold, so the AHRS waits for them again."""
    ahrs = make_ahrs(initial_state='cold', events='20 force_on; 60 power_dip')
    run = run_for(ahrs, 100.0)
    assert run.mode[590] == Mode.COARSE_LEVELLING
    assert run.statuses[50].flags == ('DEGRADED', 'FORCED_ON')
    assert run.mode[-1] == Mode.THERMOSTAT_WAIT
    assert run.statuses[-1].flags == ()


def test_heater_is_watched_again_once_a_forced_start_has_become_warm(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='cold', events='20 force_on; 900 fail_thermostat')
    run = run_for(ahrs, 930.0)
    assert run.t_s[run.first(Mode.FAULT)] == pytest.approx(910.0, abs=2.0)


def test_a_forced_heading_claims_what_the_temperature_does_to_it(make_ahrs, run_for):
    """
    Calibrated at 18 K away, warm afterwards: 0.02 deg/h/K of 17.7 K are 0.35 deg/h.

    A start forced on with 800 s of hold still heats while it is calibrated: 40 K exp(-t / 200 s).
    """
    ahrs = make_ahrs(initial_state='cold', hold_s=10.0, events='11 force_on')
    run_for(ahrs, 510.0)
    away_k = abs(ahrs.calibrated_k)
    assert away_k > 3.0
    run_for(ahrs, 1500.0)
    share = 0.02 * (away_k - abs(ahrs.instruments.thermostat.away_k) - 0.5)
    assert ahrs.residual_deg_h == pytest.approx(math.hypot(0.008, share), rel=1e-6)
    assert math.degrees(ahrs.sigma_rad) > 0.2


@pytest.mark.parametrize('command_s', [20.0, 300.0])
def test_azimuth_freed_before_the_meridian_is_found_is_not_valid(make_ahrs, run_for, command_s):
    ahrs = make_ahrs(initial_state='aligned', azimuth_deg=5.0,
                     events=f'{command_s} gyro_azimuth')
    run = run_for(ahrs, command_s + 60.0)
    assert run.mode[-1] == Mode.GYRO_AZIMUTH
    assert set(run.validity) == {Validity.SETTLING}
    assert run.statuses[-1].progress == 0.0
    assert run.statuses[-1].sigma_deg == pytest.approx(5.0, rel=0.01)
    assert abs(run.heading_error_arcmin[-1]) / 60.0 < 2.0 * run.statuses[-1].sigma_deg


@pytest.mark.slow
def test_it_becomes_valid_when_the_meridian_is_found_after_all(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='aligned', azimuth_deg=1.0,
                     events='20 gyro_azimuth; 60 gyrocompass; 4000 gyro_azimuth')
    run = run_for(ahrs, 4020.0)
    assert run.validity[10 * 70] == Validity.SETTLING
    assert run.mode[-1] == Mode.GYRO_AZIMUTH and run.validity[-1] == Validity.VALID
    assert abs(run.heading_error_arcmin[-1]) / 60.0 < 2.0 * run.statuses[-1].sigma_deg


def test_claim_of_a_free_azimuth_is_not_forgotten_by_the_gyrocompass(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='aligned', operation='gyro_azimuth', azimuth_deg=2.0,
                     events='30 gyrocompass')
    run = run_for(ahrs, 50.0)
    assert run.mode[-1] == Mode.GYROCOMPASS
    assert run.statuses[-1].sigma_deg > 2.0


def test_claim_of_a_free_azimuth_by_hand():
    """
    An hour with 0.03 deg/h left, 5 K and 0.02 deg/h/K, and half of a soak of 0.08 deg/h.

    0.03, 0.1 and 0.04 degrees with the random walk of 0.01 and the start of 0.05: 0.1229. After a
    calibration that leaves nothing, only the walk grows it.
    """
    free = FreeAzimuth(ModelErrors(random_walk_deg_sqrt_h=0.01, temperature_deg_h_k=0.02,
                                   soak_deg_h=0.08), math.radians(0.05))
    for _ in range(60):
        sigma_rad = free.add(60.0, 0.03, -5.0, 0.5)
    assert math.degrees(sigma_rad) == pytest.approx(0.12288, abs=1e-5)
    assert math.degrees(free.add(3600.0, 0.0, 0.0, 0.0)) == pytest.approx(
        math.hypot(0.12288, 0.01), abs=1e-5)
    for _ in range(2):
        sigma_rad = free.add(900.0, 0.0, 0.0, 0.0, math.radians(0.2) / 3600.0)
    assert math.degrees(sigma_rad) == pytest.approx(
        math.hypot(0.12288, math.sqrt(1.5) * 0.01, 0.1), abs=1e-5)


@pytest.mark.slow
def test_free_azimuth_of_cold_gyros_claims_what_the_cold_does_to_it(make_ahrs, run_for):
    """
    A start forced on although the heater has failed: 0.02 deg/h/K of 40 K are 0.8 deg/h.

    Under way nothing calibrates the course gyro. After 20 min the class alone would claim 0.06
    degrees. Six starts: chi-square quantiles of 1e-6 and 1 - 1e-6 over 6 are 0.0030 and 6.4.
    """
    ratios = []
    for seed in range(6):
        ahrs = make_ahrs(seed=seed, legs=((0.0, 60.0, 10.0),), initial_state='cold', noise=True,
                         operation='gyro_azimuth', hold_s=400.0, fine_s=10.0, start='mutual',
                         events='15 fail_thermostat; 30 force_on')
        # The meter is good enough to be calibrated.
        ahrs.instruments.gyro_heat[3:] = [0.0, 0.0]
        run = run_for(ahrs, 2700.0)
        assert run.mode[-1] == Mode.GYRO_AZIMUTH and run.validity[-1] == Validity.VALID
        assert run.statuses[-1].sigma_deg > 0.2
        ratios.append(run.heading_error_arcmin[-1] / 60.0 / run.statuses[-1].sigma_deg)
    assert 0.0030 < np.mean(np.square(ratios)) < 6.4


@pytest.mark.parametrize('operation, course_deg', [('gyrocompass', 0.0), ('gyro_azimuth', 60.0)])
def test_heading_without_a_log_claims_what_the_speed_may_do_to_it(make_ahrs, run_for, operation,
                                                                 course_deg):
    """
    The log is lost at 20 kn: the speed error of a gyrocompass, north that turns under a free gyro.

    20 kn at 60 degrees: 2.5 degrees northbound, or 0.5 deg/h on course 60. Once the log is back,
    the claim of the gyrocompass covers its error until that is forgotten.
    """
    ahrs = make_ahrs(60.0, legs=((0.0, course_deg, 20.0),), initial_state='aligned',
                     operation=operation, events='20 log_lost; 1500 log_found')
    run = run_for(ahrs, 4000.0)
    said = {status.t_s: status for status in run.statuses}
    error_deg = {t_s: abs(run.heading_error_arcmin[round(t_s * 10.0)]) / 60.0 for t_s in said}
    assert said[60.0].sigma_deg < 0.08 < said[1000.0].sigma_deg
    assert error_deg[1000.0] > 2.0 * said[60.0].sigma_deg
    assert all(error_deg[t_s] < 1.1 * one.sigma_deg for t_s, one in said.items()
               if one.validity == 'VALID')
    assert 'NO_SPEED' in said[1000.0].flags and not said[1600.0].flags


def test_restart_takes_the_latitude_of_the_ship_again(make_ahrs, run_for):
    """A fault in gyro azimuth with a latitude of its own: the ship has gone on meanwhile."""
    ahrs = make_ahrs(legs=((0.0, 0.0, 20.0),), initial_state='aligned', operation='gyro_azimuth',
                     vertical='schuler', own_latitude=True,
                     events='20 fail_gyro; 300 repair; 301 reset')
    run = run_for(ahrs, 320.0)
    assert run.mode[-1] in (Mode.POST, Mode.COARSE_LEVELLING)
    assert ahrs.computer.latitude_rad == ahrs.platform.latitude_rad


@pytest.mark.parametrize('leaves_s', [560.0, 700.0])
def test_ship_that_leaves_ends_the_calibration_of_the_accelerometers(make_ahrs, run_for,
                                                                     leaves_s):
    """Two positions of 120 s from 503 s on; the acceleration of the ship is no bias."""
    ahrs = make_ahrs(legs=((0.0, 30.0, 0.0), (leaves_s, 30.0, 12.0)), initial_state='warm',
                     hold_s=10.0, alignment_s=10.0, fixed='bias_x 80')
    run = run_for(ahrs, 800.0)
    assert 'calibration of the accelerometers dropped: the ship moves' in messages(run)
    assert ahrs.computer.bias_x_m_s2 == ahrs.computer.bias_y_m_s2 == 0.0
    assert ahrs.mode is Mode.FINE_LEVELLING
    assert abs(ahrs.platform.azimuth_rad) < math.radians(2.0)


def test_lost_log_is_named_where_it_ends_a_calibration(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='warm', hold_s=10.0, alignment_s=10.0,
                     accelerometer_calibration='off', events='450 log_lost')
    assert 'drift of the course gyro kept: no speed' in messages(run_for(ahrs, 620.0))


REFUSED = [
    ('aligned', 'gyrocompass', 'it is the mode already'),
    ('cold', 'gyrocompass', 'it is the mode that follows'),
    ('aligned', 'reset', 'there is no fault; the mode is GYROCOMPASS'),
    ('aligned', 'force_on', 'only THERMOSTAT_WAIT can be cut short; the mode is GYROCOMPASS'),
    ('aligned', 'log_found', 'the log is there already'),
    ('aligned', 'gps_lost', 'the satellite heading is lost already'),
    ('aligned', 'repair', 'nothing has failed')]


@pytest.mark.parametrize('state, kind, why', REFUSED, ids=[row[1] + row[0] for row in REFUSED])
def test_command_that_would_change_nothing_is_refused(make_ahrs, run_for, state, kind, why):
    ahrs = make_ahrs(initial_state=state)
    run_for(ahrs, 20.0)
    with pytest.raises(ValueError, match=f'{kind} refused: {why}'):
        ahrs.command(kind, 20.0)
    planned = make_ahrs(initial_state=state, events=f'12 {kind}')
    assert f'{kind} refused: {why}' in messages(run_for(planned, 20.0))


def test_command_given_twice_is_refused_the_second_time(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='aligned')
    run_for(ahrs, 20.0)
    assert ahrs.command('gyro_azimuth', 20.0) == 20.0
    with pytest.raises(ValueError, match='gyro_azimuth refused: it is about to happen'):
        ahrs.command('gyro_azimuth', 20.0)
    ahrs.command('gyrocompass', 20.0)
    ahrs.command('gyro_azimuth', 20.0)
    run_for(ahrs, 20.0)
    assert ahrs.mode is Mode.GYRO_AZIMUTH
    with pytest.raises(ValueError, match='gyro_azimuth refused: it is the mode already'):
        ahrs.command('gyro_azimuth', 40.0)


def test_command_counts_those_that_wait(make_ahrs, run_for):
    """A repair that follows a failure, a failure that follows a repair, a mode after a reset."""
    ahrs = make_ahrs(initial_state='aligned')
    run_for(ahrs, 20.0)
    ahrs.command('fail_gyro', 20.0)
    with pytest.raises(ValueError, match='fail_gyro refused: it is about to happen'):
        ahrs.command('fail_gyro', 20.0)
    ahrs.command('repair', 20.0)
    with pytest.raises(ValueError, match='repair refused: it is about to happen'):
        ahrs.command('repair', 20.0)
    ahrs.command('fail_gyro', 20.0)
    run_for(ahrs, 20.0)
    assert ahrs.mode is Mode.FAULT and ahrs.failures == {'gyro'}
    ahrs.command('repair', 40.0)
    ahrs.command('reset', 40.0)
    ahrs.command('gyro_azimuth', 40.0)
    run_for(ahrs, 20.0)
    assert ahrs.mode is Mode.COARSE_LEVELLING and ahrs.operation is Mode.GYRO_AZIMUTH


@pytest.mark.parametrize('use', ['none', 'manual'])
def test_log_that_is_not_used_cannot_be_lost(make_ahrs, run_for, use):
    ahrs = make_ahrs(initial_state='aligned', speed_compensation=use)
    run_for(ahrs, 10.0)
    with pytest.raises(ValueError, match='log_lost refused: the log is not used'):
        ahrs.command('log_lost', 10.0)


def test_fault_takes_no_command_but_reset(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='aligned', events='5 fail_gyro; 12 fail_gyro')
    assert 'fail_gyro refused: it has failed already' in messages(run_for(ahrs, 20.0))
    for kind in ('gyrocompass', 'gyro_azimuth'):
        with pytest.raises(ValueError, match='the mode is FAULT; reset first'):
            ahrs.command(kind, 20.0)
    assert ahrs.command('reset', 20.0) == 20.0


def test_no_gyrocompass_near_the_pole(make_ahrs, run_for):
    ahrs = make_ahrs(86.0, initial_state='aligned')
    run = run_for(ahrs, 20.0)
    assert set(run.mode) == {Mode.GYRO_AZIMUTH} and run.validity[-1] == Validity.VALID
    with pytest.raises(ValueError, match='too near the pole'):
        ahrs.command('gyrocompass', 20.0)


def underway(make_ahrs, **settings):
    """Return an AHRS under way in sea state 5 with a satellite heading and short procedures."""
    return make_ahrs(legs=((0.0, 60.0, 10.0),), seaway='ss5', initial_state='warm', hold_s=120.0,
                     alignment_s=200.0, gps=True, accelerometer_calibration='off', **settings)


@pytest.mark.slow
@pytest.mark.parametrize('gps_deg, left', [(0.0, 0.01), (0.005, 0.02)])
def test_satellite_heading_calibrates_the_course_gyro_at_sea(make_ahrs, run_for, gps_deg, left):
    """A drift of 0.2 deg/h is found by a satellite heading that is good enough."""
    ahrs = underway(make_ahrs, noise=gps_deg > 0.0, fixed='drift_z 0.2',
                    errors={'gps_deg': gps_deg, 'turn_on_deg_h': 0.2, 'temperature_deg_h_k': 0.0,
                            'soak_deg_h': 0.0})
    run = run_for(ahrs, 3800.0)
    assert 'calibrated by satellite heading' in messages(run)
    assert ahrs.computer.drift_z_rad_s / RAD_PER_DEG_H == pytest.approx(0.2, abs=3.0 * left)
    assert ahrs.course_deg_h < left


@pytest.mark.slow
def test_noisy_satellite_heading_counts_as_far_as_it_knows_more(make_ahrs, run_for):
    """0.1 degrees of 100 s: 0.156 deg/h after 45 min, against 0.03 deg/h that were known."""
    ahrs = underway(make_ahrs, noise=True)
    run = run_for(ahrs, 3800.0)
    assert 'calibrated by satellite heading, to 0.029 deg/h' in messages(run)
    assert abs(ahrs.computer.drift_z_rad_s) / RAD_PER_DEG_H < 0.03
    assert ahrs.course_deg_h == pytest.approx(0.03 * math.sqrt(1.0 - 0.0355), rel=1e-3)


def test_satellite_heading_lost_on_the_way_ends_its_calibration(make_ahrs, run_for):
    ahrs = underway(make_ahrs, events='1000 gps_lost')
    run = run_for(ahrs, 1100.0)
    assert ahrs.mode is Mode.FINE_LEVELLING
    assert 'drift of the course gyro kept: satellite heading lost' in messages(run)
    assert ahrs.computer.drift_z_rad_s == 0.0
    assert ahrs.course_deg_h == ERRORS['dtg_precision'].turn_on_deg_h


def test_mean_of_a_coloured_satellite_heading_is_as_good_as_told(rng):
    """Markov noise, tau = 20 s, Hann-weighted over 300 s: 1000 means, known to 14 %."""
    noise = Markov(1.0, 20.0, 1.0, rng).take(300 * 1000).reshape(1000, 300)
    weights = hann(300) / hann(300).sum()
    told = math.degrees(satellite_sigma(ModelErrors(gps_deg=1.0, gps_tau_s=20.0), 300.0))
    assert np.std(noise @ weights) == pytest.approx(told, rel=0.14)


@pytest.mark.slow
def test_fine_levelling_ends_at_its_limit_with_a_flag(make_ahrs, run_for):
    ahrs = make_ahrs(initial_state='warm', fine_s=5000.0, hold_s=60.0, alignment_s=60.0)
    run = run_for(ahrs, 4250.0)
    first, last = run.first(Mode.FINE_LEVELLING), run.first(Mode.GYROCOMPASS)
    assert run.t_s[last] - run.t_s[first] == pytest.approx(3600.0, abs=0.3)
    assert run.statuses[-1].flags == ('DEGRADED', 'FINE_LIMIT')
    assert 'ended at its limit of 3600 s' in messages(run)
