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

"""The exit code does not depend on whether the output can be written."""

from __future__ import annotations

from contextlib import suppress
from io import TextIOWrapper
import json
import os
from pathlib import Path
import subprocess
import sys

from command_line import NORMS
import numpy as np
import pytest

from heading_intercompare.cli import main

FULL = pytest.mark.skipif(not Path('/dev/full').exists(), reason='no /dev/full')


@pytest.fixture
def pairs(tmp_path):
    """Return a csv of two seconds: too little to judge."""
    path = tmp_path / 'pairs.csv'
    rows = [f'{10**18 + i * 10**8},{x},0.0' for i, x in enumerate(0.1 * np.sin(np.arange(20.0)))]
    path.write_text('\n'.join(['stamp_ns,ts_deg,rs_deg', *rows, '']))
    return str(path)


@pytest.fixture(params=[-1, 0], ids=['buffered', 'unbuffered'])
def unread(request):
    """Return a stream whose reader is gone."""
    reading, writing = os.pipe()
    os.close(reading)
    stream = TextIOWrapper(os.fdopen(writing, 'wb', request.param), write_through=True)
    yield stream
    ended(stream)


@pytest.fixture
def full():
    """Return a stream to a disk that is full."""
    stream = open('/dev/full', 'w')
    yield stream
    ended(stream)


def ended(stream):
    """Close a stream, as the end of a process does."""
    with suppress(OSError):
        stream.close()


@pytest.mark.parametrize('form', [[], ['--json', '-']])
def test_check_has_its_exit_code_though_nobody_reads_the_verdict(
        form, pairs, unread, monkeypatch, capfd):
    monkeypatch.setattr(sys, 'stdout', unread)
    assert main(['analyze', pairs, *NORMS, '--check', *form]) == 3
    assert capfd.readouterr().err == ''
    unread.flush()


@pytest.mark.parametrize('closed', ['stdout', 'stderr'])
def test_check_has_its_exit_code_where_a_stream_is_closed(closed, pairs, monkeypatch, capfd):
    monkeypatch.setattr(sys, closed, None)
    assert main(['analyze', pairs, *NORMS, '--check', '--json', '-']) == 3


@FULL
@pytest.mark.parametrize('arguments', [['norms'], ['--help'], ['norms', '--help']])
def test_what_cannot_be_written_is_said_in_one_line(arguments, full, monkeypatch, capsys):
    monkeypatch.setattr(sys, 'stdout', full)
    assert main(arguments) == 2
    assert capsys.readouterr().err == ('heading-intercompare: error: standard output: '
                                       'No space left on device\n')
    full.flush()


@FULL
def test_a_mistake_that_cannot_be_told_is_one_all_the_same(full, monkeypatch):
    full.reconfigure(line_buffering=True)
    monkeypatch.setattr(sys, 'stderr', full)
    assert main(['analyze', 'nowhere.mcap', *NORMS]) == 2


def test_a_name_that_is_no_text_is_written_as_it_is_escaped(pairs, tmp_path, capfd):
    name = os.fsdecode(bytes(tmp_path) + b'/caf\xe9.csv')
    os.link(pairs, name)
    files = [str(tmp_path / 'verdict.json'), str(tmp_path / 'report.html')]
    assert main(['analyze', name, *NORMS, '--json', files[0], '--report', files[1]]) == 0
    assert main(['analyze', name, *NORMS, '--json', '-']) == 0
    out = capfd.readouterr().out
    for text in (out[out.index('{'):], Path(files[0]).read_text('utf-8')):
        assert json.loads(text)['inputs'][0]['path'] == name
    assert main(['analyze', name + 'x', *NORMS]) == 2
    assert capfd.readouterr().err.endswith('caf\\udce9.csvx: No such file or directory\n')


@pytest.mark.process
def test_a_fault_of_the_program_does_not_end_with_the_code_of_a_verdict():
    code = ('from heading_intercompare.cli import main; '
            'from heading_intercompare.cli.commands import norms; '
            'norms.run = lambda arguments: {}["fault"]; main()')
    done = subprocess.run([sys.executable, '-c', code, 'norms'], capture_output=True, text=True,
                          check=False, timeout=120,
                          env={**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)})
    assert done.returncode == 70 and done.stdout == ''
    assert done.stderr.startswith('Traceback') and "KeyError: 'fault'" in done.stderr
