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

"""Recording through a full disk, a removed folder, a kill: losses are counted, the rest kept."""

from __future__ import annotations

from collections import Counter
import errno
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import threading
import time

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.bags.mcap.chunk_writer import ChunkWriter
from heading_intercompare.bags.recording import bag_writer, disk_sync
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.recording.resilient_recording import Recording
from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.messages.cdr import decode, encode

STRING = 'std_msgs/msg/String'
MB = 1_000_000


class Disk:
    """What the recorder sees of a disk: room in MB, and whether writing works at all."""

    def __init__(self, monkeypatch) -> None:
        self.free_mb = 1000.0
        self.full = self.closed_folder = False
        append, opened = ChunkWriter._append, BagWriter._open_file
        replaced = disk_sync.replace_file

        def write(writer, data):
            if self.full:
                raise OSError(errno.ENOSPC, 'No space left on device')
            append(writer, data)

        def open_file(writer, number):
            if self.closed_folder:
                raise PermissionError(errno.EACCES, 'Permission denied', str(writer.path))
            return opened(writer, number)

        def replace(target, text):
            if self.closed_folder:
                raise PermissionError(errno.EACCES, 'Permission denied', str(target.parent))
            replaced(target, text)
        monkeypatch.setattr(ChunkWriter, '_append', write)
        monkeypatch.setattr(BagWriter, '_open_file', open_file)
        for module in (disk_sync, bag_writer):
            monkeypatch.setattr(module, 'replace_file', replace)

    def free(self, path) -> int:
        os.stat(path)
        return int(self.free_mb * MB)


@pytest.fixture
def disk(monkeypatch):
    """Return a disk that can fill up."""
    return Disk(monkeypatch)


class Trial:
    """A recording of numbered messages, ten per second, on its own clock."""

    def __init__(self, path: Path, disk: Disk, **settings) -> None:
        self.bag = Recording(path, BagSettings(chunk_bytes=2000, **settings),
                             free_bytes=disk.free)
        self.bag.add_topic('/remark', STRING)
        self.sent = 0

    def run(self, seconds: float) -> None:
        """Record for some time."""
        for _ in range(round(seconds * 10)):
            number = self.sent
            self.bag.write('/remark', encode(STRING, {'data': f'{number:050d}'}), 10**18 + number,
                           10**18 + number, number)
            self.sent += 1
            self.bag.tick(self.sent / 10)


    def run_until(self, condition) -> None:
        """Record until a condition holds."""
        deadline_s = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < deadline_s
            self.run(0.1)


def remove(folder: Path) -> None:
    """Remove a folder, though something may be written into it meanwhile."""
    shutil.rmtree(folder.rename(folder.with_name('removed')))


def numbers(path: Path) -> list[int]:
    return [int(decode(STRING, m.data)['data']) for m in BagReader(path).messages()]


def test_without_faults_nothing_is_lost(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(30)
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(300))
    assert (trial.bag.fault, trial.bag.remark, trial.bag.faults, trial.bag.lost) == ('', '', 0, {})
    assert trial.bag.written == 300


def test_a_full_disk_is_said_at_once_and_recording_resumes_in_a_new_file(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(10)
    disk.full = True
    trial.run(0.7)
    assert 'No space left' in trial.bag.fault and trial.bag.faults == 1
    trial.run(20)
    assert numbers(tmp_path / 'bag') == list(range(len(numbers(tmp_path / 'bag'))))
    assert trial.bag.waiting > 190
    disk.full = False
    trial.run(1)
    assert trial.bag.fault == '' and trial.bag.waiting == 0
    trial.run(10)
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))
    assert sorted(p.name for p in (tmp_path / 'bag').iterdir()) == [
        'bag_0.mcap', 'bag_1.mcap', 'metadata.yaml']
    assert BagReader(tmp_path / 'bag').incomplete is None
    assert trial.bag.lost == {} and trial.bag.faults == 1
    assert trial.bag.written == trial.sent


