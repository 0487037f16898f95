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
How fast `recover` copies cut bags, next to reading their chunks and to the `mcap` library.

The bags hold Imu, and their file ends within a chunk. They are written in large chunks, as our
simulator does; in one chunk per half second, as our recorder does; and by the `mcap` library, like
`ros2 bag record`. Each is recovered unchanged, and with all chunks compressed again. In the same
run it measures, each as the shortest of several alternating rounds: reading, decompressing and
checksumming all chunks once; copying the file to the same disk; and copying the first messages one
by one with `mcap`, the only other Python library that reads and writes such files.

Promises, where chunks are copied unchanged: at most 3 times the time of reading, decompressing and
checksumming the chunks if they are compressed with zstd; at most 3 times that time plus copying
the file, in any compression; at least 10 times as fast as `mcap`. The exit code is 1 if a promise
is broken. Install the extra `fast` first.

    python benchmarks/recover.py
    python benchmarks/recover.py --bags large --compression zstd --count 8640000
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
from typing import NamedTuple

from bag_reading import file_of, IMU, measure_time, WRITERS
import history
import lz4.frame
from mcap.reader import NonSeekingReader
from mcap.writer import Writer as McapWriter
import zstandard

from heading_intercompare.bags.mcap.checksum import crc32
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.settings import BagSettings

BAGS = ('large', 'live', 'mcap')
CHUNKS_MOST, COPY_MOST, MCAP_LEAST = 3.0, 3.0, 10.0
#: The `mcap` library takes too long to write more.
MCAP_MOST = 400_000
#: The share of each file that is left after the cut.
SHARE = 0.99


def chunks(path: Path) -> int:
    """Read, decompress and checksum the whole chunks; return their number."""
    head, fields, count = struct.Struct('<BQ'), struct.Struct('<QQQII'), 0
    with open(file_of(path), 'rb') as file:
        file.seek(8)
        while len(opening := file.read(head.size)) == head.size:
            opcode, length = head.unpack(opening)
            if opcode != 6:
                file.seek(length, 1)
                continue
            content = memoryview(file.read(length))
            if len(content) < length:
                break
            _, _, size, crc, letters = fields.unpack_from(content)
            packed = content[fields.size + letters + 8:]
            kind = bytes(content[fields.size:fields.size + letters])
            data = (zstandard.decompress(packed, size) if kind == b'zstd'
                    else lz4.frame.decompress(packed) if kind == b'lz4' else packed)
            if crc32(data) != crc:
                raise ValueError('a chunk is damaged')
            count += 1
    return count


def recover_bag(path: Path, target: Path, settings: BagSettings | None) -> int:
    """Recover a bag into a folder, after removing the folder; return the number of messages."""
    shutil.rmtree(target, ignore_errors=True)
    return recover(path, target, settings).messages


def copy_file(path: Path, target: Path) -> int:
    """Copy the file to the disk; return its size."""
    shutil.copyfile(file_of(path), target)
    with open(target, 'rb') as file:
        os.fsync(file.fileno())
    return target.stat().st_size


def by_mcap(path: Path, target: Path, most: int) -> float:
    """Return the time per message of copying the first messages with `mcap`, seconds."""
    with open(file_of(path), 'rb') as source, open(target, 'wb') as file:
        writer, numbers = McapWriter(file), {}
        writer.start('ros2')
        begin, count = perf_counter(), 0
        for schema, channel, message in islice(
                NonSeekingReader(source, validate_crcs=True).iter_messages(log_time_order=False),
                most):
            if channel.id not in numbers:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, number, channel.metadata)
            writer.add_message(numbers[channel.id], message.log_time, message.data,
                               message.publish_time, message.sequence)
            count += 1
        writer.finish()
        return (perf_counter() - begin) / count


def peak_mb(path: Path, target: Path) -> float:
    """Return the most memory that a process which recovers a bag has, MB."""
    shutil.rmtree(target, ignore_errors=True)
    code = ('import sys; from heading_intercompare.bags.recovery.recover_bag import recover; '
            'recover(sys.argv[1], sys.argv[2]); '
            'print(open("/proc/self/status").read().partition("VmHWM:")[2].split()[0])')
    done = subprocess.run([sys.executable, '-c', code, str(path), str(target)], check=True,
                          text=True, stdout=subprocess.PIPE)
    return int(done.stdout) / 1024


