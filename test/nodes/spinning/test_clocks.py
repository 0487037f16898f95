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

"""The clock of a process that may be stopped."""

from __future__ import annotations

import pytest

from heading_intercompare.nodes.spinning import clocks


def test_the_time_in_which_a_process_stood_still_does_not_count(monkeypatch):
    """A reading that waited for its partner was given up when the process went on."""
    times = iter([100.0, 100.05, 100.5, 107.5, 107.6])
    monkeypatch.setattr(clocks.time, 'monotonic', lambda: next(times))
    clock = clocks.AwakeClock()
    assert [clock.now_s() for _ in range(4)] == pytest.approx([0.05, 0.5, 1.5, 1.6])
