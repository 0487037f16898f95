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

"""Marks are taken once each, and not without end."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.runs.run_cutter import RunCutter
from heading_intercompare.core.settings import RunCutting
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.taking.mark_intake import explain_mark, MarkIntake


def test_a_mark_is_taken_once_and_marks_without_end_are_refused(ros):
    health = Health(ros.plain)
    marks = MarkIntake(health)
    assert marks.take('start', 5) and not marks.take('start', 5) and not marks.take('pause', 5)
    assert sum(marks.take('stop', at) for at in range(20_000)) == 9999
    assert len(marks._taken) == 10_000
    assert health._latched['marker'].message == '10001 marks refused: a node takes 10000'


def test_a_service_says_what_its_mark_does():
    """A second start said the same as the first one, whether or not it cut a run."""
    cutter, said = RunCutter(RunCutting()), []
    cutter.update(np.array([10 ** 9, 2 * 10 ** 9]))
    for step in ('start', 'start', 3, 'start', 4, 'stop', 'stop', 'start'):
        if isinstance(step, int):
            cutter.update(np.array([step * 10 ** 9]))
        else:
            said.append(explain_mark(step, cutter.state))
            cutter.mark(step, cutter.state.newest_ns)
    begins = 'a run begins with the next pair'
    assert said == [
        f'{begins}; what came before this first mark belongs to no run',
        'nothing changes: a run already begins with the next pair',
        'the run in progress ends here, and another one begins with the next pair',
        'the run in progress ends here',
        'no run is in progress; none begins until the next start', begins]
