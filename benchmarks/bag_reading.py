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
How fast headings are read from bags, next to other readers of the same bags in the same run.

The bags hold Imu or QuaternionStamped, in every compression. They are written in large chunks, as
our simulator and `import` do; in one chunk per half second with pairs between the headings,
as our recorder does; by the `mcap` library, like `ros2 bag record`; and by `rosbags`.

Our reader is measured as `analyze` uses it, with one process per core, and in a single process.

Promises: at least 40 times as fast as iterating over the messages with `mcap`; at least 20 times
as fast as `rosbags`, which must deserialize to know a heading; and at most 3 times the time it
takes only to read and decompress the chunks, without checksums. The last holds for files in
memory. For uncompressed QuaternionStamped it holds for files on disk, because copying a message of
95 bytes in memory takes less time than a numpy call. The exit code is 1 if a promise is broken.
It needs two cores, bags of hours, and the extra `fast` with its checksums. A row with 12 h written
by others takes minutes.

    python benchmarks/bag_reading.py
    python benchmarks/bag_reading.py --bags large --compression zstd --count 2000000
"""

from __future__ import annotations

import argparse
from itertools import islice
import os
from pathlib import Path
import shutil
import struct
import subprocess
import sys
import tempfile
from time import perf_counter
from typing import Callable, Iterable, Iterator

import history
import lz4.frame
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer as McapWriter
import numpy as np
import zstandard

from heading_intercompare.app.campaign import count_cores, MOST_READERS
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.angles import quaternion_from_heading
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import (
    encode_imu,
    encode_pairs,
    IMU,
    PAIRS_TYPE,
)
from heading_intercompare.messages.schemas import shipped_schema

TOPICS = ('/ts/heading', '/rs/heading')
FRAMES = ('gyro_ts', 'rs')
QUATERNION = 'geometry_msgs/msg/QuaternionStamped'
RATE_HZ = 100
LIGHTEST = QUATERNION, 'none'
MCAP_LEAST, ROSBAGS_LEAST, CHUNKS_MOST = 40.0, 20.0, 3.0
HELPERS = min(count_cores(), MOST_READERS) - 1
#: Default chunk size of rosbag2.
ROS2_CHUNK_BYTES = 786432


def encode_quaternions(headings: Headings, frame_id: str) -> np.ndarray:
    """Return headings as QuaternionStamped, one message per row."""
    message = encode(QUATERNION, {'header': {'frame_id': frame_id}})
    rows = np.tile(np.frombuffer(message, np.uint8), (len(headings), 1))
    z, w = quaternion_from_heading(headings.heading_deg)
    sec, nanosec = np.divmod(headings.stamp_ns, 10**9)
    for at, column in ((4, sec.astype('<i4')), (8, nanosec.astype('<u4')),
                       (len(message) - 16, z), (len(message) - 8, w)):
        rows[:, at:at + column.itemsize] = np.ascontiguousarray(column).reshape(-1, 1).view('u1')
    return rows


def encode_headings(type_name: str, headings: Headings, frame_id: str) -> np.ndarray:
    """Return headings as messages of a type, one per row."""
    if type_name == IMU:
        return encode_imu(headings, frame_id, sigma_deg=0.2)
    return encode_quaternions(headings, frame_id)


def make_headings(count: int, step: int) -> Iterator[tuple[np.ndarray, list[Headings]]]:
    """Yield numbers and headings of both sensors, `step` readings of each at a time."""
    rng = np.random.default_rng(1)
    for lo in range(0, count // 2, step):
        number = np.arange(lo, min(lo + step, count // 2))
        stamp_ns = 10**18 + number * (10**9 // RATE_HZ) + rng.integers(0, 10**5, len(number))
        true_deg = 90.0 + 80.0 * np.sin(number / 2000.0)
        yield number, [
            Headings.of(stamp_ns + late_ns, true_deg + rng.normal(0.0, 0.2, len(number)))
            for late_ns in (0, 3_000_000)]


def write_ours(path: Path, count: int, type_name: str, compression: str, live: bool) -> None:
    """Write a bag in large chunks; or live, as a recorder does."""
    with BagWriter(path, BagSettings(compression=compression)) as bag:
        for topic in TOPICS:
            bag.add_topic(topic, type_name)
        if live:
            bag.add_topic('/pairs', PAIRS_TYPE)
        for number, both in make_headings(count, RATE_HZ // 2 if live else 60 * RATE_HZ):
            rows = [Rows(topic, encode_headings(type_name, headings, frame), headings.stamp_ns,
                         sequence=number)
                    for topic, frame, headings in zip(TOPICS, FRAMES, both)]
            if live:
                ts, rs = both
                pairs = Pairs.of(ts.stamp_ns, ts.heading_deg, rs.heading_deg,
                                 rs.stamp_ns - ts.stamp_ns, np.ones(len(ts)))
                rows.append(Rows('/pairs', encode_pairs(pairs), ts.stamp_ns + 5_000_000,
                                 sequence=number))
            bag.write_rows(rows)
            if live:
                bag.flush()


def make_messages(count: int, type_name: str) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield index of the topic, number, stamp and message, in the order of recording."""
    for number, both in make_headings(count, 60 * RATE_HZ):
        rows = [encode_headings(type_name, headings, frame)
                for headings, frame in zip(both, FRAMES)]
        for row, each in enumerate(number.tolist()):
            for place, headings in enumerate(both):
                yield place, each, int(headings.stamp_ns[row]), rows[place][row].tobytes()


