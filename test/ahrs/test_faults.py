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

"""Faults of a sensor as seen from outside."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.ahrs.faults import Fault, Faults

T_S = np.arange(10.0)
HEADING_DEG = 10.0 * T_S
STAMP_NS = (T_S * 1e9).astype(np.int64)


def put(*faults, cuts=(0, 10)):
    """Put faults on ten readings, chunk by chunk."""
    device = Faults(tuple(faults))
    parts = [device.put(T_S[lo:hi], HEADING_DEG[lo:hi], STAMP_NS[lo:hi])
             for lo, hi in zip(cuts, cuts[1:])]
    return [np.concatenate(column) for column in zip(*parts)]


def test_freeze_repeats_the_reading_before():
    heading, _, given = put(Fault(3.0, 'freeze', 0.0, 4.0))
    assert heading.tolist() == [0, 10, 20, 20, 20, 20, 20, 70, 80, 90]
    assert given.all()


def test_freeze_from_the_start_repeats_the_first_reading():
    assert put(Fault(0.0, 'freeze', 0.0, 3.0))[0].tolist()[:4] == [0, 0, 0, 30]


@pytest.mark.parametrize('kind, value, expected', [
    ('jump', 5.0, 55.0), ('rotated', 90.0, 140.0), ('mirrored', 90.0, 40.0),
    ('mirrored', 0.0, 310.0)])
def test_turned_readings_by_hand(kind, value, expected):
    heading, _, _ = put(Fault(5.0, kind, value, 1.0))
    assert heading[5] == expected
    assert np.delete(heading, 5).tolist() == np.delete(HEADING_DEG, 5).tolist()


def test_clock_step_moves_the_stamps_from_then_on():
    _, stamp, _ = put(Fault(5.0, 'clock_step', -2.0))
    assert (stamp - STAMP_NS).tolist() == [0] * 5 + [-2_000_000_000] * 5


def test_silence_and_invalid_readings_differ():
    heading, _, given = put(Fault(1.0, 'silent', 0.0, 2.0), Fault(5.0, 'invalid', 0.0, 2.0))
    assert given.tolist() == [True, False, False] + [True] * 7
    assert np.isnan(heading).tolist() == [False] * 5 + [True, True] + [False] * 3


@pytest.mark.parametrize('cuts', [(0, 3, 10), (0, 4, 10), (0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10)])
def test_faults_do_not_depend_on_the_chunks(cuts):
    faults = (Fault(6.0, 'jump', 5.0), Fault(3.0, 'freeze', 0.0), Fault(2.0, 'rotated', 90.0, 5.0))
    for whole, parts in zip(put(*faults), put(*faults, cuts=cuts)):
        assert np.array_equal(whole, parts)
