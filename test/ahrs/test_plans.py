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

"""Lists written as text."""

from __future__ import annotations

import pytest

from heading_intercompare.ahrs.plans import (
    parse_events,
    parse_faults,
    parse_fixed,
    parse_legs,
    parse_starts,
    parse_utc,
)
from heading_intercompare.core.declared_settings import SettingsError


def test_legs_may_be_lines():
    legs = parse_legs('0 45 12\n\n600 90 8.5;900 0 0')
    assert [(leg.t_s, leg.course_deg, leg.speed_kn) for leg in legs] == [
        (0.0, 45.0, 12.0), (600.0, 90.0, 8.5), (900.0, 0.0, 0.0)]


@pytest.mark.parametrize('text, reason', [
    ('', 'first entry must start at 0 s'),
    ('5 0 0', 'first entry must start at 0 s'),
    ('0 45', "entry 1 '0 45': must be 't_s course_deg speed_kn'"),
    ('0 45 12; 600 east 12', "entry 2 '600 east 12': course 'east' must be a number"),
    ('0 45 12; 0 90 12', 'entry 2 .*: its time must exceed that of the entry before'),
    ('0 45 nan', "speed 'nan' must be a number"),
    ('-1 45 12', "time '-1' must be a number of at least 0")])
def test_wrong_legs_are_named(text, reason):
    with pytest.raises(SettingsError, match=reason):
        parse_legs(text)


@pytest.mark.parametrize('parse, text, reason', [
    (parse_faults, '5 melt', "kind 'melt' must be freeze or jump"),
    (parse_faults, '5', "must be 't_s kind"),
    (parse_faults, '5 jump 1 -3', "duration '-3' must be a number of at least 0"),
    (parse_events, '5 dance', "kind 'dance' must be gyrocompass or"),
    (parse_events, '5 reset now', "must be 't_s kind'"),
    (parse_fixed, 'drift_q 1', "name 'drift_q' must be drift_x or"),
    (parse_fixed, 'drift_x', "must be 'name value'"),
    (parse_starts, '600', "entry 1 '600': must be 't_s error_deg'"),
    (parse_starts, '600 x', "error 'x' must be a number"),
    (parse_starts, '600 0.1; 300 0.2', "entry 2 '300 0.2': its time must exceed"),
    (parse_utc, 'yesterday', 'must be a UTC instant')])
def test_wrong_entries_are_named(parse, text, reason):
    with pytest.raises(SettingsError, match=reason):
        parse(text)


def test_events_come_in_the_order_of_their_times():
    assert [event.kind for event in parse_events('9 reset; 3 power_dip')] == [
        'power_dip', 'reset']


def test_instants_with_a_zone_and_a_fraction():
    """08:00 at two hours east is 06:00 UTC, 21600 s into the day."""
    assert parse_utc('1970-01-01T08:00:00.250+02:00') == 21_600_250_000_000
    assert parse_utc('1970-01-02') == 86_400_000_000_000
