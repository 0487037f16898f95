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

"""Readings of simulated sensors."""

from __future__ import annotations

from dataclasses import fields
import math

import numpy as np
import pytest

from heading_intercompare.ahrs.sensor_presets import ModelErrors
from heading_intercompare.ahrs.sensors import SimulatedSensor
from heading_intercompare.ahrs.settings import Errors, Scenario, Sensor
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.core.angles import wrap180
from heading_intercompare.core.declared_settings import SettingsError

START_NS = 1_000_000_000_000_000_000


def readings(until_s=1000.0, course_deg=359.9, **settings):
    """Return what a sensor on a steady ship reads."""
    ship = ShipTruth([Leg(0.0, course_deg, 0.0)], 45.0)
    return SimulatedSensor(Sensor(**settings), ship, START_NS, 3, 'ts').take(until_s)


def errors(**settings):
    """Return the errors of these readings, degrees."""
    return wrap180(readings(10000.0, **settings).headings.heading_deg - 359.9)


def test_ideal_sensor_reads_the_true_heading_on_time():
    read = readings(1.0, rate_hz=4.0, phase_s=0.125)
    assert read.headings.heading_deg == pytest.approx(359.9)
    assert (read.headings.stamp_ns - START_NS).tolist() == [
        125_000_000, 375_000_000, 625_000_000, 875_000_000]


def test_readings_stay_within_the_circle():
    heading = readings(white_deg=1.0, resolution_deg=0.1).headings.heading_deg
    assert heading.min() >= 0.0 and heading.max() < 360.0
    assert heading.min() < 1.0 and heading.max() > 359.0


@pytest.mark.parametrize('shape', ['normal', 'uniform'])
def test_white_noise_has_its_size_and_shape(shape):
    """100000 readings: six standard errors of a normal sd are 1.4 %; uniform has kurtosis 1.8."""
    x = errors(white_deg=0.2, white_shape=shape)
    assert np.std(x) == pytest.approx(0.2, rel=0.014)
    assert np.mean(x**4) / np.mean(x**2)**2 == pytest.approx(
        3.0 if shape == 'normal' else 1.8, abs=0.1)
    assert np.abs(np.corrcoef(x[1:], x[:-1])[0, 1]) < 0.02


def test_terms_by_hand():
    """Offset, drift, settling and tone at 0 and at 1800 s."""
    x = errors(offset_deg=0.3, drift_deg_h=0.2, settling_deg=1.0, settling_tau_s=1800.0)
    assert x[0] == pytest.approx(1.3)
    assert x[18000] == pytest.approx(0.3 + 0.1 + math.exp(-1.0))
    tone = errors(tone_deg=0.5, tone_period_s=100.0)
    assert np.sqrt(np.mean(tone**2)) == pytest.approx(0.5 / math.sqrt(2.0), rel=1e-3)
    assert tone[:1000] == pytest.approx(tone[1000:2000], abs=1e-9)


def test_each_start_settles_at_its_own_point_by_hand():
    """0.3 from the offset, at the second start and two time constants after it."""
    x = errors(offset_deg=0.3, settling_deg=2.0, settling_tau_s=100.0, rate_hz=1.0,
               starts='5000 -0.4; 8000 0.2')
    assert x[[0, 200, 4999]] == pytest.approx([2.3, 0.3 + 2.0 * math.exp(-2.0), 0.3])
    assert x[[5000, 5200, 7999]] == pytest.approx([1.9, -0.1 + 2.0 * math.exp(-2.0), -0.1])
    assert x[8000] == pytest.approx(2.5)


def test_a_late_stamp_is_a_lag_of_the_heading_in_a_turn():
    """0.5 s late at 1 deg/s: half a degree behind, in a turn to either side."""
    ship = ShipTruth([Leg(0.0, 60.0, 12.0), Leg(60.0, 180.0, 12.0), Leg(300.0, 60.0, 12.0)], 45.0,
                     turn_deg_s=1.0)
    late = SimulatedSensor(Sensor(stamp_offset_s=0.5), ship, START_NS, 3, 'ts').take(400.0)
    t_s = (late.headings.stamp_ns - START_NS) / 1e9
    behind_deg = wrap180(late.headings.heading_deg - ship.heading_deg(t_s))
    assert behind_deg == pytest.approx(-0.5 * np.degrees(ship.heading_rate_rad_s(t_s - 0.25)),
                                       abs=0.003)
    assert behind_deg.min() < -0.49 and behind_deg.max() > 0.49


def test_presets_join_the_terms_given():
    """Satellite compass 0.05 and 0.08 with 0.12 white: the claim is their root sum of squares."""
    read = readings(1.0, model='gnss_compass', white_deg=0.12)
    assert read.sigma_deg == pytest.approx(math.sqrt(0.05**2 + 0.08**2 + 0.12**2))
    assert readings(1.0, claimed_sigma_deg=0.7, white_deg=0.1).sigma_deg == pytest.approx(0.7)


