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

"""The nodes take no more memory after a month of daily runs than after ten days."""

from __future__ import annotations

from pathlib import Path
import sys

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / 'benchmarks'))

from months import run  # noqa: E402


@pytest.mark.slow
@pytest.mark.endurance
def test_thirty_days_of_the_nodes_take_no_more_memory_than_ten(tmp_path):
    """A reading of each sensor in 2 min; the queues of DDS are full after ten days."""
    days = [*run(30, 120.0, str(tmp_path))]
    assert [day.runs for day in days[1:]] == [*range(1, 30)]
    rss_mb = [day.rss_mb for day in days]
    assert max(rss_mb[20:]) - max(rss_mb[9:12]) < 8.0
    # A journal holds the run in progress: its size depends on when it is looked at.
    assert max(day.journal_mb for day in days[20:]) < 2.0 * max(
        day.journal_mb for day in days[5:12])
