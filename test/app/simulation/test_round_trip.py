# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated trial, taken as the voyage of another one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.ahrs.settings import Scenario, TrackSettings
from heading_intercompare.ahrs.simulator import Simulation
from heading_intercompare.app.simulation.voyage import read_voyage
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.core.angles import wrap180

TRIAL = """\
title: The first voyage
duration_s: 900
start_utc: '2026-05-06T07:08:09Z'
seed: 4
seaway: ss3
latitude_deg: 54.0
legs: 0 350 12; 200 80 12; 500 200 8
ts: {rate_hz: 10, white_deg: 0.1, markov_deg: 0.05, markov_tau_s: 5}
rs: {rate_hz: 10, white_deg: 0.05}
"""
NORMS = Settings.from_mapping({'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1,
                               'risk.slowest_error_s': 30.0})


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    folder = tmp_path_factory.mktemp('voyage')
    (folder / 'trial.yaml').write_text(TRIAL, encoding='utf-8')
    assert main(['simulate', '--scenario', str(folder / 'trial.yaml'), '-o',
                 str(folder / 'bag')]) == 0
    return folder / 'bag'


def headings(bag, topic):
    """Return all headings of a topic."""
    return Headings.concatenate(c[topic] for c in BagReader(bag).headings({topic: 'enu'}))


def repeat(bag: Path, **given):
    """Return the scenario sailed again on this bag, and its chunks."""
    scenario = Scenario.from_mapping({
        'duration_s': 900.0, 'seed': 9, 'track.file': str(bag),
        **{f'track.{name}': value for name, value in given.items()},
        'ts': {'white_deg': 0.1, 'markov_deg': 0.05, 'markov_tau_s': 5.0},
        'rs': {'white_deg': 0.05}})
    track = read_voyage(scenario.track).track
    return list(Simulation(scenario, track=track).chunks())


@pytest.mark.parametrize('topic, limit_deg, rms_deg', [
    ('truth/heading', 0.02, 0.003), ('ts/heading', 0.35, 0.06)])
def test_the_true_heading_comes_back(bag, topic, limit_deg, rms_deg):
    """
    From the truth within 0.02 degrees at the ends, and 0.003 rms.

    From the TS with what is slow of its errors: of white noise of 0.1 degrees at 10 Hz, smoothed
    over 3 s, a quarter stays.
    """
    true = headings(bag, 'truth/heading')
    again = Headings.concatenate(chunk.truth for chunk in repeat(bag, heading=topic))
    n = len(again)
    assert 8990 <= n <= 9000 and again.stamp_ns.tolist() == true.stamp_ns[:n].tolist()
    off = wrap180(again.heading_deg - true.heading_deg[:n])
    assert np.abs(off).max() < limit_deg
    assert np.sqrt(np.mean(off**2)) < rms_deg


def test_position_and_speed_come_back(bag):
    """Within the noise of the receiver, 1 m and 0.05 m/s, smoothed over a minute."""
    voyage = read_voyage(TrackSettings(file=str(bag)))
    truth = Simulation(Scenario.from_mapping({
        'legs': '0 350 12; 200 80 12; 500 200 8', 'latitude_deg': 54.0, 'seed': 4,
        'seaway': 'ss3'})).truth()
    t_s = np.arange(20.0, 880.0)
    east, north = truth.velocity_m_s(t_s)
    steady = (np.abs(t_s - 240.0) > 80.0) & (np.abs(t_s - 570.0) > 110.0)
    for found, true in ((voyage.track.east_m_s, east), (voyage.track.north_m_s, north)):
        off = found.read(t_s) - true
        assert np.abs(off[steady]).max() < 0.05
        assert np.abs(off).max() < 0.8


def test_the_verdict_on_an_identical_sensor_is_of_the_same_kind(bag):
    first = analyze(headings(bag, 'ts/heading'), headings(bag, 'rs/heading'), NORMS)
    chunks = repeat(bag)
    ts, rs = (Headings.concatenate(getattr(chunk, role) for chunk in chunks)
              for role in ('ts', 'rs'))
    assert analyze(ts, rs, NORMS).outcome == first.outcome
    assert first.outcome.value == 'compliant'


def test_only_simulate_reads_a_voyage(bag):
    with pytest.raises(ValueError, match='only the command simulate reads a recorded voyage'):
        Simulation(Scenario.from_mapping({'track.file': str(bag)}))
