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

"""Steps of stamps by hand; losses are found, whatever the jitter."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.declared_settings import from_mapping, SettingsError
from heading_intercompare.core.settings import Detectors
from heading_intercompare.core.timing.stamp_steps import measure_stamp_steps
from heading_intercompare.drivers.logs import read_log


def test_steps_of_stamps_by_hand():
    found = measure_stamp_steps(np.array([0, 1, 2, 2, 3, 1, 2, 3, 60]) * 10 ** 9)
    assert (found.n, found.typical_s) == (9, 1.0)
    assert (found.backward, found.equal, found.silences) == (1, 1, 1)
    assert (found.longest_back_s, found.longest_s) == (2.0, 57.0)


def test_clock_steps_of_a_replayed_log_are_seen(shared_data):
    """The lines of nbp1700_replay: one step of -0.93 s and a jump of at least an hour."""
    path = next((shared_data / 'nbp1700_replay').glob('*gyr1*'))
    found = measure_stamp_steps(read_log(path)[0].stamp_ns)
    assert found.backward >= 1
    assert found.longest_back_s == pytest.approx(0.93, abs=0.3)
    assert found.longest_s == pytest.approx(3600.0, abs=2.0)


def test_the_steps_of_a_long_record_are_all_counted(rng):
    """Two silences, three steps back and an equal stamp, in pieces of 40000 and at their seams."""
    steps = 10 ** 7 + rng.integers(-10 ** 4, 10 ** 4, 400_000)
    steps[[39_999, 40_000, 123_456]] = -5 * 10 ** 6
    steps[[80_000, 399_999]] = 3 * 10 ** 9
    steps[7] = 0
    found = measure_stamp_steps(10 ** 18 + np.cumsum(steps))
    # The first step lies before the first stamp.
    assert (found.n, found.backward, found.equal, found.silences) == (400_000, 3, 1, 2)
    assert (found.longest_back_s, found.longest_s) == (0.005, 3.0)
    assert found.typical_s == pytest.approx(0.01, rel=1e-4)
    assert found.nominal_s == pytest.approx(0.01, rel=1e-3)
    assert found.lost_share == pytest.approx(598.0 / 400_600.0, rel=0.02)


@pytest.mark.parametrize('n', [0, 1])
def test_too_few_stamps_have_no_steps(n):
    found = measure_stamp_steps(np.arange(n))
    assert (found.n, found.typical_s, found.silences) == (n, None, 0)


def test_equal_stamps_are_no_silence():
    found = measure_stamp_steps([5, 5, 5, 100])
    assert (found.equal, found.silences) == (2, 0)


def test_settings_of_the_detectors_are_checked():
    assert from_mapping(Detectors, {'mean_max_deg': 3}).mean_max_deg == 3.0
    with pytest.raises(SettingsError, match='mean_max_deg = 200.0'):
        Detectors(mean_max_deg=200.0)


def test_the_step_of_a_sensor_shows_although_most_readings_are_missing(rng):
    """Two of five kept: the median step is 0.2 s, that of the sensor 0.1 s."""
    stamps = np.flatnonzero(rng.random(10_000) < 0.4) * 10 ** 8
    found = measure_stamp_steps(stamps)
    assert (found.typical_s, found.nominal_s) == (0.2, 0.1)


def test_steps_without_a_common_measure_have_none(rng):
    assert measure_stamp_steps(np.cumsum(1 + rng.integers(0, 10 ** 9, 10_000))).nominal_s is None


def test_the_step_of_a_sensor_survives_jitter(rng):
    stamps = np.arange(5000) * 10 ** 8 + rng.integers(-10 ** 6, 10 ** 6, 5000)
    assert measure_stamp_steps(stamps).nominal_s == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize('apart_s', [0.001, 0.003, 0.005, 0.01, 0.02, 0.03])
def test_sentences_in_twins_lose_nothing(apart_s):
    """HDT and THS of one reading: 0.1 s is no multiple of 3 ms, nor twenty of 5 ms lost."""
    t = np.arange(12_000) * 0.1
    found = measure_stamp_steps(stamps_at(t, t + apart_s))
    assert found.nominal_s == pytest.approx(0.1, rel=0.01) and found.lost_share == 0.0


def test_twins_do_not_hide_what_is_lost(rng):
    t = np.flatnonzero(rng.random(12_000) < 0.4) * 0.1
    assert measure_stamp_steps(stamps_at(t, t + 0.003)).lost_share == pytest.approx(
        1.0 - t.size / 12_000, abs=0.01)


def test_stamps_out_of_step_lose_nothing(rng):
    """A quarter of the readings twice; every fifth early; events; bursts, even and uneven."""
    t = np.arange(12_000) * 0.1
    pauses = np.cumsum(0.1 + rng.exponential(1.0, 1200))
    for stamps in (
            stamps_at(t, t[rng.random(t.size) < 0.25] + 0.003),
            stamps_at(t - 0.09 * (np.arange(t.size) % 5 == 0)),
            stamps_at(np.cumsum(rng.exponential(0.1, 12_000))),
            stamps_at(np.cumsum(rng.gamma(11.0, 0.1 / 11.0, 12_000))),
            stamps_at((np.arange(1200)[:, None] + np.arange(10) * 0.01).ravel()),
            stamps_at(*(start + 0.001 * np.arange(rng.integers(1, 30)) for start in pauses))):
        assert measure_stamp_steps(stamps).lost_share < 0.01


@pytest.mark.parametrize('jitter', ['none', 'uniform', 'normal'])
@pytest.mark.parametrize('lost', [0.0, 0.1, 0.11, 0.49, 0.52, 0.7])
def test_what_is_lost_at_random_is_found_in_spite_of_jitter(lost, jitter, rng):
    """Up to a fifth of the step, or with a standard deviation of a seventh of it."""
    n = 12_000
    off = {'none': 0.0, 'uniform': rng.uniform(-0.2, 0.2, n),
           'normal': 0.15 * rng.standard_normal(n)}[jitter]
    keep = rng.random(n) >= lost
    found = measure_stamp_steps(stamps_at((0.1 * (np.arange(n) + off))[keep]))
    assert found.lost_share == pytest.approx(
        1.0 - np.mean(keep), abs=0.02 if jitter == 'normal' else 0.001)


def test_what_is_lost_in_outages_is_found(rng):
    """Sixty percent of the time, in outages of two seconds; and 36 s of every minute."""
    t = np.arange(12_000) * 0.1
    edges = np.cumsum(np.stack((rng.exponential(4.0 / 3.0, 900),
                                rng.exponential(2.0, 900)), axis=1).ravel())
    keep = np.searchsorted(edges, t) % 2 == 0
    assert measure_stamp_steps(stamps_at(t[keep])).lost_share == pytest.approx(
        1.0 - np.mean(keep), abs=0.01)
    assert measure_stamp_steps(stamps_at(t[t % 60.0 >= 36.0])).lost_share == pytest.approx(
        0.59, abs=0.01)


def test_silences_of_a_sensor_out_of_step_are_lost(rng):
    """Half an hour of events, every fourth minute silent."""
    t = np.cumsum(rng.exponential(0.1, 18_000))
    assert measure_stamp_steps(stamps_at(t[t % 240.0 >= 60.0])).lost_share == pytest.approx(
        0.25, abs=0.02)


def test_stamps_of_a_sensor_slower_than_any_pause(rng):
    """Nothing shorter than five seconds, and half of the time in one silence."""
    t = np.append(np.arange(200.0) * 6.0, 3600.0) + rng.uniform(0.0, 5.0, 201)
    assert 0.5 < measure_stamp_steps(stamps_at(t)).lost_share < 0.7


def stamps_at(*seconds):
    return np.sort(np.rint(np.concatenate(seconds) * 1e9).astype(np.int64))
