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

"""Small bags for the tests of this folder."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU

START_NS = 1_406_851_200_000_000_000


def headings(rng: np.random.Generator, count: int, rate_hz: float, phase_ns: int = 0) -> Headings:
    """Return readings at a rate, with jitter, over all directions and a few invalid."""
    stamp_ns = (START_NS + phase_ns + (np.arange(count) * (1e9 / rate_hz)).astype(np.int64)
                + rng.integers(0, 100_000, count))
    heading_deg = rng.uniform(0.0, 360.0, count)
    heading_deg[::97] = np.nan
    return Headings.of(stamp_ns, heading_deg)


@pytest.fixture
def two_sensors(rng):
    """Return TS at 20 Hz and RS at 10 Hz over 100 s."""
    return headings(rng, 2000, 20.0), headings(rng, 1000, 10.0, 3_000_000)


@pytest.fixture
def write_bag(tmp_path, two_sensors):
    """Return a function that writes both sensors, whose messages differ in length."""
    def write(name: str = 'trial', topics: tuple[str, str] = ('/ts/heading', '/rs/heading'),
              **settings):
        ts, rs = two_sensors
        with BagWriter(tmp_path / name, BagSettings(**settings)) as bag:
            for topic in topics:
                bag.add_topic(topic, IMU)
            bag.write_rows([
                Rows(topics[0], encode_imu(ts, 'ts'), ts.stamp_ns, sequence=np.arange(len(ts))),
                Rows(topics[1], encode_imu(rs, 'rs_antenna', sigma_deg=0.1), rs.stamp_ns + 500,
                     rs.stamp_ns)])
        return bag.path
    return write
