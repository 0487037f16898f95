# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Bags with bytes flipped, cut and repeated: one clear error or what is there, never anything else.

Set `HEADING_INTERCOMPARE_FUZZ` to the number of examples to look longer than CI does.
"""

from __future__ import annotations

from functools import lru_cache
import os
from pathlib import Path
import resource
import shutil
import tempfile
import time

from mcap.writer import CompressionType, IndexType, Writer
import numpy as np
import pytest

from heading_intercompare.bags.cdr import encode
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.heading_messages import encode_imu, IMU
from heading_intercompare.bags.reader import BagReader
from heading_intercompare.bags.recovery import recover
from heading_intercompare.bags.schemas import shipped_schema
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.bags.writer import BagWriter, Rows
from heading_intercompare.core.records import Headings

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

EXAMPLES = int(os.environ.get('HEADING_INTERCOMPARE_FUZZ', '150'))
STRING = 'std_msgs/msg/String'


def by_us(compression: str) -> bytes:
    """Return a file of this package: headings, a text, metadata, an attachment."""
    stamps = 10**18 + np.arange(200) * 10**8
    with tempfile.TemporaryDirectory() as folder:
        with BagWriter(Path(folder, 'x'), BagSettings(compression=compression,
                                                      chunk_bytes=8000)) as bag:
            bag.metadata('heading_intercompare', {'version': '1'})
            for topic in ('/ts/heading', '/rs/heading'):
                bag.add_topic(topic, IMU)
                rows = encode_imu(Headings.of(stamps, np.linspace(0.0, 359.0, 200)), 'gyro')
                bag.write_rows([Rows(topic, rows, stamps)])
            bag.add_topic('/remark', STRING)
            bag.write('/remark', encode(STRING, {'data': 'x'}), 10**18)
            bag.attachment('runs.csv', 'text/csv', b'start,stop\n')
        return Path(folder, 'x', 'x_0.mcap').read_bytes()


def by_mcap(**options) -> bytes:
    """Return a file of the mcap library."""
    with tempfile.TemporaryFile() as file:
        writer = Writer(file, chunk_size=4000, **options)
        writer.start('ros2')
        number = writer.register_schema(IMU, 'ros2msg', shipped_schema(IMU).text.encode())
        channels = [writer.register_channel(t, 'cdr', number)
                    for t in ('/ts/heading', '/rs/heading')]
        rows = encode_imu(Headings.of(10**18 + np.arange(60), np.arange(60.0)), 'gyro')
        for i, row in enumerate(rows):
            writer.add_message(channels[i % 2], 10**18 + i, row.tobytes(), 10**18 + i, i)
        writer.add_metadata('settings', {'a': 'b'})
        writer.finish()
        file.seek(0)
        return file.read()


@lru_cache(maxsize=None)
def originals() -> tuple[bytes, ...]:
    return (*(by_us(c) for c in ('none', 'lz4', 'zstd')),
            by_mcap(compression=CompressionType.NONE, use_chunking=False),
            by_mcap(compression=CompressionType.ZSTD, enable_crcs=False),
            by_mcap(compression=CompressionType.LZ4, index_types=IndexType.NONE))


SHARE = st.floats(0.0, 1.0, exclude_max=True)
SIZE = st.integers(1, 3000)
DAMAGE = st.one_of(
    st.tuples(st.just('flip'), SHARE, st.integers(1, 255)),
    st.tuples(st.just('cut'), SHARE, SIZE),
    st.tuples(st.just('end'), SHARE, SIZE),
    st.tuples(st.just('zero'), SHARE, SIZE),
    st.tuples(st.just('repeat'), SHARE, SIZE),
    st.tuples(st.just('swap'), SHARE, SIZE),
    # Lengths and counts that claim much.
    st.tuples(st.just('huge'), SHARE, st.integers(1, 8)))


def damaged(data: bytes, damages: list[tuple[str, float, int]]) -> bytes:
    """Return the bytes after each of the damages."""
    for kind, share, size in damages:
        at = int(share * len(data))
        head, piece, tail = data[:at], data[at:at + size], data[at + size:]
        if kind == 'flip' and data:
            data = head + bytes([data[at] ^ size]) + data[at + 1:]
        elif kind == 'cut':
            data = head + tail
        elif kind == 'end':
            data = head
        elif kind == 'zero':
            data = head + bytes(len(piece)) + tail
        elif kind == 'repeat':
            data = head + piece + piece + tail
        elif kind == 'swap':
            data = tail + piece + head
        elif kind == 'huge':
            data = head + b'\xff' * len(piece) + tail
    return data


def read_all(path: Path) -> int:
    """Use all of the reader; return the number of messages read before the first error."""
    count = 0
    try:
        reader = BagReader(path)
        reader.metadata()
        reader.attachments()
        for _ in reader.messages():
            count += 1
        for _ in reader.headings(dict.fromkeys(set(reader.topics) & {'/ts/heading',
                                                                     '/rs/heading'}, 'enu')):
            pass
    except BagError as error:
        assert '\n' not in str(error)
    return count


def recovered(path: Path, target: Path) -> int:
    """Recover a file; check that the result is whole and what it is said to be."""
    try:
        total = recover(path, target)
    except BagError as error:
        assert 'nothing in it is readable' in str(error) and '\n' not in str(error)
        return 0
    reader = BagReader(target)
    assert reader.incomplete is None
    assert sum(1 for _ in reader.messages()) == total.messages == sum(total.counts.values())
    assert 0 <= total.bytes_lost <= total.bytes and total.messages_lost >= 0
    return total.messages


def megabytes() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


@hypothesis.settings(max_examples=EXAMPLES, deadline=5000, derandomize=EXAMPLES == 150,
                     suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(which=st.integers(0, 5), damages=st.lists(DAMAGE, min_size=1, max_size=4))
def examine(which: int, damages: list[tuple[str, float, int]]) -> None:
    """Read and recover one damaged file."""
    folder = Path(tempfile.mkdtemp(prefix='fuzz_'))
    try:
        path = folder / 'x.mcap'
        path.write_bytes(damaged(originals()[which], damages))
        began_s = time.monotonic()
        read_all(path)
        recovered(path, folder / 'new')
        assert time.monotonic() - began_s < 5.0
    finally:
        shutil.rmtree(folder)


def test_damaged_bags_never_end_in_anything_but_one_clear_error():
    """The peak of the process may not grow by more than the files, their chunks and a library."""
    originals()
    before = megabytes()
    examine()
    assert megabytes() - before < 300.0


@pytest.mark.parametrize('which', range(6))
def test_the_originals_are_whole(which, tmp_path):
    (tmp_path / 'x.mcap').write_bytes(originals()[which])
    assert read_all(tmp_path / 'x.mcap') == recovered(tmp_path / 'x.mcap', tmp_path / 'new') > 50