def test_what_does_not_fit_into_memory_is_counted(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, waiting_mb=0.005)
    trial.run(5)
    disk.full = True
    trial.run(30)
    disk.full = False
    trial.run(5)
    trial.bag.close()
    kept = numbers(tmp_path / 'bag')
    assert len(kept) == len(set(kept)) and kept == sorted(kept)
    assert trial.bag.lost == {'/remark': trial.sent - len(kept)}
    assert 200 < trial.bag.lost['/remark'] < 300
    assert kept[-40:] == list(range(trial.sent - 40, trial.sent))


def test_writing_stops_before_the_disk_is_full_and_goes_on_when_there_is_room(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, free_space_mb=50.0)
    trial.run(5)
    disk.free_mb = 49.0
    trial.run(5)
    assert trial.bag.fault.startswith('less than 50 MB free on the disk of ')
    size = (tmp_path / 'bag' / 'bag_0.mcap').stat().st_size
    disk.free_mb = 51.0
    trial.run(5)
    assert trial.bag.fault
    assert (tmp_path / 'bag' / 'bag_0.mcap').stat().st_size == size
    disk.free_mb = 56.0
    trial.run(1)
    assert trial.bag.fault == ''
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))


def test_room_that_was_kept_free_takes_what_waits_at_the_end(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, free_space_mb=50.0)
    trial.run(5)
    disk.free_mb = 49.0
    trial.run(5)
    assert trial.bag.waiting > 40
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))
    assert trial.bag.lost == {} and trial.bag.written == trial.sent
    assert BagReader(tmp_path / 'bag').incomplete is None


