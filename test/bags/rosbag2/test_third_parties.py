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

"""Our bags in pybag and in the JavaScript libraries of Foxglove, and theirs in ours."""

from __future__ import annotations

import json
from pathlib import Path
import shutil
import subprocess

from deadlines import DEADLINE_S
import numpy as np
import pytest

from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_check import check_bag
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.messages.cdr import decode, encode
from heading_intercompare.messages.heading_messages import (
    encode_imu,
    encode_pairs,
    IMU,
    PAIRS_TYPE,
)

STATUS = 'diagnostic_msgs/msg/DiagnosticArray'
START_NS = 1_406_851_200_000_000_000


@pytest.fixture(params=['none', 'lz4', 'zstd'])
def bag(request, tmp_path, rng):
    """Return a bag with each kind of message that the recorder writes."""
    stamps = START_NS + np.arange(300) * 10_000_000
    ts = Headings.of(stamps, rng.uniform(0.0, 360.0, 300))
    pairs = Pairs.of(stamps[:50], ts.heading_deg[:50], ts.heading_deg[:50] - 0.1)
    status = {'name': 'a', 'message': 'start', 'values': [{'key': 'n', 'value': '3'}]}
    header = {'stamp': {'sec': 1, 'nanosec': 2}, 'frame_id': ''}
    with BagWriter(tmp_path / 'bag', BagSettings(compression=request.param,
                                                 chunk_bytes=20_000)) as bag:
        bag.add_topic('/ts/heading', IMU)
        bag.write_rows([Rows('/ts/heading', encode_imu(ts, 'gyro'), stamps)])
        bag.add_topic('/pairs', PAIRS_TYPE)
        bag.write_rows([Rows('/pairs', encode_pairs(pairs), stamps[:50])])
        bag.add_topic('/compliance/marker', STATUS)
        bag.write('/compliance/marker', encode(STATUS, {'header': header, 'status': [status]}),
                  START_NS)
        bag.add_topic('/compliance/report', 'std_msgs/msg/String')
        bag.write('/compliance/report', encode('std_msgs/msg/String', {'data': 'Länge 54°'}),
                  START_NS)
        bag.metadata('heading_intercompare', {'version': '1'})
        bag.attachment('runs.csv', 'text/csv', b'start,stop\n')
    return bag.path


def ours(path: Path) -> dict[tuple[str, int], object]:
    """Return the messages by topic and time, as JSON would have them."""
    return {(m.topic, m.log_time_ns): json.loads(json.dumps(decode(m.type_name, m.data)))
            for m in BagReader(path).messages()}


def plain(message: object) -> object:
    """Return a message of pybag as a mapping, without the constants of its type."""
    if isinstance(message, (list, tuple)) or hasattr(message, 'tolist'):
        return [plain(m) for m in message]
    if isinstance(message, (str, int, float)):
        return message
    if isinstance(message, bytes):
        return message[0]
    names = getattr(message, '__dataclass_fields__', None) or vars(message)
    return {name: plain(getattr(message, name)) for name in names if not name.isupper()}


def test_pybag_decodes_every_message(bag):
    reader = pytest.importorskip('pybag.mcap_reader', reason='pybag-sdk is not installed')
    with reader.McapFileReader.from_file(bag / 'bag_0.mcap', enable_crc_check=True) as file:
        theirs = {(m.topic, m.log_time): plain(m.data)
                  for topic in file.get_topics() for m in file.messages(topic)}
        assert {r.name for r in file.get_metadata()} >= {'rosbag2', 'heading_intercompare'}
    # Of an attachment pybag 0.13 takes the checksum over its data, MCAP over all its fields.
    with reader.McapFileReader.from_file(bag / 'bag_0.mcap', enable_crc_check=False) as file:
        assert [a.data for a in file.get_attachments()] == [b'start,stop\n']
    expected = ours(bag)
    assert len(expected) == 352 and theirs == expected


def assert_read(path: Path) -> None:
    """Check that all of a file of 200 messages, a metadata record and an attachment is read."""
    reader = BagReader(path)
    assert reader.incomplete is None
    assert [(m.topic, m.log_time_ns, decode(m.type_name, m.data)['data'])
            for m in reader.messages()] == [('/a', 1000 + i, f'm{i}') for i in range(200)]
    assert reader.metadata()['remark'] == {'sea': 'calm'}
    assert [(a.name, a.data) for a in reader.attachments()] == [('a.txt', b'calibration')]
    assert check_bag(path).faults == []


@pytest.mark.parametrize('chunk_size', [None, 3000])
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_what_pybag_writes_is_read(tmp_path, compression, chunk_size):
    writer = pytest.importorskip('pybag.mcap_writer', reason='pybag-sdk is not installed')
    from pybag.ros2.jazzy.std_msgs import String
    path = tmp_path / 'a.mcap'
    with writer.McapFileWriter.open(path, chunk_size=chunk_size,
                                    chunk_compression=compression) as file:
        for i in range(200):
            file.write_message('/a', 1000 + i, String(data=f'm{i}'))
        file.write_metadata('remark', {'sea': 'calm'})
        file.write_attachment('a.txt', b'calibration')
    assert_read(path)


