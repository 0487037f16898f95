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

"""The loop on records gives the same bits as on objects, compiled by numba or interpreted."""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import pytest

from heading_intercompare.ahrs.gimballed.gimballed_ahrs import GimballedAhrs
from heading_intercompare.ahrs.inertial import compiled_loop, loop
from heading_intercompare.ahrs.plans import parse_legs
from heading_intercompare.ahrs.random_noise import Markov, open_stream, recur
from heading_intercompare.ahrs.sensor_presets import ERRORS
from heading_intercompare.ahrs.settings import Ahrs, Scenario
from heading_intercompare.ahrs.ship.course import Current
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.ahrs.ship.steering import Leg, sail, Steering
from heading_intercompare.ahrs.simulator import Simulation

SETTINGS = {
    'gyrocompass': {'initial_state': 'aligned', 'events': '5.35 log_lost; 80 log_found'},
    'commands': {'initial_state': 'aligned', 'operation': 'gyro_azimuth',
                 'events': '10.05 gps_found; 20.1 gyrocompass; 40 power_dip; 61 gps_lost'},
    'schuler': {'initial_state': 'aligned', 'operation': 'gyro_azimuth', 'vertical': 'schuler',
                'own_latitude': True},
    'levelling': {'initial_state': 'warm', 'hold_s': 20.0, 'speed_compensation': 'manual',
                  'manual_speed_kn': 11.0}}


def said(settings, fast, blocks=20):
    """Return the tracks and statuses of an AHRS of the class imo in sea state 5, as text."""
    ship = ShipTruth([Leg(0.0, 40.0, 12.0), Leg(60.0, 90.0, 12.0)], 50.0, 0.0, 'ss5', 4)
    ahrs = GimballedAhrs(Ahrs(**settings), ERRORS['imo'], ship, 4, 'ts', fast)
    assert (ahrs._compiled is not None) is fast
    tracks = [ahrs.block() for _ in range(blocks)]
    return [(track.azimuth_rad.tobytes(), track.error_rad.tobytes(), track.alpha_rad.tobytes(),
             track.beta_rad.tobytes(), track.sigma_rad.tobytes(), track.mode.tolist(),
             track.validity.tolist(), repr(track.statuses)) for track in tracks]


@pytest.mark.parametrize('settings', SETTINGS.values(), ids=SETTINGS)
def test_loop_on_records_gives_the_same_bits(settings, monkeypatch):
    """A record of numpy has attributes, so the interpreter can do what numba compiles."""
    def enter(law, p, c, i, t, *inputs):
        loop.run(law, *(one.view(np.recarray)[0] for one in (p, c, i, t)), *inputs)
    made = compiled_loop._Compiled(enter, recur, sail)
    monkeypatch.setattr(compiled_loop, '_compile', lambda: made)
    monkeypatch.setattr(compiled_loop, 'find_spec', lambda _: True)
    assert said(settings, True) == said(settings, False)


@pytest.mark.slow
@pytest.mark.skipif(not find_spec('numba'), reason='numba is not installed (extra fast)')
@pytest.mark.parametrize('settings', SETTINGS.values(), ids=SETTINGS)
def test_compiled_loop_gives_the_same_bits(settings):
    assert said(settings, True) == said(settings, False)


@pytest.mark.slow
@pytest.mark.skipif(not find_spec('numba'), reason='numba is not installed (extra fast)')
def test_long_trial_is_compiled_and_the_same(monkeypatch):
    monkeypatch.setattr('heading_intercompare.ahrs.simulator.WORTH_COMPILING_S', 60.0)
    simulation = Simulation(Scenario.from_mapping({
        'duration_s': 120.0, 'seaway': 'ss3', 'ts.model': 'dtg_precision',
        'ts.ahrs.initial_state': 'aligned', 'rs.rate_hz': 1.0, 'rs.model': 'gnss_compass'}))
    made = [list(simulation.chunks(fast=fast)) for fast in (False, True)]
    for one, other in zip(*made):
        assert one.ts == other.ts and one.ts_statuses == other.ts_statuses
        assert one.rs == other.rs


@pytest.mark.parametrize('model, compiled', [('dtg_precision', True), ('fog_strapdown', False)])
def test_noise_of_the_other_sensor_is_compiled_where_the_loop_is(monkeypatch, model, compiled):
    quick = []
    made = compiled_loop._Compiled(None, quick.append, sail)
    monkeypatch.setattr(compiled_loop, '_compile', lambda: made)
    monkeypatch.setattr(compiled_loop, 'find_spec', lambda _: True)
    trial = Simulation(Scenario.from_mapping({
        'ts.model': model, 'rs.model': 'gnss_compass'})).begin(fast=True)
    assert (trial._senders['rs']._sensor._markov.recur == quick.append) is compiled


def sailed(compile_it, legs='0 30 10; 300 350 4; 900 20 14; 900.3 185 14; 5000 185 0'):
    """Return where a ship was in 2 h of turns through north and to the back, in a current."""
    course = Steering(parse_legs(legs), 59.9, 10.7, Current(70.0, 2.0), turn_deg_s=7.0)
    if compile_it:
        compiled_loop.compile_steering(course)
    assert (course.sail is sail) is not compile_it
    t_s = np.arange(0.0, 7300.0, 7.7)
    return [each.tolist() for each in (*course.read_heading(t_s), course.read_speed(t_s),
                                       *course.read_position(t_s), *course.read_way(t_s))]


def test_steering_on_arrays_gives_the_same_bits(monkeypatch):
    monkeypatch.setattr(compiled_loop, '_compile', lambda: compiled_loop._Compiled(
        None, None, lambda *given: sail(*given)))
    monkeypatch.setattr(compiled_loop, 'find_spec', lambda _: True)
    assert sailed(True) == sailed(False)


@pytest.mark.slow
@pytest.mark.skipif(not find_spec('numba'), reason='numba is not installed (extra fast)')
def test_compiled_steering_gives_the_same_bits():
    assert sailed(True) == sailed(False)


def test_without_numba_the_loop_is_interpreted(monkeypatch):
    monkeypatch.setattr(compiled_loop, 'find_spec', lambda _: None)
    ship = ShipTruth([Leg(0.0, 40.0, 12.0)], 50.0)
    assert GimballedAhrs(Ahrs(), ERRORS['imo'], ship, 4, 'ts', True)._compiled is None


def test_recursion_of_the_noise_has_the_same_bits():
    plain, other = (Markov(2.0, 30.0, 0.1, open_stream(1, 'm')) for _ in range(2))
    other.recur = recur
    assert np.array_equal(plain.take(1000), other.take(1000))
    assert np.array_equal(plain.take(7), other.take(7))