def test_what_waits_is_counted_as_lost_before_the_bag_is_closed(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(5)
    disk.full = True
    trial.run(5)
    waiting = trial.bag.waiting
    assert waiting > 40
    trial.bag.settle()
    assert trial.bag.lost == {'/remark': waiting} and trial.bag.waiting == 0
    disk.full = False
    trial.bag.metadata('recording', {'not_written': trial.bag.lost['/remark']})
    trial.bag.close()
    reader = BagReader(tmp_path / 'bag')
    assert reader.incomplete is None
    assert reader.metadata()['recording'] == {'not_written': str(waiting)}
    assert numbers(tmp_path / 'bag') == list(range(trial.sent - waiting))


def test_a_disk_that_stays_full_loses_only_what_came_after(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(10)
    disk.full = True
    trial.run(10)
    trial.bag.close()
    kept = numbers(tmp_path / 'bag')
    assert kept == list(range(len(kept))) and len(kept) >= 90
    assert trial.bag.lost == {'/remark': trial.sent - len(kept)}
    assert 'was not closed' in BagReader(tmp_path / 'bag').incomplete
    disk.full = False
    assert recover(tmp_path / 'bag', tmp_path / 'new').messages == len(kept)


def test_a_removed_folder_is_made_again(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(10)
    remove(tmp_path / 'bag')
    trial.run(0.5)
    assert 'No such file' in trial.bag.fault and trial.bag.faults == 1
    trial.run(10)
    assert trial.bag.fault == ''
    trial.bag.close()
    kept = numbers(tmp_path / 'bag')
    assert kept == list(range(kept[0], trial.sent))
    assert trial.bag.absent == kept[0] <= 107
    rosbags = pytest.importorskip('rosbags.highlevel')
    with rosbags.AnyReader([tmp_path / 'bag']) as bag:
        assert bag.message_count == len(kept)


def test_a_removed_folder_is_noticed_however_seldom_is_written(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, flush_interval_s=3600.0)
    trial.run(1)
    remove(tmp_path / 'bag')
    trial.run(0.5)
    assert trial.bag.faults == 1 and trial.bag.waiting > 0
    trial.run(1)
    assert trial.bag.fault == ''
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))


def test_a_folder_removed_just_before_the_end_is_made_again(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(1)
    remove(tmp_path / 'bag')
    trial.bag.close()
    kept = numbers(tmp_path / 'bag')
    assert BagReader(tmp_path / 'bag').incomplete is None
    assert kept == list(range(trial.bag.absent, trial.sent))
    assert (trial.bag.fault, trial.bag.lost, trial.bag.faults) == ('', {}, 1)


def test_a_file_replaced_by_another_is_noticed(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(1)
    (tmp_path / 'bag' / 'bag_0.mcap').unlink()
    (tmp_path / 'bag' / 'bag_0.mcap').touch()
    trial.run(0.5)
    assert trial.bag.fault.endswith('bag_0.mcap: is another file now')
    trial.run(1)
    assert trial.bag.fault == '' and trial.bag.faults == 1


def test_what_is_attached_and_noted_survives_a_removed_folder(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, split_duration_s=50e-9)
    trial.bag.attachment('mine.yaml', 'application/yaml', b'mine')
    trial.bag.metadata('note.1', {'text': 'calm sea'})
    trial.run(1)
    remove(tmp_path / 'bag')
    trial.run(2)
    trial.bag.close()
    reader = BagReader(tmp_path / 'bag')
    assert [(a.name, a.data) for a in reader.attachments()] == [('mine.yaml', b'mine')]
    assert reader.metadata()['note.1'] == {'text': 'calm sea'}


def test_what_is_attached_is_in_one_file_and_in_another_if_that_is_taken_away(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, split_duration_s=50e-9)
    trial.bag.attachment('mine.yaml', 'application/yaml', b'mine')
    trial.run(20)
    (tmp_path / 'bag' / 'bag_0.mcap').unlink()
    trial.bag.attachment('report.json', 'application/json', b'{}')
    trial.bag.close()
    attached = [a.name for a in BagReader(tmp_path / 'bag').attachments()]
    assert attached == ['mine.yaml', 'report.json']


@pytest.mark.parametrize('same_file', [True, False])
def test_what_is_attached_and_noted_on_a_full_disk_is_written_later_once(
        tmp_path, disk, same_file):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(1)
    disk.full, disk.closed_folder = True, same_file
    trial.bag.metadata('note.1', {'text': 'gale'})
    trial.bag.metadata('note.2', {'text': 'storm'})
    trial.bag.attachment('mine.yaml', 'application/yaml', b'mine')
    trial.run(1)
    disk.full = False
    trial.run(1)
    assert trial.bag.fault == ''
    disk.closed_folder = False
    trial.bag.close()
    files = [BagReader(file) for file in sorted((tmp_path / 'bag').glob('*.mcap'))]
    assert len(files) == (1 if same_file else 2)
    assert [len(file.attachments()) for file in files] == ([1] if same_file else [0, 1])
    found = files[-1].metadata()
    assert (found['note.1'], found['note.2']) == ({'text': 'gale'}, {'text': 'storm'})


def test_a_moved_folder_keeps_what_it_has_and_is_closed(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(10)
    os.rename(tmp_path / 'bag', tmp_path / 'away')
    trial.run(10)
    trial.bag.close()
    before, after = numbers(tmp_path / 'away'), numbers(tmp_path / 'bag')
    assert before + after == list(range(trial.sent))
    assert BagReader(tmp_path / 'away').incomplete is None
    assert trial.bag.lost == {} and trial.bag.absent == len(before)


def test_a_folder_that_is_read_only_does_not_stop_the_file_that_is_open(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk, split_duration_s=2e-8)
    trial.run(1)
    disk.closed_folder = True
    trial.run_until(lambda: trial.bag.remark.endswith('bag: Permission denied'))
    assert trial.bag.fault == ''
    disk.closed_folder = False
    trial.run_until(lambda: trial.bag.remark == '')
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))


def test_metadata_yaml_is_written_while_recording_and_again_after_a_failure(tmp_path, disk):
    described = (tmp_path / 'bag' / 'metadata.yaml').read_text
    trial = Trial(tmp_path / 'bag', disk)
    trial.run_until(lambda: '/remark' in described())
    disk.closed_folder = True
    trial.bag.add_topic('/second', STRING)
    trial.run_until(lambda: trial.bag.remark)
    assert '/second' not in described()
    disk.closed_folder = False
    trial.run_until(lambda: '/second' in described())
    trial.run_until(lambda: trial.bag.remark == '')
    trial.bag.close()


def test_a_full_disk_in_a_read_only_folder_resumes_in_the_same_file(tmp_path, disk):
    trial = Trial(tmp_path / 'bag', disk)
    trial.run(5)
    disk.full = disk.closed_folder = True
    trial.run(5)
    assert trial.bag.fault and trial.bag.faults == 1
    disk.full = False
    trial.run(5)
    assert trial.bag.fault == ''
    disk.closed_folder = False
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))
    assert not (tmp_path / 'bag' / 'bag_1.mcap').exists()


