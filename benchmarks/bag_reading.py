#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
How fast headings are read from a bag, next to other readers of the same bag in the same run.

Promises: at least 40 times as fast as iterating over the messages with `mcap`, and, in bags
compressed as we compress them, at most 3 times the time it takes to read and decompress the chunks
and nothing else, not even the checksums. Exit code 1 if one is broken.

    python benchmarks/bag_reading.py 1000000
    python benchmarks/bag_reading.py 8640000 --compression lz4 --live
"""

from __future__ import annotations

import argparse
from itertools import islice
from pathlib import Path
import struct
import sys
import tempfile
from time import perf_counter
from typing import Callable, Iterable
import zlib

import lz4.frame
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
import numpy as np
import zstandard

from heading_intercompare.bags.heading_messages import encode_imu, IMU
from heading_intercompare.bags.reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.bags.writer import BagWriter, Rows
from heading_intercompare.core.records import Headings

TOPICS = ('/ts/heading', '/rs/heading')
RATE_HZ = 100
LEAST_AGAINST_MCAP, MOST_AGAINST_CHUNKS = 40.0, 3.0


def write(path: Path, count: int, settings: BagSettings, live: bool) -> float:
    """Write `count` headings of two sensors; return how long it took, seconds."""
    rng = np.random.default_rng(1)
    step = RATE_HZ if live else 60 * RATE_HZ
    begin = perf_counter()
    with BagWriter(path, settings) as bag:
        for topic in TOPICS:
            bag.add_topic(topic, IMU)
        for lo in range(0, count // 2, step):
            number = np.arange(lo, min(lo + step, count // 2))
            stamp_ns = 10**18 + number * (10**9 // RATE_HZ) + rng.integers(0, 10**5, len(number))
            true_deg = 90.0 + 80.0 * np.sin(number / 2000.0)
            bag.write_rows(
                Rows(topic, encode_imu(Headings.of(
                    stamp_ns + late_ns, true_deg + rng.normal(0.0, 0.2, len(number))), frame,
                    sigma_deg=0.2), stamp_ns + late_ns, sequence=number)
                for topic, frame, late_ns in zip(TOPICS, ('ts', 'rs'), (0, 3_000_000)))
            if live:
                bag.flush()
    return perf_counter() - begin


def headings(path: Path) -> int:
    """Read the headings of both sensors; return how many there are."""
    return sum(len(part) for chunk in BagReader(path).headings(dict.fromkeys(TOPICS, 'enu'))
               for part in chunk.values())


def chunks(path: Path, checked: bool) -> int:
    """Read and decompress the chunks and nothing else; return their size."""
    head, fields, total = struct.Struct('<BQ'), struct.Struct('<QQQII'), 0
    with open(next(path.glob('*.mcap')), 'rb') as file:
        file.seek(8)
        while len(opening := file.read(head.size)) == head.size:
            opcode, length = head.unpack(opening)
            if opcode != 6:
                file.seek(length, 1)
                if opcode == 15:
                    break
                continue
            content = memoryview(file.read(length))
            _, _, size, crc, letters = fields.unpack_from(content)
            packed = content[fields.size + letters + 8:]
            kind = bytes(content[fields.size:fields.size + letters])
            data = (zstandard.decompress(packed, size) if kind == b'zstd'
                    else lz4.frame.decompress(packed) if kind == b'lz4' else packed)
            if checked and zlib.crc32(data) != crc:
                raise ValueError('checksum')
            total += len(data)
    return total


def iterated(messages: Iterable, most: int) -> Callable[[], int]:
    """Return a function that takes up to `most` messages and counts them."""
    return lambda: sum(1 for _ in islice(messages, most))


def timed(work: Callable[[], int], repeats: int) -> tuple[float, int]:
    """Return the shortest time, seconds, and the result."""
    best = float('inf')
    for _ in range(repeats):
        begin = perf_counter()
        result = work()
        best = min(best, perf_counter() - begin)
    return best, result


def peers(path: Path, most: int) -> dict[str, tuple[float, int]]:
    """Return time and number of messages of other readers, those that are installed."""
    found = {}
    with open(next(path.glob('*.mcap')), 'rb') as file:
        records = StreamReader(file).records
        found['mcap, records undecoded'] = timed(iterated(
            (r for r in records if isinstance(r, Message)), most), 1)
        file.seek(0)
        reader = make_reader(file)
        reader.get_summary()
        found['mcap, messages'] = timed(
            iterated(reader.iter_messages(log_time_order=False), most), 1)
    try:
        from mcap_ros2.reader import read_ros2_messages
        found['mcap_ros2, decoded'] = timed(
            iterated(read_ros2_messages(str(next(path.glob('*.mcap')))), most), 1)
    except ImportError:
        print('mcap-ros2-support is not installed')
    try:
        from rosbags.highlevel import AnyReader
        with AnyReader([path]) as bag:
            found['rosbags, messages'] = timed(iterated(bag.messages(), most), 1)
            found['rosbags, decoded'] = timed(iterated(
                (bag.deserialize(data, c.msgtype) for c, _, data in bag.messages()), most), 1)
    except ImportError:
        print('rosbags is not installed')
    return found


def main() -> int:
    """Print the times per heading and the ratios; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('count', nargs='?', type=int, default=1_000_000, help='headings in all')
    parser.add_argument('--compression', default='zstd', choices=('none', 'lz4', 'zstd'))
    parser.add_argument('--live', action='store_true',
                        help='chunks of one second, as a recorder writes them')
    parser.add_argument('--peers', type=int, default=200_000, metavar='N',
                        help='messages after which slow readers are stopped')
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'bag')
        took_s = write(path, options.count, BagSettings(compression=options.compression),
                       options.live)
        size = next(path.glob('*.mcap')).stat().st_size
        print(f'{options.count} headings, {size / options.count:.0f} bytes each on disk, written '
              f'in {took_s:.2f} s')
        ours_s, found = timed(lambda: headings(path), 3)
        if found != options.count // 2 * 2:
            raise ValueError(f'{found} headings read')
        plain_s, _ = timed(lambda: chunks(path, False), 3)
        checked_s, _ = timed(lambda: chunks(path, True), 3)
        rows = {'heading_intercompare, headings': (ours_s, found),
                'chunks read and decompressed': (plain_s, found),
                'the same with checksums': (checked_s, found), **peers(path, options.peers)}
    each = {name: seconds / count for name, (seconds, count) in rows.items()}
    ours = each['heading_intercompare, headings']
    for name, seconds in each.items():
        print(f'{name:32s} {seconds * 1e9:10.0f} ns a heading   x {seconds / ours:8.2f}')
    against_mcap = each['mcap, messages'] / ours
    against_chunks = ours / each['chunks read and decompressed']
    print(f'{against_mcap:.0f} times as fast as mcap (at least {LEAST_AGAINST_MCAP:.0f}), '
          f'{against_chunks:.2f} times the chunks alone (at most {MOST_AGAINST_CHUNKS:.0f}), '
          f'{ours_s:.2f} s in all')
    kept = against_mcap >= LEAST_AGAINST_MCAP and (
        against_chunks <= MOST_AGAINST_CHUNKS or options.compression != 'zstd')
    return 0 if kept else 1


if __name__ == '__main__':
    sys.exit(main())
