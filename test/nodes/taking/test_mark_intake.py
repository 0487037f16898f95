# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Marks are taken once each, and not without end."""

from __future__ import annotations

from heading_intercompare.nodes.runtime.health import Health
from heading_intercompare.nodes.taking.mark_intake import MarkIntake


def test_a_mark_is_taken_once_and_marks_without_end_are_refused(ros):
    health = Health(ros.plain)
    marks = MarkIntake(health)
    assert marks.take('start', 5) and not marks.take('start', 5) and not marks.take('pause', 5)
    assert sum(marks.take('stop', at) for at in range(20_000)) == 9999
    assert len(marks._taken) == 10_000
    assert health._latched['marker'].message == '10001 marks refused: a node takes 10000'
