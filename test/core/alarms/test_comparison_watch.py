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

"""The detectors of the verdict on the newest pairs."""

from __future__ import annotations

from pathlib import Path
import sys

import numpy as np
import pytest

from heading_intercompare.core.alarms.alarm import AlarmState
from heading_intercompare.core.alarms.comparison_watch import COMPARISON_RULES, ComparisonWatch
from heading_intercompare.core.alarms.motion_watch import MOTION_RULES
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.validity import CONDITIONS

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / 'benchmarks'))

from made_up_ships import (  # noqa: E402
    KINDS,
    NORMS,
    norms_of,
    raised,
    T0_NS,
    voyage,
    watch,
)


@pytest.mark.slow
@pytest.mark.parametrize('kind', KINDS)
def test_sound_sensors_raise_nothing(rng, kind):
    changes, table = watch(*voyage(rng, span_s=400.0, **KINDS[kind]), **norms_of(kind))
    assert raised(changes) == []
    assert {alarm.state for alarm in table.alarms} == {AlarmState.NORMAL}


@pytest.mark.slow
@pytest.mark.parametrize('name', ['gyr1-s330', 'gyr1-seap', 'seap-s330', 'adcp-s330', 'lgyr-lsep'])
def test_real_ships_raise_nothing(real, name):
    """A quarter of an hour each, at 1 to 10 Hz; the data of the gyro are 1.2 s old."""
    pairs, _ = real(name)
    t = (pairs.stamp_ns - pairs.stamp_ns[0]) / 1e9
    assert raised(watch(t, pairs.ts_deg, pairs.rs_deg)[0]) == []


def first(changes, name):
    """Return when an alarm was first raised."""
    return next(t for t, alarm in changes if alarm.rule.name == name and alarm.state.active)


def last(changes, name):
    """Return when an alarm cleared for the last time."""
    t, alarm = [(t, alarm) for t, alarm in changes if alarm.rule.name == name][-1]
    assert alarm.state is AlarmState.RECTIFIED
    return t


@pytest.mark.slow
@pytest.mark.parametrize('off_deg', [90.0, -90.0, 180.0])
@pytest.mark.parametrize('motion', ['alongside', 'turning'])
def test_a_quarter_turn_is_raised_within_3_s_and_is_not_also_a_jump(rng, off_deg, motion):
    t, ts, rs = voyage(rng, motion=motion, span_s=200.0)
    ts[(t >= 100.3) & (t < 150.0)] += off_deg
    changes, _ = watch(t, ts % 360.0, rs)
    assert raised(changes) == ['rotated']
    assert 100.3 < first(changes, 'rotated') <= 103.3
    assert 150.0 < last(changes, 'rotated') <= 160.0


def test_a_rotation_from_the_start_leaves_no_false_level_behind(rng):
    t, ts, rs = voyage(rng, span_s=200.0)
    ts[t < 100.0] += 90.0
    changes, _ = watch(t, ts % 360.0, rs)
    assert raised(changes) == ['rotated'] and first(changes, 'rotated') <= 3.0


@pytest.mark.slow
@pytest.mark.parametrize('motion', ['swell', 'turning'])
@pytest.mark.parametrize('rate_hz', [1.0, 10.0])
def test_a_mirrored_sensor_is_raised_by_the_first_turn_and_is_not_also_a_jump(rng, motion,
                                                                              rate_hz):
    """The first turn begins at 60 s; the yaw in a swell shows it earlier."""
    t, ts, rs = voyage(rng, motion=motion, rate_hz=rate_hz, span_s=400.0)
    mirrored = t < 200.0
    ts[mirrored] = 50.0 - ts[mirrored]
    changes, table = watch(t, ts % 360.0, rs)
    assert first(changes, 'mirrored') <= (66.0 if motion == 'turning' else 40.0)
    assert 'jump' not in raised(changes)
    assert not table['mirrored'].state.active
    assert 'counts counter-clockwise' in table['mirrored'].words


@pytest.mark.slow
@pytest.mark.parametrize('sensor', ['ts', 'rs'])
@pytest.mark.parametrize('rate_hz', [1.0, 10.0])
def test_a_sensor_that_freezes_in_a_turn_is_raised_alone(rng, sensor, rate_hz):
    """The turn goes on from 180 s; frozen for 5 s at least, or four readings more at 1 Hz."""
    t, ts, rs = voyage(rng, motion='turning', rate_hz=rate_hz, span_s=260.0)
    frozen = (t >= 182.0) & (t < 230.0)
    one = ts if sensor == 'ts' else rs
    one[frozen] = one[frozen][0]
    changes, _ = watch(t, ts, rs)
    assert raised(changes) == [f'{sensor}_frozen']
    assert first(changes, f'{sensor}_frozen') <= 182.0 + (9.0 if rate_hz > 1.0 else 15.0)
    assert 230.0 < last(changes, f'{sensor}_frozen') <= 236.0


@pytest.mark.slow
def test_a_sensor_that_repeats_its_value_alongside_is_not_frozen(rng):
    """Tenths of a degree, and errors far below: one value for five minutes."""
    t, ts, rs = voyage(rng, motion='alongside', ts_deg=0.004, rs_deg=0.004, step_deg=0.1)
    assert np.ptp(ts) == 0.0
    assert raised(watch(t, ts, rs)[0]) == []


@pytest.mark.slow
def test_a_ship_that_steadies_does_not_thaw_the_sensor(rng):
    """Frozen in a turn that ends: the alarm stays while the value stays."""
    t, ts, rs = voyage(rng, motion='turning', span_s=300.0)
    frozen = t >= 182.0
    ts[frozen] = ts[frozen][0]
    changes, table = watch(t, ts, rs)
    assert table['ts_frozen'].state is AlarmState.UNACKNOWLEDGED
    assert raised(changes) == ['ts_frozen']


