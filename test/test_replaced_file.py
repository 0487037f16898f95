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


"""Files that take their place only when they are whole: full disks, signals, links, pipes."""

from __future__ import annotations

import errno
import os
from pathlib import Path
import resource
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import threading
import time

from command_line import NORMS
from deadlines import DEADLINE_S
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import Headings
from heading_intercompare.bags.csv.ensembles_csv import EnsemblesCsvWriter
from heading_intercompare.cli import main
from heading_intercompare.cli.commands import import_inputs
from heading_intercompare.core.records import Pairs
from heading_intercompare.replaced_file import replace_file, ReplacedFile

S = 1_000_000_000
OLDER = 'what was here before\n'


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of two sensors at 10 Hz for 10 minutes."""
    path = tmp_path_factory.mktemp('bag') / 'trial'
    rng = np.random.default_rng(5)
    stamps = 1_400_000_000 * S + np.arange(6000) * (S // 10)
    write_headings(path, {f'{name}/heading': Headings.of(stamps, 90.0 + rng.normal(0.0, 0.1, 6000))
                          for name in ('ts', 'rs')})
    return path


def run(*arguments, most_bytes=None):
    """Run the command line in a process whose files may have at most a number of bytes."""
    def limit():
        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
    return subprocess.run([sys.executable, '-m', 'heading_intercompare', *map(str, arguments)],
                          capture_output=True, text=True, preexec_fn=limit)


@pytest.mark.parametrize('option, name, most_bytes', [
    ('--json', 'verdict.json', 4096), ('--csv', 'pairs.csv', 65536),
    ('--ensembles', 'ensembles.csv', 10), ('--runs-csv', 'runs.csv', 100),
    ('-o', 'protocol.html', 65536), ('--plot', 'figure.svg', 4096),
    ('--plot', 'figure.png', 4096)])
def test_a_full_disk_leaves_the_older_file(bag, tmp_path, option, name, most_bytes):
    """A file system that takes no more is EFBIG here; ENOSPC goes the same way."""
    path = tmp_path / name
    path.write_text(OLDER)
    more = ['--ensemble-s', '10'] if option == '--ensembles' else []
    command = ['info', bag] if option == '--plot' else ['analyze', bag, *NORMS, '--quiet']
    done = run(*command, option, path, *more, most_bytes=most_bytes)
    assert done.returncode == 2, done.stderr
    assert done.stderr.splitlines()[-1] == (
        f'heading-intercompare: error: {path}: {os.strerror(errno.EFBIG)}')
    assert path.read_text() == OLDER and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize('error', [KeyboardInterrupt, SystemExit(143), ValueError,
                                   OSError(errno.ENOSPC, 'No space left on device')])
def test_whatever_ends_the_writing_leaves_the_older_file(tmp_path, error):
    path = tmp_path / 'verdict.json'
    path.write_text(OLDER)
    with pytest.raises(BaseException) as caught, ReplacedFile(path, 'w') as file:
        file.write('half')
        raise error
    assert path.read_text() == OLDER and list(tmp_path.iterdir()) == [path]
    assert not isinstance(caught.value, OSError) or caught.value.filename == str(path)


def test_a_table_whose_last_rows_do_not_fit_leaves_the_older_file(tmp_path, monkeypatch):
    """The rows that `close` appends, beyond the buffer; before, their draft stayed."""
    path = tmp_path / 'ensembles.csv'
    path.write_text(OLDER)
    table = EnsemblesCsvWriter(path, 60.0, gap_s=60.0, std_limit_deg=1.0)
    monkeypatch.setattr(table._replaced, 'file', FullFile(table._replaced.file))
    stamps = 1_400_000_000 * S + np.arange(30) * S
    table.write(Pairs.of(stamps, np.full(30, 90.0), np.full(30, 90.0)))
    with pytest.raises(OSError) as caught:
        table.close()
    assert caught.value.filename == str(path)
    assert path.read_text() == OLDER and list(tmp_path.iterdir()) == [path]


class FullFile:
    """A file on a disk that takes no more."""

    def __init__(self, file):
        self.closed, self.close = False, file.close

    def write(self, data):
        raise OSError(errno.ENOSPC, 'No space left on device')


def test_nobody_sees_half_of_a_file(tmp_path):
    path = tmp_path / 'verdict.json'
    with ReplacedFile(path, 'w') as file:
        file.write('half')
        file.flush()
        assert not path.exists()
    assert path.read_text() == 'half' and list(tmp_path.iterdir()) == [path]


def test_a_link_and_the_permissions_stay(tmp_path):
    (tmp_path / 'data').mkdir()
    target, link = tmp_path / 'data' / 'verdict.json', tmp_path / 'latest.json'
    target.write_text(OLDER)
    target.chmod(0o640)
    link.symlink_to(target)
    replace_file(link, 'newer')
    assert link.is_symlink() and target.read_text() == 'newer'
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_a_new_file_has_the_permissions_that_the_user_gives_new_files(tmp_path):
    replace_file(tmp_path / 'ours', 'x')
    (tmp_path / 'theirs').write_text('x')
    assert (tmp_path / 'ours').stat().st_mode == (tmp_path / 'theirs').stat().st_mode


def test_a_pipe_and_a_device_are_written_as_they_are(tmp_path):
    pipe = tmp_path / 'pipe'
    os.mkfifo(pipe)
    texts: list[str] = []
    reader = threading.Thread(target=lambda: texts.append(pipe.read_text()), daemon=True)
    reader.start()
    replace_file(pipe, 'through the pipe')
    reader.join(DEADLINE_S)
    assert texts == ['through the pipe'] and stat.S_ISFIFO(pipe.stat().st_mode)
    replace_file('/dev/null', 'away')
    assert stat.S_ISCHR(os.stat('/dev/null').st_mode)


@pytest.mark.parametrize('name', ['x' * 255, 'å' * 127])
def test_a_name_of_the_greatest_length_can_be_replaced(tmp_path, name):
    replace_file(tmp_path / name, 'older')
    replace_file(tmp_path / name, 'newer')
    assert (tmp_path / name).read_text() == 'newer' and len(list(tmp_path.iterdir())) == 1


def test_a_file_that_cannot_be_made_is_named_as_the_user_named_it(tmp_path):
    with pytest.raises(OSError) as caught:
        replace_file(tmp_path / 'absent' / 'verdict.json', 'x')
    assert caught.value.filename == str(tmp_path / 'absent' / 'verdict.json')


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_while_a_bag_is_written_leaves_nothing(tmp_path, number):
    """The bag is simulated; the next try is not blocked by half of it."""
    begun, trial = Path(tmp_path / 'begun'), Path(tmp_path / 'week.yaml')
    # Long enough that a signal always comes before its end.
    trial.write_text('duration_s: 604800\nlegs: 0 20 8\nts: {rate_hz: 10}\nrs: {rate_hz: 10}\n')
    process = subprocess.Popen(
        [sys.executable, '-m', 'heading_intercompare', 'simulate', '--scenario', trial,
         '-o', begun, '--quiet'], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    deadline_s = time.monotonic() + DEADLINE_S
    while not list(tmp_path.glob('begun.*.part/*.mcap')) and time.monotonic() < deadline_s:
        assert process.poll() is None
        time.sleep(0.02)
    assert not begun.exists()
    process.send_signal(number)
    _, words = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 128 + number and 'Traceback' not in words
    assert list(tmp_path.iterdir()) == [trial]


def test_ctrl_c_in_import_does_not_block_the_next_try(bag, tmp_path, monkeypatch, capsys):
    command = ['import', str(bag), '-o', str(tmp_path / 'new'), '--quiet']

    def interrupt(*_):
        raise KeyboardInterrupt
    with monkeypatch.context() as patch:
        patch.setattr(import_inputs, '_write', interrupt)
        assert main(command) == 130
    assert list(tmp_path.iterdir()) == []
    assert main(command) == 0
    assert main(command) == 2
    assert 'already exists; a bag is never overwritten' in capsys.readouterr().err


@pytest.fixture
def private_folder():
    """Return a folder outside those of root, and act as its owner, who is not root."""
    folder = Path(tempfile.mkdtemp())
    user = os.geteuid()
    try:
        if user == 0:
            os.chown(folder, 65534, -1)
            os.seteuid(65534)
        yield folder
    finally:
        os.seteuid(user)
        folder.chmod(0o700)
        shutil.rmtree(folder)


def test_a_file_in_a_folder_that_takes_no_new_file_is_written_as_it_is(private_folder):
    path = private_folder / 'verdict.json'
    path.write_text('an older verdict that is longer')
    private_folder.chmod(0o500)
    replace_file(path, 'newer')
    assert path.read_text() == 'newer'
    with pytest.raises(PermissionError) as caught:
        replace_file(private_folder / 'none.json', 'newer')
    assert caught.value.filename == str(private_folder / 'none.json')
    path.chmod(0o400)
    with pytest.raises(PermissionError):
        replace_file(path, 'newest')
    assert path.read_text() == 'newer'


def test_a_folder_that_nobody_may_list_takes_a_file(private_folder):
    private_folder.chmod(0o300)
    replace_file(private_folder / 'verdict.json', 'newer')
    assert (private_folder / 'verdict.json').read_text() == 'newer'