class Measured(NamedTuple):
    """What was measured of a bag: times in seconds, memory in MB, bytes of its file."""

    messages: int
    size: int
    ours: float
    chunks: float
    copy: float
    anew: float
    mcap: float
    memory: float

    @property
    def ratios(self) -> tuple[float, float, float]:
        """Our time over that of chunks, over that of chunks and a copy; `mcap`'s over ours."""
        return (self.ours / self.chunks, self.ours / (self.chunks + self.copy),
                self.mcap * self.messages / self.ours)


def measure(folder: Path, name: str, packed: str, count: int, most: int) -> Measured:
    """Write a bag of the given kind, cut it and recover it."""
    path, target = folder / 'bag', folder / 'new'
    WRITERS[name](path, min(count, MCAP_MOST) if name == 'mcap' else count, IMU, packed)
    size = int(SHARE * file_of(path).stat().st_size)
    os.truncate(file_of(path), size)
    messages = recover_bag(path, target, None)
    works = (lambda: recover_bag(path, target, None), lambda: chunks(path),
             lambda: copy_file(path, folder / 'copy.mcap'))
    times = [min(taken) for taken in zip(*([measure_time(work) for work in works]
                                           for _ in range(5 if messages < 2_000_000 else 3)))]
    other = BagSettings(compression='lz4' if packed == 'zstd' else 'zstd')
    return Measured(messages, size, *times, measure_time(lambda: recover_bag(path, target, other)),
                    by_mcap(path, folder / 'peer.mcap', most), peak_mb(path, target))


def main() -> int:
    """Print a row for each bag; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--count', type=int, default=1_200_000, help='total number of headings')
    parser.add_argument('--bags', nargs='+', default=list(BAGS), choices=list(BAGS))
    parser.add_argument('--compression', nargs='+', default=['zstd', 'lz4', 'none'])
    parser.add_argument('--peer', type=int, default=50_000, metavar='N',
                        help='messages after which to stop copying with mcap')
    parser.add_argument('--folder', help='where to write the bags; by default that of tempfile')
    history.add_option(parser)
    options = parser.parse_args()
    print('seconds to recover, to read all chunks, to copy the file, to recover with everything\n'
          'compressed again; our time relative to chunks, and to chunks and a copy; mcap '
          'relative to us;\npeak memory')
    print(f'{"bag":7s}{"packed":7s}{"messages":>9s}{"MB":>6s}{"recover":>9s}{"chunks":>8s}'
          f'{"copy":>7s}{"anew":>7s}{"/chunks":>9s}{"/both":>7s}{"mcap":>7s}{"peak MB":>9s}')
    broken, figures = [], {}
    for name in options.bags:
        for packed in options.compression:
            with tempfile.TemporaryDirectory(dir=options.folder) as folder:
                found = measure(Path(folder), name, packed, options.count // 2 * 2, options.peer)
            of_chunks, of_both, of_mcap = found.ratios
            print(f'{name:7s}{packed:7s}{found.messages:9d}{found.size / 1e6:6.0f}'
                  f'{found.ours:9.2f}{found.chunks:8.2f}{found.copy:7.2f}{found.anew:7.2f}'
                  f'{of_chunks:9.2f}{of_both:7.2f}{of_mcap:7.1f}{found.memory:9.0f}', flush=True)
            figures |= {f'{name}, {packed}: ours / chunks': of_chunks,
                        f'{name}, {packed}: mcap / ours': of_mcap}
            if (of_mcap < MCAP_LEAST or of_both > COPY_MOST
                    or (packed == 'zstd' and of_chunks > CHUNKS_MOST)):
                broken.append(f'{name} {packed}')
    print(f'promises: /chunks at most {CHUNKS_MOST:.0f} (zstd), /both at most {COPY_MOST:.0f}, '
          f'mcap at least {MCAP_LEAST:.0f}')
    for each in broken:
        print(f'broken for {each}')
    if options.keep:
        history.keep('recover', figures)
    return 1 if broken else 0


if __name__ == '__main__':
    sys.exit(main())