@pytest.mark.slow
@pytest.mark.parametrize('rate_hz, within_s', [(10.0, 34.0), (100.0, 6.0)])
def test_a_copy_is_raised_after_300_readings_and_cleared_by_the_noise_of_two(rng, rate_hz,
                                                                            within_s):
    t, ts, rs = voyage(rng, rate_hz=rate_hz, span_s=160.0)
    copy = (t >= 60.0) & (t < 110.0)
    ts[copy] = rs[copy]
    changes, _ = watch(t, ts, rs)
    assert raised(changes) == ['same_source']
    assert first(changes, 'same_source') <= 60.0 + within_s
    assert last(changes, 'same_source') <= 110.0 + 30.0


@pytest.mark.slow
def test_a_late_copy_is_found_by_its_noise(rng):
    t, _, rs = voyage(rng, span_s=200.0)
    ts = np.interp(t - 0.25, t, np.unwrap(rs, period=360.0)) % 360.0
    changes, _ = watch(t, ts, rs)
    assert raised(changes) == ['same_source'] and first(changes, 'same_source') <= 100.0


@pytest.mark.slow
def test_a_step_of_the_skew_is_found_in_the_window(rng):
    """Two minutes of yaw show the skew after the step: it needs two parts of a minute."""
    t, ts, rs = voyage(rng, span_s=600.0, rate_hz=4.0)
    late = np.interp(t - 1.0, t, np.unwrap(ts, period=360.0))
    ts = np.where(t >= 350.0, late, ts) % 360.0
    changes, table = watch(t, ts, rs)
    assert first(changes, 'clock_step') <= 350.0 + 190.0
    assert abs(abs(table['clock_step'].values['step_s']) - 1.0) < 0.1


def test_the_end_of_a_silence_or_a_new_run_begins_with_a_new_level(rng):
    """After a silence that ends a run the TS stands 4 deg off: that is another run."""
    t, ts, rs = voyage(rng, span_s=240.0)
    gone = (t > 100.0) & (t < 180.0)
    ts = np.where(t >= 180.0, ts + 4.0, ts) % 360.0
    assert raised(watch(t[~gone], ts[~gone], rs[~gone])[0]) == []


def test_without_new_pairs_there_is_nothing_to_say(rng):
    watcher = ComparisonWatch(Settings.from_mapping(NORMS))
    assert watcher.look() == {}
    watcher.update(Pairs.empty())
    assert watcher.look() == {}
    watcher.update(Pairs.of([T0_NS], [10.0], [10.0]))
    assert watcher.look() and watcher.look() == {}


@pytest.mark.parametrize('piece', [1, 7, 1000])
def test_the_signs_do_not_depend_on_how_the_stream_is_cut(rng, piece):
    t, ts, rs = voyage(rng, span_s=60.0)
    ts[(t >= 40.0)] += 7.0
    stamps = T0_NS + np.rint(t * 1e9).astype(np.int64)
    pairs = Pairs.of(stamps, ts % 360.0, rs)
    whole, cut = (ComparisonWatch(Settings.from_mapping(NORMS)) for _ in range(2))
    for lo in range(0, len(pairs), 10):
        whole.update(pairs[lo:lo + 10])
        for at in range(lo, lo + 10, piece):
            cut.update(pairs[at:min(at + piece, lo + 10)])
        assert whole.look() == cut.look()


@pytest.mark.slow
def test_a_look_costs_no_more_after_a_day(rng):
    """A thousand pairs per look for an hour: the window holds 65536, whatever came before."""
    watcher = ComparisonWatch(Settings.from_mapping(NORMS))
    for at in range(400):
        stamps = T0_NS + at * 10 ** 9 + np.arange(1000) * 10 ** 6
        watcher.update(Pairs.of(stamps, rng.normal(90.0, 0.1, 1000), rng.normal(90.0, 0.1, 1000)))
    assert len(watcher._window) == 1 << 16
    assert len(watcher._window._stamps) == 1 << 17


def test_every_condition_that_voids_a_run_is_watched():
    """By detectors of its own, or as a condition of the window; by the ledger at the end."""
    names = {rule.name for rule in (*COMPARISON_RULES, *MOTION_RULES)}
    for condition in CONDITIONS:
        assert set(condition.watched_by) <= names
        watched = condition.is_alarm and condition.name in names or bool(condition.watched_by)
        assert watched or not condition.void or condition.judge is None


@pytest.mark.slow
def test_an_rs_out_of_its_norm_is_raised_by_the_condition_of_the_verdict(rng):
    """White noise of the RS of three norms from 400 s to 1400 s; the window is 600 s."""
    t, ts, rs = voyage(rng, span_s=2400.0)
    rs = (rs + 0.4 * rng.standard_normal(t.size) * ((t >= 400.0) & (t < 1400.0))) % 360.0
    changes, table = watch(t, ts, rs)
    assert {'reference'} <= set(raised(changes)) <= {'reference', 'outliers'}
    assert 460.0 <= first(changes, 'reference') <= 400.0 + 900.0
    assert last(changes, 'reference') <= 1400.0 + 900.0
    assert 'RS' in table['reference'].words


def test_one_course_for_minutes_before_a_fault_does_not_blame_another_condition(rng):
    """A quarter turn for a minute: the mean of the window is far off afterwards."""
    t, ts, rs = voyage(rng, rate_hz=1.0, span_s=500.0)
    ts = np.where((t >= 200.0) & (t < 260.0), ts + 90.0, ts) % 360.0
    assert raised(watch(t, ts, rs)[0]) == ['rotated']
