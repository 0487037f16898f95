#!/usr/bin/env python3
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
How fast bags of other programs are read, next to `rosbags` alone.

The bags hold Imu of two sensors: rosbag2 in SQLite, uncompressed and compressed by file and by
message, and a ROS 1 bag. In the same run it measures, each as the shortest of several alternating
rounds, and opening included: iterating over the raw messages with `rosbags`, for ROS 1 with their
conversion to CDR; and reading the headings with `open_recording`. The promise: at most 1.5 times
the time of `rosbags`. The exit code is 1 if it is broken.

    python benchmarks/foreign_bags.py --count 400000
"""

from __future__ import annotations

import argparse
from pathlib import Path
import sys
import tempfile
from time import perf_counter

import numpy as np
from rosbags.rosbag1 import Reader as Ros1Reader, Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, Writer
from rosbags.typesys import get_typestore, Stores

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.readers.registry import open_recording

MOST = 1.5
TOPICS = ('/ts/heading', '/rs/heading')
PLAIN = get_typestore(Stores.ROS2_HUMBLE)


def write(folder: Path, count: int) -> dict[str, Path]:
    """Write the bags, with `count` messages of each sensor at 100 Hz."""
    stamps = 1_400_000_000_000_000_000 + np.arange(count) * 10_000_000
    data = imu_messages(Headings.of(stamps, np.arange(count) % 360.0), 'gyro')
    found = {}
    for name, mode in (('SQLite', None), ('by file', CompressionMode.FILE),
                       ('by message', CompressionMode.MESSAGE)):
        found[name] = folder / name.replace(' ', '_')
        writer = Writer(found[name], version=9)
        if mode is not None:
            writer.set_compression(mode, CompressionFormat.ZSTD)
        with writer:
            topics = [writer.add_connection(topic, IMU, typestore=PLAIN) for topic in TOPICS]
            for ns, message in zip(stamps.tolist(), data):
                for topic in topics:
                    writer.write(topic, ns, message)
    found['ROS 1'] = folder / 'a.bag'
    with Ros1Writer(found['ROS 1']) as writer:
        store = get_typestore(Stores.ROS1_NOETIC)
        topics = [writer.add_connection(topic, IMU, typestore=store) for topic in TOPICS]
        for ns, message in zip(stamps.tolist(), data):
            for topic in topics:
                writer.write(topic, ns, PLAIN.cdr_to_ros1(message, IMU))
    return found


def read_plainly(path: Path) -> int:
    """Iterate over the messages with `rosbags`; return their number."""
    ros1 = path.suffix == '.bag'
    n = 0
    with (Ros1Reader(path) if ros1 else Reader(path)) as reader:
        for connection, _, data in reader.messages(reader.connections):
            if ros1:
                PLAIN.ros1_to_cdr(data, connection.msgtype)
            n += 1
    return n


def read_headings(path: Path) -> int:
    """Read the headings as the analysis does; return their number."""
    chunks = open_recording(path).headings(dict.fromkeys(TOPICS, 'enu'))
    return sum(len(headings) for chunk in chunks for headings in chunk.values())


def main(arguments: list[str] | None = None) -> int:
    """Measure and print; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0])
    parser.add_argument('--count', type=int, default=200_000, help='messages of each sensor')
    parser.add_argument('--rounds', type=int, default=3)
    given = parser.parse_args(arguments)
    broken = False
    print('| bag | rosbags [1/s] | headings [1/s] | ratio of times |')
    print('|---|---|---|---|')
    with tempfile.TemporaryDirectory() as folder:
        for name, path in write(Path(folder), given.count).items():
            times: dict[object, float] = {}
            for _ in range(given.rounds):
                for read in (read_plainly, read_headings):
                    begun = perf_counter()
                    n = read(path)
                    times[read] = min(times.get(read, 1e9), perf_counter() - begun)
                    if n != 2 * given.count:
                        raise ValueError(f'{name}: {n} messages, not {2 * given.count}')
            ratio = times[read_headings] / times[read_plainly]
            broken = broken or ratio > MOST
            print(f'| {name} | {n / times[read_plainly]:,.0f} | {n / times[read_headings]:,.0f} | '
                  f'{ratio:.2f} |')
    print(f'promise: at most {MOST}: {"broken" if broken else "kept"}')
    return int(broken)


if __name__ == '__main__':
    sys.exit(main())
