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

"""All headings of a bag at once: the readings that `analyze_bag` judges."""

from __future__ import annotations

import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import analyze, analyze_bag, Headings, read_bag, Settings
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.rosbag2.provenance import Notes
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE

S = 10 ** 9
T0 = 1_400_000_000 * S
STAMPS = T0 + np.arange(9000) * (S // 10)
SETTINGS = Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1, ts_topic='/gyro/imu')


@pytest.fixture
def sent(rng):
    """Return 15 minutes of both sensors at 10 Hz, as sent."""
    return {topic: Headings.of(STAMPS, 100.0 + sigma * rng.standard_normal(9000))
            for topic, sigma in (('/gyro/imu', 0.1), ('rs/heading', 0.02))}


@pytest.fixture
def bag(tmp_path, sent):
    """Return a bag of both sensors, with a note."""
    write_headings(tmp_path / 'trial', sent, write_more=lambda writer: Notes(
        writer.metadata).add('course 270', T0))
    return tmp_path / 'trial'


def test_the_readings_of_both_sensors_come_back_as_they_were_sent(bag, sent):
    found = read_bag(bag, SETTINGS)
    for read, given in ((found.ts, sent['/gyro/imu']), (found.rs, sent['rs/heading'])):
        assert read.stamp_ns.tolist() == given.stamp_ns.tolist()
        np.testing.assert_allclose(read.heading_deg, given.heading_deg, atol=1e-9)
    assert found.marks == () and found.problems == ()
    assert found.notes == ((T0, 'course 270'),)


def test_they_give_the_verdict_of_the_bag(bag):
    found = read_bag(str(bag), SETTINGS)
    run, = analyze(found.ts, found.rs, SETTINGS).runs
    same, = analyze_bag(bag, SETTINGS).runs
    assert run.variance_deg2 == same.variance_deg2 and run.guarded == same.guarded


def test_marks_come_with_their_stamps(tmp_path, sent):
    marks = (('start', T0 + S), ('stop', T0 + 800 * S))

    def write_marks(writer):
        writer.add_topic(MARKER_TOPIC, STATUS_TYPE)
        for kind, stamp_ns in marks:
            writer.write(MARKER_TOPIC, encode_mark(kind, stamp_ns), stamp_ns)
    write_headings(tmp_path / 'marked', sent, write_more=write_marks)
    assert read_bag(tmp_path / 'marked', SETTINGS).marks == marks


def test_a_cut_bag_warns_and_gives_the_rest(bag):
    file = next(bag.glob('*.mcap'))
    file.write_bytes(file.read_bytes()[:-200])
    with pytest.warns(UserWarning) as said:
        found = read_bag(bag, SETTINGS)
    assert len(found.ts) and found.problems
    assert [str(each.message) for each in said] == [f'{bag}: {why}' for why in found.problems]
    assert said[0].filename == __file__


def test_a_wrong_topic_names_those_of_the_bag(bag):
    with pytest.raises(BagError, match="has no topic 'ts/heading'; it has .*/gyro/imu"):
        read_bag(bag)
