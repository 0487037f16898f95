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
How many messages of randomly damaged bags `recover` keeps, next to other libraries.

The bags have the layouts of our writer and of rosbag2: chunks in zstd, lz4 and uncompressed, with
checksums and without, no chunks, several files. Each gets one to three damages from a fixed seed:
flipped bytes, a piece cut out, zeroed, overwritten or moved, the end cut off, a flipped bit in the
head of a chunk. A piece has up to a tenth of its file. In the same run each damaged bag is read by
loops as a user would write them, up to the first error: `mcap` by the index (`make_reader`) and
from the first byte on (`NonSeekingReader`, checksums on), `rosbags`, and `pybag`.

Kept is the share of the messages that come back as they were, under their own topic. Foreign are
messages that come back and were never there, or more often than they were. Where nothing has a
checksum, nobody can tell a changed message from a true one; these are counted apart. A crash is an
error that is not the library's own.

Promises for `recover`: it keeps at least 0.85 of all messages and at least 1.5 times the best of
the others; nothing foreign where there are checksums; nothing under another topic; no crash. The
exit code is 1 if a promise is broken.

    python benchmarks/damaged_bags.py
    python benchmarks/damaged_bags.py --bags 90
"""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
import logging
from pathlib import Path
import resource
import shutil
import signal
import sys
import tempfile
from typing import Callable, Iterator, Mapping, NamedTuple

import history
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader, NonSeekingReader
from mcap.stream_reader import CRCValidationError
from mcap.writer import CompressionType, Writer
import numpy as np
from pybag.mcap.error import McapError as PybagError
from pybag.mcap.record_parser import MalformedMCAP
from pybag.mcap_reader import McapFileReader
from rosbags.rosbag2 import Reader, ReaderError

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.bag_yaml import Qos
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.schemas import shipped_schema

STRING = 'std_msgs/msg/String'
HEADINGS = ('/ts/heading', '/rs/heading')
START_NS = 1_400_000_000_000_000_000
KEPT_LEAST, RATIO_LEAST = 0.85, 1.5
#: A library that takes longer for a bag, or more memory, has crashed.
MOST_S, MOST_BYTES = 60, 2**33

#: A message: its topic, and what it is.
Message = tuple[str, object]


class Late(Exception):
    """A library took too long."""


def messages(count: int) -> Iterator[tuple[str, str, int, bytes]]:
    """Yield topic, type, log time and content of headings, and of texts of many lengths."""
    rng = np.random.default_rng(0)
    stamps = START_NS + np.arange(count) * 50_000_000
    sensors = [encode_imu(Headings.of(stamps, rng.uniform(0.0, 360.0, count)), name)
               for name in ('gyro', 'gnss')]
    for place, stamp in enumerate(stamps.tolist()):
        for topic, rows in zip(HEADINGS, sensors):
            yield topic, IMU, stamp, rows[place].tobytes()
        if not place % 5:
            text = rng.bytes(int(rng.integers(1, 200))).hex()
            yield '/remark', STRING, stamp, encode(STRING, {'data': f'{place} {text}'})


def by_us(path: Path, count: int, **settings) -> None:
    """Write a bag as our recorder does."""
    with BagWriter(path, BagSettings(chunk_bytes=20_000, **settings)) as bag:
        bag.metadata('heading_intercompare', {'version': '1'})
        for topic, kind in ((HEADINGS[0], IMU), (HEADINGS[1], IMU), ('/remark', STRING)):
            bag.add_topic(topic, kind)
        for topic, _, stamp, data in messages(count):
            bag.write(topic, data, stamp)
        bag.attachment('runs.csv', 'text/csv', b'start,stop\n')


def by_mcap(path: Path, count: int, **options) -> None:
    """Write a bag with the `mcap` library, in the form of rosbag2; metadata.yaml is ours."""
    by_us(path, count)
    with open(path / f'{path.name}_0.mcap', 'wb') as file:
        writer, numbers = Writer(file, chunk_size=20_000, **options), {}
        writer.start('ros2')
        for kind in (IMU, STRING):
            known = shipped_schema(kind)
            schema = writer.register_schema(kind, known.encoding, known.text.encode())
            for topic in HEADINGS if kind == IMU else ('/remark',):
                numbers[topic] = writer.register_channel(topic, 'cdr', schema, {
                    'offered_qos_profiles': Qos().to_yaml(), 'topic_type_hash': known.type_hash})
        for number, (topic, _, stamp, data) in enumerate(messages(count)):
            writer.add_message(numbers[topic], stamp, data, stamp, number)
        writer.add_metadata('rosbag2', {'serialized_metadata': 'x' * 300})
        writer.finish()


class Layout(NamedTuple):
    """How a bag is written, and whether its messages have checksums."""

    write: Callable[..., None]
    options: Mapping[str, object]
    protected: bool = True


LAYOUTS = {
    'ours, zstd': Layout(by_us, {'compression': 'zstd'}),
    'ours, lz4': Layout(by_us, {'compression': 'lz4'}),
    'ours, uncompressed': Layout(by_us, {'compression': 'none'}),
    'ours, several files': Layout(by_us, {'compression': 'none', 'split_bytes': 100_000}),
    'mcap, zstd': Layout(by_mcap, {'compression': CompressionType.ZSTD}),
    'mcap, lz4': Layout(by_mcap, {'compression': CompressionType.LZ4}),
    'mcap, uncompressed': Layout(by_mcap, {'compression': CompressionType.NONE}),
    'mcap, zstd, no checksums': Layout(by_mcap, {'compression': CompressionType.ZSTD,
                                                 'enable_crcs': False}, False),
    'mcap, no chunks': Layout(by_mcap, {'use_chunking': False}, False)}
DAMAGES = ('flip', 'cut', 'zero', 'overwrite', 'move', 'end', 'head')
#: Bytes of the head of a chunk: from its opcode to the length of its compressed records.
HEAD_BYTES = 57


def chunk_heads(data: bytes) -> Iterator[int]:
    """Yield where chunks begin in the file, up to its first damage."""
    at = 8
    while at + HEAD_BYTES < len(data):
        if data[at] == Opcode.CHUNK:
            yield at
        at += 9 + int.from_bytes(data[at + 1:at + 9], 'little')


def damage(data: bytes, kind: str, rng: np.random.Generator) -> bytes:
    """Return the bytes of a file after a damage."""
    at = int(rng.integers(len(data)))
    size = int(np.exp(rng.uniform(0.0, np.log(max(len(data) // 10, 2)))))
    if kind == 'end':
        return data[:-size]
    if kind == 'head':
        heads = list(chunk_heads(data)) or [at]
        bit = 8 * int(rng.choice(heads)) + int(rng.integers(8 * HEAD_BYTES))
        return data[:bit // 8] + bytes([data[bit // 8] ^ 1 << bit % 8]) + data[bit // 8 + 1:]
    head, piece, tail = data[:at], data[at:at + size], data[at + size:]
    if kind == 'flip':
        spoiled = bytearray(data)
        for place in rng.integers(len(data), size=int(rng.integers(1, 9))).tolist():
            spoiled[place] ^= int(rng.integers(1, 256))
        return bytes(spoiled)
    if kind == 'move':
        other = int(rng.integers(len(tail) + 1))
        return head + tail[:other] + piece + tail[other:]
    return head + {'cut': b'', 'zero': bytes(len(piece)),
                   'overwrite': rng.bytes(len(piece))}[kind] + tail


def spoil(path: Path, number: int) -> None:
    """Damage files of a bag; the number is the seed."""
    rng = np.random.default_rng(number)
    files = sorted(path.glob('*.mcap'))
    for _ in range(int(rng.integers(1, 4))):
        file = files[int(rng.integers(len(files)))]
        data = file.read_bytes()
        if data:
            file.write_bytes(damage(data, DAMAGES[int(rng.integers(len(DAMAGES)))], rng))


def by_recover(path: Path) -> Iterator[Message]:
    """Yield what a recovered bag holds."""
    target = path.with_name('recovered')
    shutil.rmtree(target, ignore_errors=True)
    recover(path, target)
    for each in BagReader(target).messages():
        yield each.topic, (each.log_time_ns, each.data)


def by_index(path: Path) -> Iterator[Message]:
    """Yield what `mcap` reads by the index of each file."""
    for file in sorted(path.glob('*.mcap')):
        with open(file, 'rb') as stream:
            for _, channel, each in make_reader(stream).iter_messages():
                yield channel.topic, (each.log_time, each.data)


def by_stream(path: Path) -> Iterator[Message]:
    """Yield what `mcap` reads of each file from its first byte on."""
    for file in sorted(path.glob('*.mcap')):
        with open(file, 'rb') as stream:
            for _, channel, each in NonSeekingReader(stream, validate_crcs=True).iter_messages(
                    log_time_order=False):
                yield channel.topic, (each.log_time, each.data)


def by_rosbags(path: Path) -> Iterator[Message]:
    """Yield what `rosbags` reads of the bag."""
    with Reader(path) as reader:
        for connection, log_time, data in reader.messages():
            yield connection.topic, (log_time, bytes(data))


def by_pybag(path: Path) -> Iterator[Message]:
    """Yield what `pybag` decodes of each file, topic by topic."""
    for file in sorted(path.glob('*.mcap')):
        with McapFileReader.from_file(file) as reader:
            for topic in reader.get_topics():
                for each in reader.messages(topic):
                    yield topic, (each.log_time, repr(each.data))


READERS: dict[str, tuple[Callable[[Path], Iterator[Message]], tuple[type[Exception], ...]]] = {
    'recover': (by_recover, (BagError,)),
    'mcap, index': (by_index, (McapError,)),
    'mcap, stream': (by_stream, (McapError, CRCValidationError)),
    'rosbags': (by_rosbags, (ReaderError,)),
    'pybag': (by_pybag, (PybagError, MalformedMCAP))}


class Ending:
    """Notes how the reading of a bag ends; no error leaves its `with` block but Ctrl-C."""

    def __init__(self, own: tuple[type[Exception], ...]) -> None:
        self._own = own
        self.crash = ''

    def __enter__(self) -> 'Ending':
        signal.alarm(MOST_S)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> bool:
        signal.alarm(0)
        if kind is None or not issubclass(kind, Exception):
            return False
        if not issubclass(kind, self._own):
            self.crash = kind.__name__
        return True


def read(name: str, path: Path) -> tuple[Counter[Message], str]:
    """Return the messages up to the first error, and the error's name if it is a crash."""
    found: Counter[Message] = Counter()
    each, own = READERS[name]
    with Ending(own) as ending:
        for message in each(path):
            found[message] += 1
    return found, ending.crash


