# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The status of an AHRS, its modes and built-in tests, from power-on to a fault and back."""

from __future__ import annotations

from dataclasses import replace
import math

import pytest

from heading_intercompare.ahrs.gimballed.condition import describe_condition, progress, self_tests
from heading_intercompare.ahrs.gimballed.modes import Mode, Validity
from heading_intercompare.ahrs.settings import Ahrs, Scenario
from heading_intercompare.ahrs.simulator import Simulation

IN_ORDER = ['POST', 'THERMOSTAT_WAIT', 'COARSE_LEVELLING', 'GYRO_CALIBRATION',
            'AZIMUTH_ALIGNMENT', 'FINE_LEVELLING', 'GYROCOMPASS']


@pytest.fixture(scope='module')
def start():
    """Return the statuses of a cold start, noise off; the gyro fails after 5100 s."""
    scenario = Scenario.from_mapping({
        'duration_s': 5200.0, 'ts': {'model': 'dtg_precision', 'rate_hz': 0.1, 'ahrs': {
            'noise': False, 'events': '5100 fail_gyro'}}, 'rs.rate_hz': 0.1})
    return next(Simulation(scenario).chunks(6000.0)).ts_statuses


def of_mode(start, mode):
    """Return the statuses in one mode."""
    return [status for status in start if status.mode == mode]


@pytest.mark.slow
@pytest.mark.parametrize('mode', IN_ORDER)
def test_progress_rises_from_0_to_1_in_every_mode(start, mode):
    """At most a few seconds of a mode, such as the slew, come after its least time."""
    said = of_mode(start, mode)
    shares = [status.progress for status in said]
    assert shares[0] < 0.02 and shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0, abs=0.1 if mode == 'POST' else 0.01)
    assert said[0].mode_s < 0.1
    assert said[-1].mode_s == pytest.approx(said[-1].t_s - said[0].t_s, abs=0.1)


def test_progress_of_heating_goes_with_the_time_that_is_left():
    """40 K die away to 0.5 K with 200 s: half of it when 40 sqrt(0.5/40) K are left."""
    half_k = 40.0 * math.sqrt(0.5 / 40.0)
    for away_k, share in ((-40.0, 0.0), (-half_k, 0.5), (-0.3, 1.0)):
        assert progress(Mode.THERMOSTAT_WAIT, 5.0, Validity.NONE, away_k,
                        Ahrs()) == pytest.approx(share)


def test_progress_of_operation():
    settings = Ahrs(sigma_1_s=2e-3)
    for mode, validity, share in ((Mode.GYROCOMPASS, Validity.SETTLING, 0.5),
                                  (Mode.GYROCOMPASS, Validity.VALID, 1.0),
                                  (Mode.GYRO_AZIMUTH, Validity.VALID, 1.0),
                                  (Mode.FAULT, Validity.NONE, 0.0)):
        assert progress(mode, 750.0, validity, 0.0, settings) == share


@pytest.mark.slow
def test_built_in_tests_are_passed_one_after_the_other(start):
    passed = [sum(result == 'passed' for _, result in of_mode(start, mode)[-1].tests)
              for mode in IN_ORDER]
    assert passed == [0, 4, 6, 7, 7, 8, 8]


def test_failed_test_is_told_and_the_others_keep_their_results(start):
    last = start[-1]
    assert last.mode == 'FAULT' and last.faults == ('gyro',)
    assert dict(last.tests) == {**self_tests(Mode.GYROCOMPASS, []), 'gyro': 'failed'}
    assert describe_condition(last).level == 'error'
    assert describe_condition(last).words == 'fault: gyro'


@pytest.mark.slow
def test_words_and_levels(start):
    heating = describe_condition(of_mode(start, 'THERMOSTAT_WAIT')[0])
    assert (heating.level, heating.words) == ('warn', 'thermostat wait, no heading yet, 1%')
    compass = of_mode(start, 'GYROCOMPASS')
    settling, settled = describe_condition(compass[0]), describe_condition(compass[-1])
    assert (settling.level, settling.words) == ('warn', 'gyrocompass, heading settling, 0%')
    assert (settled.level, settled.words) == ('ok', 'gyrocompass, heading valid')


def test_figures_leave_out_what_is_unknown(start):
    cold, settled = describe_condition(start[0]).figures, describe_condition(of_mode(
        start, 'GYROCOMPASS')[-1])
    assert 'sigma_deg' not in cold and cold['event'] == 'mode POST'
    assert cold['temperature_c'] == pytest.approx(20.0)
    assert settled.figures['sigma_deg'] > 0.0 and 'event' not in settled.figures
    assert settled.figures['test_alignment'] == 'passed'
    assert {type(value) for value in settled.figures.values()} <= {str, int, float}


def test_degraded_ahrs_warns(start):
    degraded = replace(of_mode(start, 'GYROCOMPASS')[-1], flags=('DEGRADED', 'NO_SPEED'))
    assert describe_condition(degraded).level == 'warn'
    assert describe_condition(degraded).words == 'gyrocompass, heading valid, degraded no speed'
