# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The clock of a process that may be stopped."""

from __future__ import annotations

import pytest

from heading_intercompare.nodes.runtime import awake_clock


def test_the_time_in_which_a_process_stood_still_does_not_count(monkeypatch):
    """A reading that waited for its partner was given up when the process went on."""
    times = iter([100.0, 100.05, 100.5, 107.5, 107.6])
    monkeypatch.setattr(awake_clock.time, 'monotonic', lambda: next(times))
    clock = awake_clock.AwakeClock()
    assert [clock.now_s() for _ in range(4)] == pytest.approx([0.05, 0.5, 1.5, 1.6])
