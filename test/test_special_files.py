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

"""A pipe, a device or a socket in place of a file is named, and nobody waits for it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import os
import socket
import time

import pytest

from heading_intercompare import special_files
from heading_intercompare.cli.program import main
from heading_intercompare.special_files import read_once, refuse_special

NORMS = ('--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1')


@pytest.fixture(autouse=True)
def specials(tmp_path, monkeypatch):
    """Make pipes of several names, a socket and a bag with a pipe in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(special_files, '_WRITER_S', 0.05)
    for name in ('p.log', 'p.csv', 'p.mcap', 'p.json'):
        os.mkfifo(name)
    os.mkdir('bag')
    os.mkfifo('bag/bag_0.mcap')
    with socket.socket(socket.AF_UNIX) as endpoint:
        endpoint.bind('sock.log')
        (tmp_path / 'pairs.csv').write_text('stamp_ns,ts_deg,rs_deg\n1000000000000000000,1,2\n')
        yield


@pytest.mark.parametrize('path, kind', [
    ('p.log', 'a pipe'), ('sock.log', 'a socket'), ('/dev/zero', 'a device'),
    ('/dev/null', 'a device')])
def test_what_cannot_be_read_as_a_file_is_named(path, kind):
    with pytest.raises(OSError, match=f'is {kind}, not a file') as caught:
        refuse_special(path)
    assert caught.value.filename == path


@pytest.mark.parametrize('path', ['pairs.csv', 'bag', 'absent'])
def test_a_file_a_folder_and_what_is_not_there_are_left_to_the_readers(path):
    refuse_special(path)


@pytest.mark.parametrize('arguments', [
    ('info', 'p.log'), ('info', 'p.csv'), ('info', '--check', 'p.mcap'), ('info', '/dev/zero'),
    ('info', 'sock.log'), ('analyze', 'p.log', *NORMS), ('analyze', 'p.csv', *NORMS),
    ('analyze', 'p.mcap', *NORMS), ('analyze', '/dev/zero', *NORMS), ('analyze', 'p.json'),
    ('analyze', 'pairs.csv', '--runs', 'p.csv', *NORMS), ('analyze', 'pairs.csv', '--config',
                                                          'p.log'),
    ('import', 'p.log', '-o', 'new'), ('import', 'p.csv', '-o', 'new'),
    ('recover', 'p.mcap', '-o', 'new'), ('recover', '/dev/null', '-o', 'new'),
    ('rejudge', 'p.log'), ('rejudge', 'p.json'), ('verify', 'pairs.csv', '--signers', 'p.log'),
    ('observe', 'pairs.csv', 'p.csv', *NORMS), ('simulate', '--scenario', 'p.log', '-o', 'new')])
def test_a_command_names_what_is_no_file_in_one_line(arguments, capsys):
    assert main([*arguments, '--quiet']) == 2
    error = capsys.readouterr().err
    assert error.count('\n') == 1
    assert any(words in error for words in (
        'not a file: write what comes out of it to a file', 'a pipe into which nobody writes'))


def test_a_bag_whose_file_is_a_pipe_has_no_file(capsys):
    assert main(['info', 'bag']) == 2
    assert 'holds no .mcap file' in capsys.readouterr().err


def test_a_pipe_that_is_read_once_waits_for_a_slow_writer():
    def write() -> None:
        with open('p.csv', 'wb') as file:
            time.sleep(0.3)
            file.write(b'late')
    with ThreadPoolExecutor(1) as beside:
        written = beside.submit(write)
        special_files._WRITER_S = 5.0
        assert read_once('p.csv') == b'late'
        written.result(30.0)
