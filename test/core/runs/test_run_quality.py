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

"""What the sensors say of the run in progress is there, and grows no further."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.core.records import Quality
from heading_intercompare.core.runs.run_quality import RunQuality

HOUR = 3600 * 10 ** 9


def rows(hours):
    return Quality.of([int(hour * HOUR) for hour in hours], np.full(len(hours), 0.1),
                      np.arange(len(hours)) % 3)


@pytest.mark.parametrize('size', [1, 2, 7])
def test_rows_are_there_in_the_order_in_which_they_came(size):
    quality, whole = RunQuality(), rows([5, 1, 2, 4, 3, 9, 7])
    for at in range(0, len(whole), size):
        quality.take('rs', whole[at:at + size])
    quality.take('ts', Quality.empty())
    (stream, there), = quality.by_stream().items()
    assert stream == 'rs' and there.stamp_ns.tolist() == whole.stamp_ns.tolist()
    assert there.flag.tolist() == whole.flag.tolist()


@pytest.mark.parametrize('start_h, left', [
    (10, [9, 9.6, 10, 11]),
    (9.8, [9, 9.6, 10, 11]),
    (None, [10, 11]),
    (3, [3, 0, 2.6, 9, 9.6, 10, 11]),
    (0, [3, 0, 2.6, 9, 9.6, 10, 11])])
def test_old_rows_go_and_the_newest_of_them_stays(start_h, left):
    """Half an hour before a run stays, and what holds since then: from the newest row before."""
    quality = RunQuality()
    quality.take('ts', rows([3, 0, 2.6, 9, 9.6, 10, 11]))
    quality.forget(None if start_h is None else int(start_h * HOUR))
    assert quality.by_stream()['ts'].stamp_ns.tolist() == [int(hour * HOUR) for hour in left]


def test_a_sensor_that_says_nothing_new_for_a_year_takes_no_memory():
    """Of readings of which it is the same, two rows suffice for every run to come."""
    quality = RunQuality()
    for hour in range(0, 24 * 365):
        quality.take('rs', rows([hour]))
        quality.forget(hour * HOUR)
    assert len(quality.by_stream()['rs']) < 5