def test_outages_of_a_preset_or_of_the_settings_take_readings_away():
    """Ten outages an hour of 20 s are 3 % of the time; half a second in every second is half."""
    n = {name: len(readings(3600.0, rate_hz=1.0, **settings)) for name, settings in {
        'none': {'model': 'gnss_compass'}, 'some': {'model': 'gnss_harbour'},
        'many': {'model': 'gnss_harbour', 'outage_every_s': 30.0, 'outage_s': 30.0}}.items()}
    assert n['none'] == 3600
    assert 3000 < n['some'] < 3600
    assert 1000 < n['many'] < 2600


@pytest.mark.slow
@pytest.mark.parametrize('model, rms_deg', [
    ('gnss_compass', 0.094), ('gnss_0p5m', 0.36), ('gnss_5m', 0.036), ('gnss_harbour', 0.255),
    ('fog_strapdown', 0.139), ('rlg_strapdown', 0.07)])
def test_presets_have_the_errors_of_their_class(model, rms_deg):
    """30 h of the slowest, 7200 s: some 15 independent values, 30 % with two standard errors."""
    read = readings(108_000.0, rate_hz=0.1, model=model)
    error_deg = (read.headings.heading_deg - 359.9 + 180.0) % 360.0 - 180.0
    assert np.sqrt(np.mean(error_deg**2)) == pytest.approx(rms_deg, rel=0.35)


def test_every_error_that_can_be_set_is_known_for_a_model():
    assert [f.name for f in fields(ModelErrors)] == [f.name for f in fields(Errors)]


def test_resolution():
    heading = readings(white_deg=0.2, resolution_deg=0.5).headings.heading_deg
    assert np.abs(heading / 0.5 - np.rint(heading / 0.5)).max() < 1e-9


def test_stamps_are_late_jitter_and_drift_as_set():
    stamp = readings(rate_hz=10.0, stamp_offset_s=0.4, stamp_jitter_s=0.02,
                     clock_drift_ppm=50.0).headings.stamp_ns
    late_s = (stamp - START_NS) / 1e9 - 0.1 * np.arange(stamp.size)
    late_s -= 0.4 + 50e-6 * 0.1 * np.arange(stamp.size)
    assert late_s.min() == pytest.approx(-0.02, abs=1e-4)
    assert late_s.max() == pytest.approx(0.02, abs=1e-4)
    assert (np.diff(stamp) > 0).all()


def test_dropouts_are_as_frequent_as_set():
    """100000 readings, one in ten lost: 10000 +- 6 x 95."""
    assert 90000 - 570 < len(readings(10000.0, dropout=0.1)) < 90000 + 570
    assert len(readings(10.0, dropout=1.0)) == 0


def test_latency_does_not_touch_the_readings():
    assert readings(latency_s=2.0, white_deg=0.1).headings == readings(white_deg=0.1).headings


def test_the_two_roles_have_their_own_noise():
    ship = ShipTruth([Leg(0.0, 0.0, 0.0)], 45.0)
    ts, rs = (SimulatedSensor(Sensor(white_deg=0.1), ship, 0, 3, role).take(100.0)
              for role in ('ts', 'rs'))
    both = np.corrcoef(wrap180(ts.headings.heading_deg), wrap180(rs.headings.heading_deg))
    assert abs(both[0, 1]) < 6.0 / math.sqrt(1000.0)


def test_the_deviation_by_hand():
    """At 30 deg: 0.4 sin 30 - 0.3 cos 30 + 0.2 sin 60 + 0.1 cos 60 = 0.2 - 0.0866 + 0.05."""
    read = readings(10.0, course_deg=30.0, deviation='0.4 -0.3 0.2 0.1').headings.heading_deg
    assert read == pytest.approx(30.0 + 0.25 - 0.1 * math.sqrt(3.0) / 2.0)


def test_invalid_readings_claim_nothing():
    read = next(Simulation(Scenario.from_mapping({
        'duration_s': 10.0, 'ts.faults': '5 invalid'})).chunks()).ts_readings
    assert np.isnan(read.sigma_deg).tolist() == np.isnan(read.headings.heading_deg).tolist()
    assert np.isnan(read.sigma_deg).sum() == 50


@pytest.mark.parametrize('settings, reason', [
    ({'model': 'magnetic'}, "model = 'magnetic': must be 'ideal' or"),
    ({'rate_hz': 0.0}, 'rate_hz = 0.0: must be a number from'),
    ({'stamp_jitter_s': 0.05, 'rate_hz': 10.0}, 'stamp_jitter_s = 0.05: must be less than'),
    ({'faults': '5 melt'}, "kind 'melt'"),
    ({'starts': '0 0.1'}, 'time must exceed that of the start before'),
    ({'deviation': '0.1 0.2'}, 'must be four numbers'),
    ({'deviation': '1 2 3 x'}, "coefficient 'x'"),
    ({'dropout': 1.5}, 'dropout = 1.5')])
def test_wrong_settings_are_refused(settings, reason):
    with pytest.raises(SettingsError, match=reason):
        Sensor(**settings)
