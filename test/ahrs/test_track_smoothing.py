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

"""Records made smooth: outliers, gaps, missing velocities, and what is said about them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from heading_intercompare.ahrs.settings import TrackSettings
from heading_intercompare.ahrs.track_smoothing import fit_track, TrackRecord
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Attitude, Headings, Motion

START_NS = 1_400_000_000 * 10**9
FILE = {'file': 'x'}


def stamps(t_s):
    """Return the stamps of some seconds."""
    return START_NS + np.rint(np.asarray(t_s) * 1e9).astype(np.int64)


def turning(t_s):
    """Return a heading that swings through north, degrees."""
    return (350.0 + 30.0 * np.sin(2.0 * math.pi * np.asarray(t_s) / 200.0)) % 360.0


def test_outliers_are_left_out_and_counted(rng):
    """One of 180 degrees, a burst of three, one nan, and five that repeat a stamp."""
    t_s = np.arange(0.0, 600.0, 0.5)
    heading = turning(t_s) + 0.02 * rng.standard_normal(t_s.size)
    for k, off in ((100, 180.0), (400, 40.0), (401, 40.0), (402, 40.0)):
        heading[k] += off
    heading[700] = np.nan
    twice = np.concatenate((t_s, t_s[200:205]))
    made = fit_track(TrackRecord(Headings(stamps(twice), np.concatenate(
        (heading, heading[200:205] + 1.0)) % 360.0)), TrackSettings(**FILE))
    account, = made.accounts
    assert (account.spikes, account.repeated, account.gaps) == (4, 5, 0)
    at = np.linspace(1.0, 598.0, 777)
    off = np.degrees(made.track.heading_rad.read(at)) - turning(at)
    assert np.abs((off + 180.0) % 360.0 - 180.0).max() < 0.1
    assert '4 outliers' in account.words and '5 with the stamp of another' in account.words
    assert account.removed == pytest.approx(0.02, rel=0.3)


def test_two_sensors_in_one_record_are_no_voyage():
    """Four samples of one sensor, then one of another that is 40 degrees off."""
    t_s = np.arange(0.0, 300.0, 0.5)
    mixed = (turning(t_s) + 40.0 * (np.arange(t_s.size) % 5 == 4)) % 360.0
    with pytest.raises(SettingsError, match=r'120 of 600 samples of heading are outliers; must be '
                       r'at most 10%: give the samples of one sensor'):
        fit_track(TrackRecord(Headings(stamps(t_s), mixed)), TrackSettings(**FILE))


def test_a_gap_is_bridged_and_said():
    t_s = np.concatenate((np.arange(0.0, 100.0, 0.5), np.arange(120.0, 300.0, 0.5)))
    made = fit_track(TrackRecord(Headings(stamps(t_s), turning(t_s))), TrackSettings(**FILE))
    assert '1 gaps bridged, the longest 20.5 s' in made.words[0]
    with pytest.raises(SettingsError, match=r'longest_gap_s = 10.0: the record has no heading for '
                       r'20.5 s; begin after the gap'):
        fit_track(TrackRecord(Headings(stamps(t_s), turning(t_s))),
                     TrackSettings(longest_gap_s=10.0, **FILE))
    later = fit_track(TrackRecord(Headings(stamps(t_s), turning(t_s))),
                         TrackSettings(longest_gap_s=10.0, begin_s=120.0, **FILE))
    assert later.track.start_ns == int(stamps([120.0])[0])
    assert later.track.duration_s == pytest.approx(179.5)


def test_slow_samples_make_the_period_longer():
    """At 0.1 Hz nothing faster than four samples can be told."""
    t_s = np.arange(0.0, 2000.0, 10.0)
    made = fit_track(TrackRecord(Headings(stamps(t_s), turning(t_s))), TrackSettings(**FILE))
    assert made.accounts[0].period_s == pytest.approx(40.0)


@pytest.mark.parametrize('kind', ['velocity', 'position', 'none'])
def test_the_velocity_is_recorded_or_between_positions_or_set(kind):
    """Five m/s to the north in each case."""
    t_s = np.arange(0.0, 600.0)
    rows = {'velocity': Motion.of_velocities(stamps(t_s), 0.0 * t_s, 5.0 + 0.0 * t_s),
            'position': Motion.of_positions(stamps(t_s), 50.0 + 5.0 * t_s / 111_229.0,
                                            10.0 + 0.0 * t_s),
            'none': Motion.empty()}[kind]
    made = fit_track(TrackRecord(Headings(stamps(t_s), 0.0 * t_s), rows),
                        TrackSettings(speed_kn=5.0 * 3600.0 / 1852.0, **FILE))
    at = np.array([50.0, 300.0])
    assert made.track.north_m_s.read(at) == pytest.approx([5.0, 5.0], abs=0.002)
    assert made.track.east_m_s.read(at) == pytest.approx([0.0, 0.0], abs=0.002)
    assert made.track.position_deg == ((50.0, 10.0) if kind == 'position' else None)
    said = ' '.join(made.words)
    assert ('that between the positions' in said) is (kind == 'position')
    assert ('along the heading' in said) is (kind == 'none')


def test_the_integral_of_the_velocity_is_compared_with_the_fixes():
    """A velocity that is 0.1 m/s too fast leads 60 m away in 10 min."""
    t_s = np.arange(0.0, 601.0)
    rows = Motion.concatenate([
        Motion.of_velocities(stamps(t_s), 0.0 * t_s, 5.1 + 0.0 * t_s),
        Motion.of_positions(stamps(t_s), 50.0 + 5.0 * t_s / 111_229.0, 10.0 + 0.0 * t_s)])
    made = fit_track(TrackRecord(Headings(stamps(t_s), 0.0 * t_s), rows), TrackSettings(**FILE))
    assert 'stays within 60 m of the fixes' in made.words[-1]


def test_roll_and_pitch_come_along():
    t_s = np.arange(0.0, 120.0, 0.2)
    roll, pitch = 4.0 * np.sin(t_s), 1.0 * np.cos(t_s)
    made = fit_track(TrackRecord(Headings(stamps(t_s), 0.0 * t_s),
                                    attitude=Attitude.of(stamps(t_s), roll, pitch)),
                        TrackSettings(**FILE)).track
    at = np.linspace(10.0, 100.0, 99)
    assert np.degrees(made.roll_rad.read(at)) == pytest.approx(4.0 * np.sin(at), abs=0.08)
    assert np.degrees(made.pitch_rad.read(at)) == pytest.approx(np.cos(at), abs=0.02)


@pytest.mark.parametrize('t_s, given, words', [
    ([], {}, 'has no heading'), ([0.0, 3.0], {}, 'leaves 3.0 s of the headings'),
    ([0.0, 100.0], {'begin_s': 95.0}, 'begin_s = 95.0: leaves 5.0 s')])
def test_a_record_that_is_too_short(t_s, given, words):
    with pytest.raises(SettingsError, match=words):
        fit_track(TrackRecord(Headings(stamps(t_s), 0.0 * np.array(t_s))),
                     TrackSettings(**given, **FILE))