READING = r"""
const { McapIndexedReader } = require('@mcap/core');
const { parse } = require('@foxglove/rosmsg');
const { MessageReader } = require('@foxglove/rosmsg2-serialization');
const zstd = require('fzstd');
const lz4 = require('lz4js');
const fs = require('fs');

async function main() {
  const data = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(data.length),
    read: async (at, length) => new Uint8Array(data.subarray(Number(at), Number(at + length))),
  };
  const reader = await McapIndexedReader.Initialize({
    readable,
    decompressHandlers: { zstd: (b) => zstd.decompress(b), lz4: (b) => lz4.decompress(b) },
  });
  const readers = new Map();
  for (const [id, channel] of reader.channelsById) {
    const text = new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data);
    readers.set(id, new MessageReader(parse(text, { ros2: true })));
  }
  const found = [];
  for await (const message of reader.readMessages()) {
    found.push([reader.channelsById.get(message.channelId).topic, String(message.logTime),
                readers.get(message.channelId).readMessage(message.data)]);
  }
  console.log(JSON.stringify(found,
    (key, value) => ArrayBuffer.isView(value) ? Array.from(value)
      : typeof value === 'bigint' ? Number(value) : value));
}
main();
"""

WRITING = r"""
const { McapWriter } = require('@mcap/core');
const fs = require('fs');

async function main() {
  const pieces = [];
  let size = 0n;
  const writable = {
    write: async (piece) => { pieces.push(Buffer.from(piece)); size += BigInt(piece.length); },
    position: () => size,
  };
  const useChunks = process.argv[3] === 'chunks';
  const writer = new McapWriter({ writable, useChunks, chunkSize: 3000 });
  const bytes = (text) => new TextEncoder().encode(text);
  await writer.start({ profile: 'ros2', library: '' });
  const schemaId = await writer.registerSchema(
    { name: 'std_msgs/msg/String', encoding: 'ros2msg', data: bytes('string data\n') });
  const channelId = await writer.registerChannel(
    { schemaId, topic: '/a', messageEncoding: 'cdr', metadata: new Map() });
  for (let i = 0; i < 200; i++) {
    const data = Buffer.from(`\0\u0001\0\0\0\0\0\0m${i}\0`);
    data.writeUInt32LE(data.length - 8, 4);
    const time = BigInt(1000 + i);
    await writer.addMessage({ channelId, sequence: i, logTime: time, publishTime: time, data });
  }
  await writer.addMetadata({ name: 'remark', metadata: new Map([['sea', 'calm']]) });
  await writer.addAttachment({ name: 'a.txt', mediaType: 'text/plain', logTime: 5n,
                               createTime: 6n, data: bytes('calibration') });
  await writer.end();
  fs.writeFileSync(process.argv[2], Buffer.concat(pieces));
}
main();
"""


@pytest.fixture(scope='module')
def javascript(tmp_path_factory):
    """Return a folder with the libraries, and scripts that read and write a file."""
    if shutil.which('node') is None or shutil.which('npm') is None:
        pytest.skip('node and npm are not installed')
    folder = tmp_path_factory.mktemp('npm')
    (folder / 'package.json').write_text('{"private": true}')
    (folder / 'read.js').write_text(READING)
    (folder / 'write.js').write_text(WRITING)
    try:
        subprocess.run(['npm', 'install', '--no-audit', '--no-fund', '--ignore-scripts',
                        '@mcap/core@2', '@foxglove/rosmsg@5', '@foxglove/rosmsg2-serialization@3',
                        'fzstd@0.1', 'lz4js@0.2'],
                       cwd=folder, check=True, capture_output=True, timeout=120)
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired) as error:
        pytest.skip(f'npm cannot install the libraries: {error}')
    return folder


@pytest.mark.process
@pytest.mark.slow
def test_the_libraries_of_foxglove_decode_every_message(bag, javascript):
    done = subprocess.run(['node', 'read.js', str(bag / 'bag_0.mcap')], cwd=javascript,
                          capture_output=True, text=True, timeout=DEADLINE_S)
    assert done.returncode == 0, done.stderr
    theirs = {(topic, int(stamp)): without_rounding(message)
              for topic, stamp, message in json.loads(done.stdout)}
    expected = ours(bag)
    assert len(expected) == 352 and theirs == expected


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize('chunks', ['chunks', 'none'])
def test_what_the_library_of_foxglove_writes_is_read(tmp_path, javascript, chunks):
    path = tmp_path / 'a.mcap'
    done = subprocess.run(['node', 'write.js', str(path), chunks], cwd=javascript,
                          capture_output=True, text=True, timeout=DEADLINE_S)
    assert done.returncode == 0, done.stderr
    assert_read(path)


def without_rounding(message: object) -> object:
    """Return a message with `nsec` as ROS 2 calls it; JavaScript prints 0 and -0 alike."""
    if isinstance(message, dict):
        return {'nanosec' if name == 'nsec' else name: without_rounding(value)
                for name, value in message.items()}
    if isinstance(message, list):
        return [without_rounding(value) for value in message]
    return message