@pytest.mark.parametrize('settings', [{'split_bytes': 3000}, {'split_duration_s': 30e-9}])
def test_a_bag_is_split_by_size_and_by_duration(tmp_path, disk, settings):
    trial = Trial(tmp_path / 'bag', disk, **settings)
    trial.bag.metadata('heading_intercompare', {'version': '1'})
    trial.run(60)
    trial.bag.close()
    files = sorted((tmp_path / 'bag').glob('*.mcap'))
    assert 5 < len(files) < 40
    assert numbers(tmp_path / 'bag') == list(range(600))
    assert BagReader(tmp_path / 'bag').incomplete is None
    for file in files:
        assert BagReader(file).metadata()['heading_intercompare'] == {'version': '1'}
        if 'split_duration_s' in settings:
            found = numbers(file)
            assert found[-1] - found[0] < 60
    yaml = pytest.importorskip('yaml')
    row = yaml.safe_load((tmp_path / 'bag' / 'metadata.yaml').read_text())
    row = row['rosbag2_bagfile_information']
    assert row['message_count'] == 600 == sum(f['message_count'] for f in row['files'])
    assert len(row['relative_file_paths']) == len(files)
    rosbags = pytest.importorskip('rosbags.highlevel')
    with rosbags.AnyReader([tmp_path / 'bag']) as bag:
        assert [stamp for _, stamp, _ in bag.messages()] == [10**18 + i for i in range(600)]


SENDER = """
import sys, time
from heading_intercompare.messages.cdr import encode
from heading_intercompare.bags.recording.resilient_recording import Recording

bag = Recording(sys.argv[1])
bag.add_topic('/remark', 'std_msgs/msg/String')
number = 0
while True:
    now_ns = time.time_ns()
    text = f'{number} ' + 'x' * 200
    bag.write('/remark', encode('std_msgs/msg/String', {'data': text}), now_ns, now_ns, number)
    number += 1
    bag.tick(time.monotonic())
    time.sleep(0.001)
"""


@pytest.mark.process
@pytest.mark.parametrize('after_s', [0.3, 1.37])
def test_killed_at_any_moment_at_most_a_second_is_lost(tmp_path, after_s):
    process = subprocess.Popen([sys.executable, '-c', SENDER, str(tmp_path / 'bag')])
    try:
        deadline_s = time.monotonic() + DEADLINE_S
        while not (tmp_path / 'bag' / 'metadata.yaml').exists():
            assert time.monotonic() < deadline_s and process.poll() is None
            os.sched_yield()
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=after_s)
        process.send_signal(signal.SIGKILL)
        killed_ns = time.time_ns()
    finally:
        process.kill()
        process.wait()
    reader = BagReader(tmp_path / 'bag')
    if reader.topics:
        found = list(reader.messages())
        assert [m.sequence for m in found] == list(range(len(found)))
        assert killed_ns - found[-1].log_time_ns < 1_000_000_000
        assert recover(tmp_path / 'bag', tmp_path / 'new').messages == len(found)
        assert Counter(m.topic for m in BagReader(tmp_path / 'new').messages()) == {
            '/remark': len(found)}
    else:
        assert after_s < 1.0


