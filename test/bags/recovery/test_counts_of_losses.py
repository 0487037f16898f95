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

"""Of a closed file with one damage: the messages kept and lost are all that it had."""

from __future__ import annotations

from collections import Counter
import subprocess
import sys

from bags.mcap_bytes import channel, indexed, message, record, schema, sent, write
from mcap.records import Metadata
import numpy as np
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.recovery.recover_bag import recover

N = 3000


def damaged(data: bytes, seed: int) -> bytes:
    """Return a file with some bytes flipped, cut out, zeroed, overwritten, or without its end."""
    rng = np.random.default_rng(seed)
    at, size = int(rng.integers(len(data))), int(rng.integers(1, len(data) // 10))
    kind = seed % 5
    if kind == 0:
        return data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1:]
    if kind == 1:
        return data[:-size]
    return data[:at] + (b'', bytes(size), rng.bytes(size))[kind - 2] + data[at + size:]


@pytest.mark.slow
@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
def test_kept_and_lost_are_all_messages_and_none_is_foreign(write_bag, tmp_path, compression):
    path = write_bag(compression=compression, chunk_bytes=20_000)
    file = path / 'trial_0.mcap'
    whole, data = Counter(sent(path)), file.read_bytes()
    exact = 0
    for seed in range(40):
        file.write_bytes(damaged(data, seed))
        try:
            total = recover(path, tmp_path / str(seed))
        except BagError as error:
            assert 'nothing in it is readable' in str(error)
            continue
        assert not Counter(sent(tmp_path / str(seed))) - whole, seed
        count = total.messages + total.messages_lost
        assert count == N if total.messages_known else count <= N, (seed, total.notes)
        exact += total.messages_known
    assert exact > 20


@pytest.mark.slow
@pytest.mark.process
def test_memory_does_not_grow_with_the_metadata_records(tmp_path):
    """Each has an entry in the index of the new file, and nothing else stays of it."""
    rows = [record(Metadata(name=f'note.{n}', metadata={'text': 'x' * 20})) for n in range(40_000)]
    first = indexed(schema(1), channel(1, '/a'), message(1, 5, b'\0\1\0\0'))
    code = ('import resource, sys; from heading_intercompare.bags.recovery.recover_bag import '
            'recover; recover(sys.argv[1], sys.argv[2]); '
            'print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)')
    peaks = []
    for count in (1, len(rows)):
        path = write(tmp_path / f'{count}.mcap', first, *rows[:count])
        done = subprocess.run([sys.executable, '-c', code, str(path), str(tmp_path / f'{count}')],
                              check=True, text=True, stdout=subprocess.PIPE)
        peaks.append(int(done.stdout) * 1024)
    assert peaks[1] - peaks[0] < 400 * len(rows)
