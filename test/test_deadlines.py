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


"""A watch that stands while programs wait for a processor."""

from __future__ import annotations

import time

import deadlines
from deadlines import Stopwatch
import pytest

LINES = ('some avg10=0.00 avg60=0.00 avg300=0.00 total={}\n'
         'full avg10=0.00 avg60=0.00 avg300=0.00 total=0\n')


@pytest.mark.parametrize('waited_us, passed_s', [(0, 5.0), (4_000_000, 1.0)])
def test_the_time_in_which_programs_waited_does_not_count(
        tmp_path, monkeypatch, waited_us, passed_s):
    pressure = tmp_path / 'cpu'
    pressure.write_text(LINES.format(7_000_000))
    monkeypatch.setattr(deadlines, '_PRESSURE', pressure)
    monkeypatch.setattr(time, 'monotonic', lambda: 100.0)
    watch = Stopwatch()
    pressure.write_text(LINES.format(7_000_000 + waited_us))
    monkeypatch.setattr(time, 'monotonic', lambda: 105.0)
    assert watch.passed_s == pytest.approx(passed_s)


def test_without_figures_of_the_kernel_it_is_a_clock(tmp_path, monkeypatch):
    monkeypatch.setattr(deadlines, '_PRESSURE', tmp_path / 'none')
    monkeypatch.setattr(time, 'monotonic', lambda: 100.0)
    watch = Stopwatch()
    monkeypatch.setattr(time, 'monotonic', lambda: 105.0)
    assert watch.passed_s == 5.0
