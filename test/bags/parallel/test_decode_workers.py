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

"""Bags decoded by several processes: the same to the bit, whatever happens to a helper."""

from __future__ import annotations

import multiprocessing
import os
from pathlib import Path
import signal
import subprocess
import sys
import threading
import time

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.parallel import decode_workers
from heading_intercompare.bags.parallel.decoding import Decoder
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings

pytestmark = [pytest.mark.process,
              pytest.mark.skipif(sys.platform != 'linux', reason='there are no helpers')]

BOTH = {'/ts/heading': 'enu', '/rs/heading': 'ned'}


@pytest.fixture(autouse=True)
def small_stretches(monkeypatch):
    """Treat small bags as large ones, whatever threads other tests have left running."""
    monkeypatch.setattr(decode_workers, '_FEWEST', 6)
    monkeypatch.setattr('heading_intercompare.bags.mcap.mcap_file._BLOCK_BYTES', 8000)
    monkeypatch.setattr(decode_workers, 'active_count', lambda: 1)


@pytest.fixture
def here(monkeypatch):
    """Return the list of stretches that are decoded in this process."""
    done, decode, process = [], Decoder.stretch, os.getpid()

    def stretch(self, number, stretch):
        if os.getpid() == process:
            done.append(stretch)
        return decode(self, number, stretch)
    monkeypatch.setattr(Decoder, 'stretch', stretch)
    return done


def minutes(path, count: int) -> tuple[list, str | None]:
    """Return all headings in order of arrival, and the error at the end."""
    found = []
    try:
        for minute in BagReader(path).headings(BOTH, count):
            found.append(minute)
    except BagError as error:
        return found, str(error)
    return found, None


def joined(found: tuple[list, str | None]) -> dict[str, Headings]:
    """Return all headings by topic."""
    assert found[1] is None
    return {topic: Headings.concatenate([minute[topic] for minute in found[0]])
            for topic in BOTH}


def tasks(path) -> int:
    """Return the number of stretches of a bag."""
    return sum(len(part.stretches()) for part in BagReader(path)._parts)


@pytest.mark.parametrize('compression', ['none', 'lz4', 'zstd'])
@pytest.mark.parametrize('count', [1, 3])
def test_helpers_give_the_same_to_the_bit_and_take_work(write_bag, here, compression, count):
    path = write_bag(compression=compression, chunk_bytes=5000)
    alone = minutes(path, 0)
    assert len(here) == tasks(path) > 20
    here.clear()
    assert minutes(path, count) == alone
    assert len(here) <= tasks(path) - decode_workers._SLOTS
    assert sum(len(each) for minute in alone[0] for each in minute.values()) == 3000


def test_helpers_go_from_file_to_file(write_bag, here):
    path = write_bag(chunk_bytes=5000, split_bytes=20_000)
    assert len(list(path.glob('*.mcap'))) > 1
    alone = minutes(path, 0)
    here.clear()
    assert minutes(path, 2) == alone
    assert len(here) <= tasks(path) - decode_workers._SLOTS


def test_an_unfinished_bag_is_divided_too(write_bag, here):
    path = write_bag(chunk_bytes=5000)
    file = next(path.glob('*.mcap'))
    file.write_bytes(file.read_bytes()[:-3000])
    alone = minutes(path, 0)
    here.clear()
    assert minutes(path, 1) == alone and alone[0]
    assert len(here) <= tasks(path) - decode_workers._SLOTS > 10