def write_mcap(path: Path, count: int, type_name: str, compression: str) -> None:
    """Write a bag with the `mcap` library, following the conventions of `ros2 bag record`."""
    path.mkdir()
    with open(path / 'bag_0.mcap', 'wb') as file:
        bag = McapWriter(file, chunk_size=ROS2_CHUNK_BYTES,
                         compression=CompressionType[compression.upper()])
        bag.start('ros2')
        schema = bag.register_schema(type_name, 'ros2msg', shipped_schema(type_name).text.encode())
        channels = [bag.register_channel(topic, 'cdr', schema) for topic in TOPICS]
        for place, number, stamp_ns, data in make_messages(count, type_name):
            bag.add_message(channels[place], stamp_ns, data, stamp_ns, number)
        bag.finish()


def write_rosbags(path: Path, count: int, type_name: str, compression: str) -> None:
    """Write a bag with `rosbags`, which compresses only with zstd."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import get_typestore, Stores
    store = get_typestore(Stores.ROS2_JAZZY)
    bag = Writer(path, version=9, storage_plugin=StoragePlugin.MCAP)
    if compression == 'zstd':
        bag.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with bag:
        connections = [bag.add_connection(topic, type_name, typestore=store) for topic in TOPICS]
        for place, _, stamp_ns, data in make_messages(count, type_name):
            bag.write(connections[place], stamp_ns, data)


WRITERS: dict[str, Callable[[Path, int, str, str], None]] = {
    'large': lambda *args: write_ours(*args, live=False),
    'live': lambda *args: write_ours(*args, live=True),
    'mcap': write_mcap,
    'rosbags': write_rosbags,
}


def file_of(path: Path) -> Path:
    """Return the only file of a bag that holds messages."""
    return next(path.glob('*.mcap'))


def headings(path: Path, helpers: int = HELPERS) -> int:
    """Read the headings of both sensors; return their number."""
    conventions = dict.fromkeys(TOPICS, 'enu')
    return sum(len(part) for chunk in BagReader(path).headings(conventions, helpers)
               for part in chunk.values())


def chunks(path: Path) -> int:
    """Only read and decompress the chunks; return their size."""
    head, fields, total = struct.Struct('<BQ'), struct.Struct('<QQQII'), 0
    with open(file_of(path), 'rb') as file:
        file.seek(8)
        while len(opening := file.read(head.size)) == head.size:
            opcode, length = head.unpack(opening)
            if opcode != 6:
                file.seek(length, 1)
                if opcode == 15:
                    break
                continue
            content = memoryview(file.read(length))
            size, letters = fields.unpack_from(content)[2::2]
            packed = content[fields.size + letters + 8:]
            kind = bytes(content[fields.size:fields.size + letters])
            total += len(zstandard.decompress(packed, size) if kind == b'zstd'
                         else lz4.frame.decompress(packed) if kind == b'lz4' else packed)
    return total


def measure_time(work: Callable[[], int]) -> float:
    """Return how long something takes, seconds."""
    begin = perf_counter()
    work()
    return perf_counter() - begin


def measure_iteration(messages: Iterable, most: int) -> float:
    """Return the time per message for the first messages, seconds."""
    begin = perf_counter()
    count = sum(1 for _ in islice(messages, most))
    return (perf_counter() - begin) / count


def by_mcap(path: Path, most: int) -> float:
    """Return the time per heading of iterating with `mcap`, undecoded, ordered by log time."""
    with open(file_of(path), 'rb') as file:
        reader = make_reader(file)
        reader.get_summary()
        # In file order it would first load all messages into memory.
        return measure_iteration(reader.iter_messages(TOPICS), most)


def by_rosbags(path: Path, most: int) -> tuple[float, float]:
    """Return the time per message of iterating with `rosbags`: undecoded, and deserialized."""
    from rosbags.highlevel import AnyReader
    with AnyReader([file_of(path)]) as bag:
        kept = [c for c in bag.connections if c.topic in TOPICS]
        return measure_iteration(bag.messages(kept), most), measure_iteration(
            (bag.deserialize(data, c.msgtype) for c, _, data in bag.messages(kept)), most)


def from_disk(path: Path, work: Callable[[Path], int]) -> float:
    """Return how long something takes when the file is not cached in memory, seconds."""
    with open(file_of(path), 'rb') as file:
        os.fsync(file.fileno())
        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    return measure_time(lambda: work(path))


def measure(path: Path, count: int, most: int) -> dict[str, float]:
    """Return times in nanoseconds per heading, each the shortest of several alternating rounds."""
    best = dict.fromkeys(('ours', 'alone', 'chunks'), float('inf'))
    for _ in range(7 if count <= 2_000_000 else 3):
        best['chunks'] = min(best['chunks'], measure_time(lambda: chunks(path)))
        best['ours'] = min(best['ours'], measure_time(lambda: headings(path)))
        best['alone'] = min(best['alone'], measure_time(lambda: headings(path, 0)))
    found = {**{name: seconds / count for name, seconds in best.items()},
             'mcap': by_mcap(path, most),
             'ours, disk': from_disk(path, headings) / count,
             'chunks, disk': from_disk(path, chunks) / count}
    found['rosbags'], found['decoded'] = by_rosbags(path, most)
    return {name: seconds * 1e9 for name, seconds in found.items()}


def peak_mb(path: Path) -> float:
    """Return the peak memory of the processes that read the headings, MB."""
    code = ('import resource, sys; from pathlib import Path; import bag_reading; '
            'bag_reading.headings(Path(sys.argv[1])); '
            'status = Path("/proc/self/status").read_text(); '
            'print(int(status.partition("VmHWM:")[2].split()[0]) + bag_reading.HELPERS * '
            'resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)')
    folders = os.pathsep.join([str(Path(__file__).parent), os.environ.get('PYTHONPATH', '')])
    kib = subprocess.run([sys.executable, '-c', code, str(path)], check=True, text=True,
                         stdout=subprocess.PIPE, env={**os.environ, 'PYTHONPATH': folders}).stdout
    return int(kib) / 1024


def main() -> int:
    """Print a row for each bag; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=8_640_000,
                        help='total number of headings (default: 12 h)')
    parser.add_argument('--bags', nargs='+', default=list(WRITERS), choices=list(WRITERS))
    parser.add_argument('--types', nargs='+', default=[IMU, QUATERNION])
    parser.add_argument('--compression', nargs='+', default=['zstd', 'lz4', 'none'])
    parser.add_argument('--peers', type=int, default=100_000, metavar='N',
                        help='messages after which to stop slow readers')
    history.add_option(parser)
    options = parser.parse_args()
    print('ours and alone in ns per heading; times of the others relative to ours; our time '
          'relative to chunks\nalone, with the file in memory and from disk; peak memory')
    print(f'{"bag":8s}{"type":20s}{"packed":8s}{"ours":>6s}{"alone":>7s}{"mcap":>8s}'
          f'{"rosbags":>9s}{"decoded":>9s}{"chunks":>8s}{"disk":>6s}{"peak MB":>9s}')
    broken, figures = [], {}
    for name in options.bags:
        for type_name in options.types:
            for compression in options.compression:
                if (name, compression) in {('rosbags', 'lz4'), ('rosbags', 'zstd')}:
                    continue
                with tempfile.TemporaryDirectory() as folder:
                    path = Path(folder, 'bag')
                    count = options.count // 2 * 2
                    WRITERS[name](path, count, type_name, compression)
                    if headings(path) != count:
                        raise ValueError('not all headings were read')
                    found = measure(path, count, options.peers)
                    memory = peak_mb(path)
                    shutil.rmtree(path)
                ours = found['ours']
                times = {each: found[each] / ours for each in ('mcap', 'rosbags', 'decoded')}
                share = ours / found['chunks']
                on_disk = found['ours, disk'] / found['chunks, disk']
                print(f'{name:8s}{type_name.split("/")[-1]:20s}{compression:8s}{ours:6.0f}'
                      f'{found["alone"]:7.0f}'
                      + ''.join(f'{times[each]:{width}.1f}' for each, width in (
                          ('mcap', 8), ('rosbags', 9), ('decoded', 9)))
                      + f'{share:8.2f}{on_disk:6.2f}{memory:9.0f}', flush=True)
                row = f'{name}, {type_name.split("/")[-1]}, {compression}'
                figures |= {f'{row}: mcap / ours': times['mcap'],
                            f'{row}: rosbags / ours': times['decoded'],
                            f'{row}: ours / chunks': share}
                held = on_disk if (type_name, compression) == LIGHTEST else share
                if (times['mcap'] < MCAP_LEAST or times['decoded'] < ROSBAGS_LEAST
                        or held > CHUNKS_MOST):
                    broken.append(f'{name} {type_name} {compression}')
    print(f'promises: mcap at least {MCAP_LEAST:.0f}, decoded at least {ROSBAGS_LEAST:.0f}, '
          f'chunks at most {CHUNKS_MOST:.0f} (QuaternionStamped uncompressed: disk)')
    for each in broken:
        print(f'broken for {each}')
    if options.keep:
        history.keep('bag_reading', figures)
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