class Score:
    """What a reader made of the damaged bags of a layout."""

    def __init__(self) -> None:
        self.total = self.kept = self.foreign = self.misplaced = 0
        self.crashes: Counter[str] = Counter()

    def take(self, whole: Counter[Message], found: Counter[Message], crash: str) -> None:
        """Compare the messages of a damaged bag with those that it had."""
        self.total += sum(whole.values())
        self.kept += sum((whole & found).values())
        strange = found - whole
        self.foreign += sum(strange.values())
        known = defaultdict(set)
        for topic, what in whole:
            known[what].add(topic)
        self.misplaced += sum(count for (topic, what), count in strange.items()
                              if what in known and topic not in known[what])
        self.crashes.update([crash] if crash else [])

    @property
    def share(self) -> float:
        """Return the share of the messages that is kept."""
        return self.kept / self.total if self.total else 0.0


def measure(folder: Path, bags: int, count: int) -> dict[str, dict[str, Score]]:
    """Damage bags and read them; return the scores by layout and reader."""
    scores = {layout: {name: Score() for name in READERS} for layout in LAYOUTS}
    whole = {}
    for place, (name, layout) in enumerate(LAYOUTS.items()):
        path = folder / f'bag_{place}'
        layout.write(path, count, **layout.options)
        whole[name] = {reader: read(reader, path)[0] for reader in READERS}
        counts = {sum(found.values()) for found in whole[name].values()}
        if len(counts) > 1:
            raise ValueError(f'{name}: undamaged, they read {counts} messages: ' + ', '.join(
                f'{reader} {sum(found.values())}' for reader, found in whole[name].items()))
    for number in range(bags):
        name = list(LAYOUTS)[number % len(LAYOUTS)]
        path = folder / 'damaged'
        shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(folder / f'bag_{number % len(LAYOUTS)}', path)
        spoil(path, number)
        for reader in READERS:
            scores[name][reader].take(whole[name][reader], *read(reader, path))
    return scores


