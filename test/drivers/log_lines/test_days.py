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

"""The date in the name of a file."""

from __future__ import annotations

import pytest

from heading_intercompare.core.utc_text import DAY_NS
from heading_intercompare.drivers.log_lines.days import date_in_name, Days
from heading_intercompare.drivers.log_lines.times import date_ns

MAY = date_ns(2024, 5, 28)


@pytest.mark.parametrize('name, ns', [
    ('gyro_20240528.log', MAY), ('2024-05-28/gyro.log', None), ('gyro-2024-05-28T20.log', MAY),
    ('gyro.2024.05.28.gz', MAY), ('km2024_148_72000.hdg', MAY),
    ('gyro_20240528_20240529.log', None),
    ('gyro_20241328.log', None), ('gyro_20240231.log', None), ('1202405281.log', None),
    ('gyro.log', None)])
def test_the_one_date_in_a_name(name, ns):
    assert date_in_name(name) == ns


def test_each_file_begins_on_the_date_in_its_name_and_later_ones_follow():
    days = Days(None)
    days.begin_file('a_20240528.log')
    assert [days.place(ns) for ns in (5, 1, DAY_NS - 5)] == [MAY + 5, MAY + 1, MAY - 5]
    days.begin_file('a_20240530.log')
    assert days.place(7) == MAY + 2 * DAY_NS + 7
    days.begin_file('b.log')
    assert days.place(9) == MAY + 2 * DAY_NS + 9
