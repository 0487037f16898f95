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

"""The motion of the run in progress: what is kept, and what is forgotten."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.motion.motion_record import (
    find_newest,
    leave_out_known,
    MotionRecord,
    RunMotion,
)
from heading_intercompare.core.records import Motion

S = 10 ** 9


def rates(seconds):
    stamps = np.asarray(seconds, np.int64) * S
    return Motion.of_rates(stamps, stamps / S / 10.0)


def test_a_record_returns_the_rows_as_they_came_however_they_are_cut(rng):
    stamps = S * rng.permutation(5000)
    rows = (Motion.of_courses([7 * S], [90.0], [10.0]) + rates(stamps // S)
            + Motion.of_positions(stamps, stamps / 1e12, stamps / 1e11)
            + Motion.of_courses([5 * S], [270.0], [9.0]))
    record = MotionRecord()
    lo = 0
    while lo < len(rows):
        hi = lo + int(rng.integers(0, 40))
        record.take(rows[lo:hi])
        lo = hi
    assert len(record) == 10_002
    assert record.by_thing() == rows.split()
    assert (record.oldest_ns, record.newest_ns) == (0, 4999 * S)


def test_full_pages_are_moved_out_of_memory():
    kept = []

    def keep(page):
        kept.append(page)
        return lambda: page
    record = MotionRecord(keep)
    record.take(rates(range(70_000)))
    assert len(kept) == len(('stamp_ns', 'rate_deg_s'))
    np.testing.assert_array_equal(record.by_thing()['rate'].stamp_ns, np.arange(70_000) * S)


def test_what_a_judged_run_does_not_need_is_forgotten():
    motion = RunMotion()
    assert motion.rows is None
    motion.take(rates(range(100)))
    motion.end_run(60 * S)
    assert motion.rows.stamp_ns.tolist() == [k * S for k in range(61, 100)]
    assert motion.late == 0


def test_rows_of_a_judged_run_are_counted_as_late_and_left_out():
    motion = RunMotion()
    motion.take(rates(range(10)))
    motion.end_run(9 * S)
    motion.take(rates([8, 9, 10]))
    assert motion.late == 2
    assert motion.rows.stamp_ns.tolist() == [10 * S]


def test_months_without_a_run_take_no_memory():
    """Half an hour is kept for pairs that come later; it is cut when twice that has come."""
    motion, most = RunMotion(), 0
    for hour in range(500):
        motion.take(rates(range(3600 * hour, 3600 * (hour + 1), 10)))
        motion.forget(None)
        most = max(most, len(motion.rows))
    assert most <= 360 + 360
    assert motion.rows.stamp_ns[-1] == (500 * 3600 - 10) * S


def test_a_run_in_progress_keeps_all_its_motion():
    motion = RunMotion()
    motion.take(rates(range(0, 40_000, 10)))
    motion.forget(20_000 * S)
    assert motion.rows.stamp_ns[0] == (20_000 - 1800 + 10) * S
    motion.take(rates(range(40_000, 80_000, 10)))
    motion.forget(20_000 * S)
    assert len(motion.rows) == (80_000 - 20_000 + 1800) // 10 - 1


def test_rows_that_come_a_second_time_are_known_by_their_stamps():
    rows = Motion.of_courses([1, 2, 3], [0.0] * 3, [9.0] * 3) + Motion.of_rates([1, 2], [0.0] * 2)
    newest = find_newest(rows)
    assert newest == {'velocity': 3, 'rate': 2}
    again = rows + Motion.of_rates([3], [0.1]) + Motion.of_positions([1], [50.0], [5.0])
    left = leave_out_known(again, newest)
    assert len(left.rates()) == len(left.positions()) == 1 and len(left) == 2
    assert len(leave_out_known(rows, {})) == 5
    assert find_newest(Motion.empty()) == {}
