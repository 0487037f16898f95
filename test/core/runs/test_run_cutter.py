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

"""Cutting into runs: silences, marks, tables, and any chunks."""

from __future__ import annotations

from hypothesis import given, strategies as st
import numpy as np
import pytest

from heading_intercompare.core.runs.run_cutter import RunCutter
from heading_intercompare.core.settings import RunCutting

S = 1_000_000_000


def seconds(*values):
    return np.array([round(v * S) for v in values], np.int64)


def runs_of(cutter, stamp_ns, chunks=None):
    """Return the stamps of each run, in seconds, feeding chunks of the given lengths."""
    runs = {}
    at = 0
    for n in chunks or [len(stamp_ns)]:
        chunk = stamp_ns[at:at + n]
        at += n
        for piece in cutter.update(chunk):
            runs.setdefault(piece.key, []).extend((chunk[piece.lo:piece.hi] / S).tolist())
    return list(runs.values())


def test_a_run_opens_at_the_first_pair_and_a_silence_cuts():
    cutter = RunCutter(RunCutting(gap_s=10.0))
    assert runs_of(cutter, seconds(1, 2, 12, 22.1, 23)) == [[1, 2, 12], [22.1, 23]]


def test_a_silence_just_as_long_as_allowed_does_not_cut():
    assert len(runs_of(RunCutter(RunCutting(gap_s=10.0)), seconds(1, 11))) == 1


def test_marks_bound_the_runs():
    cutter = RunCutter(RunCutting())
    cutter.mark('start', 2 * S)
    cutter.mark('stop', 4 * S)
    assert runs_of(cutter, seconds(1, 2, 3, 4, 5, 6)) == [[3, 4]]
    assert cutter.current is None


def test_a_live_mark_acts_behind_the_newest_pair():
    cutter = RunCutter(RunCutting())
    assert runs_of(cutter, seconds(1, 2)) == [[1, 2]]
    assert cutter.mark('start', 2 * S), 'the run opened without a mark is withdrawn'
    assert cutter.current is None
    assert runs_of(cutter, seconds(3, 4)) == [[3, 4]]
    assert not cutter.mark('stop', 4 * S)
    assert cutter.current is None
    assert runs_of(cutter, seconds(5, 6)) == []


def test_a_mark_that_comes_late_acts_behind_the_newest_pair():
    cutter = RunCutter(RunCutting())
    runs_of(cutter, seconds(1, 2, 3))
    cutter.mark('stop', 1 * S)
    assert cutter.current is None
    assert runs_of(cutter, seconds(4)) == []


def test_a_second_start_ends_the_run_before_it():
    cutter = RunCutter(RunCutting())
    for stamp in (0, 2 * S):
        cutter.mark('start', stamp)
    assert runs_of(cutter, seconds(1, 2, 3)) == [[1, 2], [3]]


def test_the_same_mark_twice_is_one_mark():
    cutter = RunCutter(RunCutting())
    for _ in range(2):
        cutter.mark('start', 1 * S)
    assert runs_of(cutter, seconds(1, 2, 3)) == [[2, 3]]


def test_a_table_is_half_open_and_marks_do_not_count():
    cutter = RunCutter(RunCutting(), [(2 * S, 4 * S), (4 * S, 5 * S)])
    assert not cutter.mark('start', 1 * S)
    assert runs_of(cutter, seconds(1, 2, 3, 4, 5)) == [[2, 3], [4]]


@pytest.mark.parametrize('table, problem', [
    ([(2, 2)], 'not after'), ([(1, 5), (4, 6)], 'before the end')])
def test_a_table_that_makes_no_sense_is_refused(table, problem):
    with pytest.raises(ValueError, match=problem):
        RunCutter(RunCutting(), table)


def test_an_unknown_mark_is_refused():
    with pytest.raises(ValueError, match="'start' or 'stop'"):
        RunCutter(RunCutting()).mark('pause', 0)


@pytest.mark.slow
@given(st.lists(st.integers(1, 300), unique=True, max_size=40), st.data())
def test_chunks_do_not_matter(stamps, data):
    stamp_ns = np.sort(np.array(stamps, np.int64)) * S
    marks = data.draw(st.lists(st.tuples(st.sampled_from(['start', 'stop']),
                                         st.integers(1, 300)), max_size=4))
    chunks, left = [], len(stamp_ns)
    while left:
        chunks.append(data.draw(st.integers(1, left)))
        left -= chunks[-1]
    results = []
    for lengths in (None, chunks):
        cutter = RunCutter(RunCutting(gap_s=20.0))
        for kind, stamp in marks:
            cutter.mark(kind, stamp * S)
        results.append(runs_of(cutter, stamp_ns, lengths))
    assert results[0] == results[1]


def test_the_clock_cuts_at_the_stamp_and_the_run_before_ends():
    cutter = RunCutter(RunCutting(every_h=1.0))
    pieces = cutter.update(seconds(3590, 3599.999, 3600, 3610))
    assert [(p.key, p.cut_ns, p.since_ns, p.lo, p.hi) for p in pieces] == [
        (1, 3590 * S, 3590 * S, 0, 2), (2, 3600 * S, 3590 * S, 2, 4)]
    assert cutter.current == 2


def test_a_silence_over_a_cut_by_the_clock_is_a_silence():
    cutter = RunCutter(RunCutting(cut_at_utc='01:00', gap_s=60.0))
    pieces = cutter.update(seconds(3590, 3700))
    assert [(p.cut_ns, p.since_ns) for p in pieces] == [(3590 * S, 3590 * S), (3700 * S, 3700 * S)]


def test_a_short_silence_over_several_cuts_opens_one_run_at_the_last():
    cutter = RunCutter(RunCutting(every_h=1.0, gap_s=20000.0))
    pieces = cutter.update(seconds(3590, 11000))
    assert [(p.key, p.cut_ns, p.since_ns) for p in pieces] == [
        (1, 3590 * S, 3590 * S), (2, 10800 * S, 3590 * S)]


def test_the_clock_cuts_between_marks_but_not_in_the_runs_of_a_table():
    cutter = RunCutter(RunCutting(every_h=1.0, gap_s=1000.0))
    cutter.mark('start', 3000 * S)
    cutter.mark('stop', 3700 * S)
    assert runs_of(cutter, seconds(2990, 3010, 3590, 3600, 3700, 7201)) == [
        [3010, 3590], [3600, 3700]]
    table = RunCutter(RunCutting(every_h=1.0, gap_s=1000.0), [(3000 * S, 3700 * S)])
    assert runs_of(table, seconds(2990, 3010, 3590, 3600, 3700)) == [[3010, 3590, 3600]]


@given(steps=st.lists(st.integers(1, 100), min_size=1, max_size=40),
       chunks=st.lists(st.integers(1, 7), min_size=1, max_size=40))
def test_any_chunks_give_the_same_cuts_by_the_clock(steps, chunks):
    stamps = seconds(*np.cumsum(steps))
    rule = RunCutting(every_h=0.05, gap_s=60.0)
    whole = runs_of(RunCutter(rule), stamps)
    assert runs_of(RunCutter(rule), stamps, [*chunks, len(stamps)]) == whole
    assert [x for run in whole for x in run] == (stamps / S).tolist()
    for run in whole:
        assert run[0] // 180 == run[-1] // 180
        assert all(b - a <= 60 for a, b in zip(run, run[1:]))