def test_a_disk_that_takes_long_to_sync_holds_up_nobody(tmp_path, disk, monkeypatch):
    """Nor do new topics, new files and faults that are over hold anybody up."""
    trial = Trial(tmp_path / 'bag', disk, split_duration_s=40e-9, fsync_interval_s=0.0)
    waited, over = [], threading.Event()
    fsync = os.fsync

    def slow(descriptor):
        assert threading.current_thread() is not threading.main_thread()
        waited.append(descriptor)
        assert over.wait(DEADLINE_S)
        fsync(descriptor)
    with monkeypatch.context() as patch:
        patch.setattr(os, 'fsync', slow)
        try:
            trial.run(2)
            trial.bag.add_topic('/second', STRING)
            trial.run(5)
            disk.full = True
            trial.run(1)
            disk.full = False
            trial.run(2)
            assert trial.bag.fault == '' and trial.bag.faults == 1
            assert numbers(tmp_path / 'bag') == list(range(len(numbers(tmp_path / 'bag'))))
            assert len(numbers(tmp_path / 'bag')) >= 95
            assert len(waited) == 1
        finally:
            over.set()
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(100))
    assert len(list((tmp_path / 'bag').glob('*.mcap'))) > 2


def test_a_sync_that_fails_is_a_fault(tmp_path, disk, monkeypatch):
    def fail(descriptor):
        raise OSError(errno.EIO, 'Input/output error')
    trial = Trial(tmp_path / 'bag', disk)
    with monkeypatch.context() as patch:
        patch.setattr(os, 'fsync', fail)
        for _ in range(1000):
            trial.run(0.1)
            if trial.bag.fault:
                break
        assert 'Input/output error' in trial.bag.fault
    trial.run(10)
    assert trial.bag.fault == ''
    trial.bag.close()
    assert numbers(tmp_path / 'bag') == list(range(trial.sent))


LIMITED = """
import random, resource, sys
from heading_intercompare.messages.cdr import encode
from heading_intercompare.bags.recording.resilient_recording import Recording
from heading_intercompare.bags.settings import BagSettings

resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
bag = Recording(sys.argv[1], BagSettings(chunk_bytes=20_000, free_space_mb=0.0))
bag.add_topic('/remark', 'std_msgs/msg/String')
source = random.Random(1)
for i in range(2000):
    text = encode('std_msgs/msg/String', {'data': source.randbytes(100).hex()})
    bag.write('/remark', text, 10**18 + i, 10**18 + i, i)
    bag.tick(i / 100)
bag.close()
print(bag.faults, bag.lost, bag.written)
"""


@pytest.mark.process
def test_files_that_the_system_refuses_to_let_grow_are_followed_by_others(tmp_path):
    done = subprocess.run([sys.executable, '-c', LIMITED, str(tmp_path / 'bag')],
                          timeout=DEADLINE_S, capture_output=True, text=True, check=True)
    faults, rest = done.stdout.split(' ', 1)
    assert int(faults) >= 2 and rest == '{} 2000\n', done.stderr
    reader = BagReader(tmp_path / 'bag')
    assert [m.sequence for m in reader.messages()] == list(range(2000))
    assert len(list((tmp_path / 'bag').glob('*.mcap'))) >= 3
    total = recover(tmp_path / 'bag', tmp_path / 'new')
    assert (total.messages, total.messages_lost, total.chunks_lost) == (2000, 0, 0)


def test_the_free_space_is_told_while_the_disk_can_be_asked(tmp_path):
    with_disk = Recording(tmp_path / 'one', free_bytes=lambda path: 7 * MB)
    assert with_disk.free_bytes == 7 * MB
    with_disk.close()

    def fail(path):
        raise OSError(errno.EIO, 'Input/output error')
    without = Recording(tmp_path / 'two', free_bytes=fail)
    assert without.free_bytes is None
    without.close()
