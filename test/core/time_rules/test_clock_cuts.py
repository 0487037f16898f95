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

"""The instants at which the clock cuts: by hand, against a plain loop, and wrong ones."""

from __future__ import annotations

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.declared_settings import settings_sha256, SettingsError
from heading_intercompare.core.settings import RunCutting, Settings
from heading_intercompare.core.time_rules.clock_cuts import ClockCuts

S = 1_000_000_000
H = 3600 * S
DAY = 24 * H


def test_midnight_by_hand():
    """20 000 days after the epoch; a nanosecond before midnight still belongs to the day."""
    for cuts in (ClockCuts(24.0, None), ClockCuts(None, '00:00')):
        midnight = 20_000 * DAY
        assert cuts.last(midnight) == midnight
        assert cuts.last(midnight - 1) == midnight - DAY
        assert cuts.next(midnight) == midnight + DAY
        assert cuts.next(midnight - 1) == midnight
        assert cuts.before(midnight + H, 3) == midnight - 3 * DAY
        stamps = np.array([midnight - 1, midnight, midnight + 1])
        assert cuts.find_crossed(stamps, midnight - 2).tolist() == [1]


def test_watches_cut_six_times_a_day():
    watches = ClockCuts(None, '20:00,00:00,04:00,08:00,12:00,16:00')
    hours = ClockCuts(4.0, None)
    stamps = np.arange(0, 3 * DAY, 7 * 60 * S)
    assert watches.find_crossed(stamps, -1).tolist() == hours.find_crossed(stamps, -1).tolist()
    assert len(watches.find_crossed(stamps, 0)) == 17


def slow_cuts(every_h, times, lo_ns, hi_ns):
    """Return the cuts t with lo < t <= hi, by trying each minute."""
    minute = 60 * S
    return [t for t in range(lo_ns // minute * minute, hi_ns + 1, minute)
            if lo_ns < t <= hi_ns and (
                every_h is not None and t % round(every_h * H) == 0
                or times and (t % DAY) // minute in times)]


@given(every_min=st.none() | st.integers(7, 400), times=st.sets(st.integers(0, 1439), max_size=4),
       start_min=st.integers(-3000, 3000), steps=st.lists(st.integers(1, 900), min_size=1,
                                                          max_size=12))
def test_the_cuts_are_those_of_a_plain_loop(every_min, times, start_min, steps):
    if every_min is None and not times:
        return
    every_h = None if every_min is None else every_min / 60.0
    text = ','.join(f'{t // 60:02}:{t % 60:02}' for t in times) or None
    cuts = ClockCuts(every_h, text)
    stamps = start_min * 60 * S + np.cumsum(steps) * 60 * S
    before = start_min * 60 * S
    crossed = cuts.find_crossed(stamps, before).tolist()
    for at, (lo, hi) in enumerate(zip([before, *stamps.tolist()], stamps.tolist())):
        found = slow_cuts(every_h, times, lo, hi)
        assert (at in crossed) == bool(found)
        if found:
            assert (cuts.next(lo), cuts.last(hi)) == (found[0], found[-1])


@pytest.mark.parametrize('text', ['24:00', '8:00', '00:00;08:00', '', 'midnight', '00:60',
                                  '٠٠:٠٠'])
def test_a_time_that_is_none_is_refused_in_one_line(text):
    with pytest.raises(SettingsError, match='runs.cut_at_utc = .*: must be times of the day'):
        RunCutting(cut_at_utc=text)


def test_the_latitudes_of_a_trial_have_an_order():
    with pytest.raises(SettingsError, match='trial.latitude_min_deg = 5.0: must not exceed'):
        Settings.from_mapping({'trial': {'latitude_min_deg': 5, 'latitude_max_deg': 4}})


def test_each_setting_is_part_of_the_hash():
    plain = Settings().to_mapping()
    for settings in ({'runs.every_h': 24}, {'trial.ship': 'MV Example'}):
        assert settings_sha256(Settings.from_mapping(settings).to_mapping()) != (
            settings_sha256(plain))
