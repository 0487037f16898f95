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

"""
The graph for as long as asked: nothing is lost, the memory does not grow, live = offline.

Both sensors at 100 Hz in real time. `make test` gives it twenty seconds, `make release` half an
hour: set `HEADING_INTERCOMPARE_SOAK_S`.
"""

from __future__ import annotations

import os
from pathlib import Path
import time

from nodes.graph_checks import assert_same, offline
from nodes.ros_nodes import NORMS
import pytest

from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.sensor_simulator import SensorSimulator

SOAK_S = float(os.environ.get('HEADING_INTERCOMPARE_SOAK_S', '20'))
RATE_HZ = 100.0
TRIAL = {'duration_s': SOAK_S, 'seed': 11, 'ts.white_deg': 0.1, 'ts.rate_hz': RATE_HZ,
         'rs.rate_hz': RATE_HZ, 'rs.white_deg': 0.02, 'legs': '0 350 12', 'stamps': 'scenario',
         'speed': 1.0}
# Pairs from the first second on, which 'auto' would hold back for a minute.
SETTINGS = {**NORMS, 'pairing.method': 'interpolate'}
#: Of a run in memory: eight columns of eight bytes a pair, twice while they grow.
PAIR_BYTES = 2 * 8 * 8


def resident_bytes() -> int:
    """Return the memory that this process has now."""
    status = Path('/proc/self/status').read_text('ascii')
    return 1024 * int(status.partition('VmRSS:')[2].split()[0])


@pytest.mark.slow
@pytest.mark.timeout(SOAK_S + 600.0)
def test_nothing_is_lost_and_the_memory_does_not_grow(tmp_path):
    seen: list[tuple[int, int]] = []
    bag = str(tmp_path / 'bag')
    began_s = time.monotonic()
    live = intercompare(
        [Source(SensorSimulator, 'sensor_simulator', TRIAL)], SETTINGS, output=bag, private=True,
        progress=lambda n_pairs: seen.append((n_pairs, resident_bytes()))).to_dict()
    assert time.monotonic() - began_s >= 0.95 * SOAK_S
    run = live['runs'][0]['pairing']
    assert run['ts_received'] == run['rs_received'] == pytest.approx(SOAK_S * RATE_HZ, abs=1)
    assert run['ts_paired'] >= run['ts_received'] - 1
    assert_same(live, offline(bag, **SETTINGS))
    # From a quarter on everything is loaded; what is added then are the pairs of the run.
    first, last = seen[len(seen) // 4], seen[-1]
    assert last[0] > first[0] > 0
    assert last[1] - first[1] < 30e6 + PAIR_BYTES * (last[0] - first[0])