def add_up(scores: Mapping[str, Mapping[str, Score]]) -> dict[str, Score]:
    """Return the scores of all layouts together, by reader."""
    total = {name: Score() for name in READERS}
    for row in scores.values():
        for name, score in row.items():
            for field in ('total', 'kept', 'foreign', 'misplaced'):
                setattr(total[name], field, getattr(total[name], field) + getattr(score, field))
            total[name].crashes += score.crashes
    return total


def main(arguments: list[str] | None = None) -> int:
    """Measure and print; return 1 if a promise is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('--bags', type=int, default=434, help='number of damaged bags')
    parser.add_argument('--count', type=int, default=600, help='headings of a sensor in a bag')
    history.add_option(parser)
    given = parser.parse_args(arguments)

    def too_late(*_: object) -> None:
        raise Late

    # pybag warns of many bags, damaged or not.
    logging.disable(logging.ERROR)
    signal.signal(signal.SIGALRM, too_late)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, resource.RLIM_INFINITY))
    with tempfile.TemporaryDirectory() as folder:
        scores = measure(Path(folder), given.bags, given.count)
    peers = [name for name in READERS if name != 'recover']
    total = add_up(scores)
    print(f'share of the messages of {given.bags} damaged bags that is kept')
    print('| layout |', ' | '.join(READERS), '| of the best other |')
    print('|---' * (len(READERS) + 2) + '|')
    ratios = {}
    for name, row in [*scores.items(), ('all', total)]:
        best = max(row[peer].share for peer in peers)
        ratios[name] = row['recover'].share / best if best else float('inf')
        print(f'| {name} |', ' | '.join(f'{row[reader].share:.3f}' for reader in READERS),
              f'| {ratios[name]:.2f} |')
    guarded = add_up({name: row for name, row in scores.items() if LAYOUTS[name].protected})
    bare = add_up({name: row for name, row in scores.items() if not LAYOUTS[name].protected})
    for what, of in (('foreign, with checksums', lambda reader: guarded[reader].foreign),
                     ('foreign or changed, without', lambda reader: bare[reader].foreign),
                     ('under another topic', lambda reader: total[reader].misplaced),
                     ('crashes', lambda reader: sum(total[reader].crashes.values()))):
        print(f'| {what} |', ' | '.join(str(of(reader)) for reader in READERS), '| |')
    for reader in READERS:
        if total[reader].crashes:
            print(f'{reader} ended with', ', '.join(
                f'{count} {error}' for error, count in total[reader].crashes.most_common()))
    ours = total['recover']
    broken = [what for what, bad in (
        (f'it keeps at least {KEPT_LEAST}', ours.share < KEPT_LEAST),
        (f'at least {RATIO_LEAST} times the best of the others', ratios['all'] < RATIO_LEAST),
        ('nothing foreign where there are checksums', guarded['recover'].foreign > 0),
        ('nothing under another topic', ours.misplaced > 0),
        ('no crash', bool(ours.crashes))) if bad]
    for each in broken:
        print(f'broken: {each}')
    if given.keep:
        history.keep('damaged_bags', {
            f'{reader}: kept': total[reader].share for reader in READERS})
    return int(bool(broken))


if __name__ == '__main__':
    sys.exit(main())
