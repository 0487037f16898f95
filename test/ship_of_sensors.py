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

"""A ship with any number of heading sensors of known errors, for tests."""

from __future__ import annotations

from checksums import with_checksum
import numpy as np
from scipy.signal import lfilter

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import RECORD, SENSORS_REPORT_TOPIC
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.status_messages import encode_text, TEXT_TYPE

START_NS = 1_770_000_000_000_000_000


def course_deg(t_s):
    """Return the heading of a ship that yaws and turns slowly, degrees."""
    return 90.0 + 3.0 * np.sin(2 * np.pi * t_s / 9.0) + 40.0 * np.sin(2 * np.pi * t_s / 900.0)


def make_sensor(seed, sigma_deg, *, rate_hz=5.0, span_s=1800.0, tau_s=10.0, white=0.5,
                offset_deg=0.0, age_s=0.0, phase_s=0.0):
    """Return readings whose errors are a share of white noise and the rest of AR(1)."""
    rng = np.random.default_rng(seed)
    t_s = phase_s + np.arange(int(span_s * rate_hz)) / rate_hz
    a = np.exp(-1.0 / rate_hz / tau_s)
    settle = int(10 * tau_s * rate_hz)
    slow = lfilter([np.sqrt(1 - a * a)], [1, -a], rng.standard_normal(t_s.size + settle))[settle:]
    error = sigma_deg * (np.sqrt(1 - white ** 2) * slow + white * rng.standard_normal(t_s.size))
    stamps = START_NS + np.rint(t_s * 1e9).astype(np.int64)
    return Headings.of(stamps, (course_deg(t_s - age_s) + error + offset_deg) % 360.0)


TABLE = """
gyro1  topic=/g1/imu  sigma_max_deg=0.3
gyro2  sigma_max_deg=0.3
gnss   sigma_max_deg=0.1  rs
"""
"""Three sensors, one of them on a topic of its own."""


def make_three(seed=0, **errors):
    """Return readings of the sensors of `TABLE`; standard deviations of some may be given."""
    sigma = {'gyro1': 0.15, 'gyro2': 0.15, 'gnss': 0.04, **errors}
    return {name: make_sensor(10 * seed + at, sigma_deg, phase_s=0.05 * at)
            for at, (name, sigma_deg) in enumerate(sigma.items())}


def write_bag(path, headings, start_ns=START_NS, *, stored=None, report=None, published=None):
    """Write a bag of the sensors of `TABLE`, in chunks of a minute as a recorder would."""
    topics = {'gyro1': '/g1/imu', 'gyro2': 'gyro2/heading', 'gnss': 'gnss/heading'}
    with BagWriter(path) as writer:
        if stored:
            writer.metadata(RECORD, stored)
        if report:
            writer.attachment('report.json', 'application/json', report.encode())
        if published:
            writer.add_topic(SENSORS_REPORT_TOPIC, TEXT_TYPE)
            writer.write(SENSORS_REPORT_TOPIC, encode_text(published), start_ns)
        for topic in topics.values():
            writer.add_topic(topic, IMU)
        for minute in range(30):
            rows = []
            for name, readings in headings.items():
                at = (readings.stamp_ns - start_ns) // (60 * 10 ** 9) == minute
                rows.append(Rows(topics[name], encode_imu(readings[at], name),
                                 readings.stamp_ns[at]))
            writer.write_rows(rows)
    return path


def write_log(path, readings, talker):
    """Write a log of HDT sentences with a stamp before each."""
    lines = []
    for stamp_ns, heading_deg in zip(readings.stamp_ns.tolist(), readings.heading_deg.tolist()):
        body = f'{talker}HDT,{heading_deg:.3f},T'
        lines.append(f'{stamp_ns / 1e9:.3f} {with_checksum(body)}')
    path.write_text('\n'.join(lines) + '\n')
    return path
