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

"""The benchmark of the memory of long trials loses nothing and prints its table."""

from __future__ import annotations

from pathlib import Path
import sys

import pytest
from ros_domain import DOMAIN

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))

from memory_of_a_trial import describe, measure, TRIALS  # noqa: E402


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize('name, hours', [
    ('day', 0.2), pytest.param('hour', 0.01, marks=pytest.mark.endurance)])
def test_a_trial_passes_without_loss_and_its_memory_is_sampled(name, hours):
    """Faster than real time, beside a plain node that hears the same readings."""
    plan = TRIALS[name]._replace(hours=hours)
    memory = measure(name, plan, DOMAIN)
    assert memory.lost == dict.fromkeys(memory.lost, 0)
    assert memory.n_pairs + 1 == memory.n_sent == round(3600.0 * hours * plan.rate_hz)
    assert 0 < memory.heard <= 2 * memory.n_sent
    hours_passed, graph_mb, plain_mb = memory.samples.T
    # A busy computer looks late.
    assert 0.5 * hours < hours_passed[-1] <= hours
    assert 0.0 < plain_mb[-1] < graph_mb[-1] <= memory.peak_mb + 1.0
    lines = describe(name, plan, memory).splitlines()
    assert [line.split()[0] for line in lines[3:]] == ['graph', 'plain']
