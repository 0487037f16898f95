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

"""What a bag says of the quality of its headings, on a topic beside theirs or in covariances."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import RECORD
from heading_intercompare.bags.rosbag2.quality_topics import has_claims, read_quality
from heading_intercompare.core.records import Headings, Quality
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.quality_messages import encode_quality
from heading_intercompare.messages.status_messages import STATUS_TYPE

S, N = 10 ** 9, 20_000
STAMPS = 1_500_000_000 * S + np.arange(N) * S
LATE_NS = 5_000_000
TOPIC = '/rs/heading'


def write(path, sigma_deg, quality=None, records=()):
    """Write the headings of a sensor with these claims, recorded a little later."""
    with BagWriter(path) as bag:
        for record in records:
            bag.metadata(record, {'software': 'x'})
        bag.add_topic(TOPIC, IMU)
        bag.write_rows([Rows(TOPIC, encode_imu(Headings.of(STAMPS, np.full(N, 90.0)), 'x',
                                               sigma_deg=sigma_deg), STAMPS + LATE_NS)])
        if quality is not None:
            bag.add_topic(f'{TOPIC}/quality', STATUS_TYPE)
            bag.write(f'{TOPIC}/quality', encode_quality(quality), int(STAMPS[-1]))
    return path


def read(path, topic=TOPIC):
    problems = []
    rows = read_quality(BagReader(path), topic, problems)
    assert problems == []
    return rows


@pytest.mark.parametrize('topic, late_ns', [
    ('rs/heading', 0), (f'{TOPIC}.orientation', 0), (f'{TOPIC}.orientation@ned', 0),
    (f'{TOPIC}.orientation@log_time', LATE_NS), (f'{TOPIC}.orientation@publish_time', LATE_NS)])
def test_claims_have_the_stamps_of_their_headings_where_they_change(tmp_path, topic, late_ns):
    at = np.arange(N)
    write(tmp_path / 'bag', np.select([at < 700, at < 900], [0.5, 0.0], 0.7))
    rows = read(tmp_path / 'bag', topic)
    assert not rows.flag.any()
    assert rows.stamp_ns.tolist() == (
        STAMPS[[0, 699, 700, 899, 900, N - 1]] + late_ns).tolist()
    assert rows.stated_deg.tolist() == pytest.approx(
        [0.5, 0.5, np.nan, np.nan, 0.7, 0.7], nan_ok=True)


@pytest.mark.parametrize('sigma_deg', [0.0, 500.0, np.inf])
def test_a_bag_without_a_claim_has_no_row(tmp_path, sigma_deg):
    assert read(write(tmp_path / 'bag', sigma_deg)) == Quality.empty()


def test_a_topic_of_quality_says_all(tmp_path):
    """`import` writes the claims in both places; a topic of another program is none."""
    said = Quality.of([STAMPS[3]], [0.1], [1])
    assert read(write(tmp_path / 'bag', 0.5, quality=said)) == said


@pytest.mark.parametrize('records, n', [((), 2), (('rosbag2',), 2), ((RECORD,), 0)])
def test_a_bag_of_this_program_has_the_verdict_of_its_live_nodes(tmp_path, records, n):
    """They read no covariance, so it is none of what an offline verdict knows."""
    assert len(read(write(tmp_path / 'bag', 0.5, records=records))) == n


def test_a_silent_sensor_is_not_read_to_its_end(tmp_path, monkeypatch):
    """Most bags claim nothing: reading them twice would cost as much as reading them."""
    path, n = write(tmp_path / 'bag', 0.0), []
    payloads = BagReader.payloads

    def count(self, topic):
        for messages in payloads(self, topic):
            n.append(len(messages.start))
            yield messages
    monkeypatch.setattr(BagReader, 'payloads', count)
    assert read(path) == Quality.empty() and 1000 <= sum(n) < N


def come_along(path, **options):
    """Return the headings of a bag, and the claims told with them."""
    chunks, told = [], []

    def take(rows):
        told.append((len(chunks), rows))
    for chunk in BagReader(path).headings({TOPIC: 'enu'}, claimed={TOPIC: take}, **options):
        chunks.append(chunk[TOPIC])
    return chunks, told


@pytest.mark.parametrize('helpers', [0, 1])
def test_claims_come_along_with_their_headings_as_read_on_their_own(tmp_path, helpers):
    at = np.arange(N)
    path = write(tmp_path / 'bag', np.select([at < 700, at < 900], [0.5, 0.0], 0.7))
    chunks, told = come_along(path, helpers=helpers)
    joined = Quality.join([rows for _, rows in told])
    assert joined == read(path) and len(joined) == 6
    for number, chunk in enumerate(chunks):
        so_far = Quality.concatenate(rows for n, rows in told if n <= number)
        assert so_far.match(chunk.stamp_ns)[1].tolist() == pytest.approx(
            joined.match(chunk.stamp_ns)[1].tolist(), nan_ok=True)
    assert sum(map(len, chunks)) == N


def test_a_claim_shows_in_the_first_messages(tmp_path, monkeypatch):
    n = []
    payloads = BagReader.payloads

    def count(self, topic):
        for messages in payloads(self, topic):
            n.append(len(messages.start))
            yield messages
    path = write(tmp_path / 'bag', 0.5)
    monkeypatch.setattr(BagReader, 'payloads', count)
    assert has_claims(BagReader(path), TOPIC) and sum(n) < N