def test_damage_is_found_where_it_is(write_bag):
    path = write_bag(chunk_bytes=5000, compression='none')
    file = next(path.glob('*.mcap'))
    data = bytearray(file.read_bytes())
    data[len(data) * 2 // 3] ^= 1
    file.write_bytes(data)
    alone = minutes(path, 0)
    assert 'checksum' in alone[1] and 'at byte' in alone[1]
    assert minutes(path, 2) == alone


def test_an_index_that_names_wrong_places_is_refused_alike(write_bag, monkeypatch):
    path = write_bag(chunk_bytes=5000, split_bytes=20_000)
    divide = BagReader.__init__

    def astray(self, *args):
        divide(self, *args)
        for part in self._parts:
            part._chunks = [row._replace(begin=row.begin + 7) for row in part._chunks]
    monkeypatch.setattr(BagReader, '__init__', astray)
    alone = minutes(path, 0)
    assert 'the index of the file does not fit this chunk' in alone[1]
    assert minutes(path, 2) == alone


@pytest.mark.parametrize('name, value', [('parallel.decoding._MOST_MESSAGES', 10),
                                         ('parallel.decoding._MOST_BYTES', 100),
                                         ('parallel.decode_workers._SLOT_BYTES', 200)])
def test_stretches_that_are_too_large_are_read_all_the_same(write_bag, monkeypatch, name, value):
    path = write_bag(chunk_bytes=5000)
    expected = minutes(path, 0)
    monkeypatch.setattr(f'heading_intercompare.bags.{name}', value)
    assert minutes(path, 1) == minutes(path, 0)
    assert joined(minutes(path, 1)) == joined(expected)


@pytest.mark.parametrize('after', [0, 1])
def test_work_of_helpers_that_die_is_done_here(write_bag, after, monkeypatch):
    path = write_bag(chunk_bytes=5000)
    alone = minutes(path, 0)
    process, decode = os.getpid(), Decoder.stretch
    done = []

    def dying(self, number, stretch):
        done.append(stretch)
        if os.getpid() != process and len(done) > after:
            os.kill(os.getpid(), signal.SIGKILL)
        return decode(self, number, stretch)
    monkeypatch.setattr(Decoder, 'stretch', dying)
    assert minutes(path, 2) == alone
    assert len(done) >= tasks(path) - 2 * after


def test_where_no_process_can_be_started_it_is_read_alone(write_bag, monkeypatch):
    path = write_bag(chunk_bytes=5000)
    expected = minutes(path, 0)

    def refused(*args):
        raise BlockingIOError(11, 'Resource temporarily unavailable')
    monkeypatch.setattr(decode_workers, '_Helper', refused)
    assert minutes(path, 2) == expected


def test_helpers_end_with_the_iteration(write_bag):
    iterator = BagReader(write_bag(chunk_bytes=5000)).headings(BOTH, 2)
    next(iterator)
    assert len(multiprocessing.active_children()) == 2
    iterator.close()
    assert not multiprocessing.active_children()


def test_beside_threads_and_for_small_bags_there_are_none(write_bag, monkeypatch):
    path = write_bag(chunk_bytes=5000)
    monkeypatch.setattr(decode_workers, 'active_count', threading.active_count)
    monkeypatch.setattr(decode_workers, '_Helper', None)
    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)
    thread.start()
    try:
        assert minutes(path, 2)[0]
    finally:
        stop.set()
        thread.join()
    monkeypatch.undo()
    monkeypatch.setattr(decode_workers, '_Helper', None)
    assert tasks(path) < decode_workers._FEWEST and minutes(path, 2)[0]


@pytest.mark.parametrize('times, count', [(1, 0), (2, 1), (3.5, 2), (9, 3)])
def test_large_stretches_are_decoded_by_fewer(write_bag, monkeypatch, times, count):
    path = write_bag(chunk_bytes=5000)
    largest = max(each.size for part in BagReader(path)._parts for each in part.stretches())
    monkeypatch.setattr(decode_workers, '_MOST_BYTES', int(times * largest))
    iterator = BagReader(path).headings(BOTH, 3)
    next(iterator)
    assert len(multiprocessing.active_children()) == count
    iterator.close()


def script(path, first: str, last: str = '') -> subprocess.CompletedProcess:
    """Run a program that begins to read a bag with two helpers, prints their ids and goes on."""
    root = str(Path(decode_workers.__file__).parents[3])
    return subprocess.run([sys.executable, '-c', f"""
import multiprocessing, os, signal
from heading_intercompare.bags.parallel import decode_workers
from heading_intercompare.bags.mcap import mcap_file
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
mcap_file._BLOCK_BYTES = 8000
decode_workers._FEWEST = 6
{first}
iterator = BagReader({str(path)!r}).headings({BOTH!r}, 2)
next(iterator)
print(*(child.pid for child in multiprocessing.active_children()), flush=True)
{last}
"""], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120, env={
        **os.environ, 'PYTHONPATH': os.pathsep.join([root, os.environ.get('PYTHONPATH', '')])})


def test_no_helper_outlives_its_parent(write_bag):
    done = script(write_bag(chunk_bytes=5000), '', 'os.kill(os.getpid(), signal.SIGKILL)')
    assert done.returncode == -signal.SIGKILL and not done.stderr
    children = done.stdout.split()
    assert len(children) == 2
    deadline = time.monotonic() + DEADLINE_S
    while (alive := [pid for pid in children if _runs(pid)]) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not alive


@pytest.mark.parametrize('first', ['signal.signal(signal.SIGTERM, lambda *_: print("ended"))',
                                   'signal.signal(signal.SIGCHLD, signal.SIG_IGN)'])
@pytest.mark.parametrize('last', ['', 'print(sum(1 for _ in iterator) > 0)'])
def test_a_program_ends_whatever_it_does_at_signals(write_bag, first, last):
    done = script(write_bag(chunk_bytes=5000), first, last)
    assert (done.returncode, done.stderr) == (0, '')
    assert done.stdout.splitlines()[1:] == (['True'] if last else [])


def _runs(pid: str) -> bool:
    try:
        state = Path('/proc', pid, 'stat').read_text().rpartition(')')[2].split()[0]
    except OSError:
        return False
    return state not in 'ZX'
