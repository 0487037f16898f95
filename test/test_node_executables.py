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

"""A Ctrl-C while a node is still loading ends it without a word."""

from __future__ import annotations

import gc
import signal
import subprocess
import sys
import time

from deadlines import DEADLINE_S
import pytest

from heading_intercompare import node_executables as executables

pytestmark = pytest.mark.process


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize('delay_s', [0.0, 0.1, 0.3])
def test_a_node_that_is_interrupted_while_it_loads_ends_without_a_word(number, delay_s):
    code = ('import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)\n'
            'from heading_intercompare.node_executables import compliance\n'
            'class Loading:\n'
            '    def find_spec(self, name, *_):\n'
            "        if name == 'heading_intercompare.nodes.compliance':\n"
            "            print('loading', flush=True)\n"
            'sys.meta_path.insert(0, Loading())\n'
            'sys.exit(compliance())\n')
    process = subprocess.Popen([sys.executable, '-c', code], stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == 'loading\n'
        time.sleep(delay_s)
        process.send_signal(number)
        said, errors = process.communicate(timeout=DEADLINE_S)
    finally:
        process.kill()
        process.wait()
    # A fast computer may have loaded it: then it says that the norms are missing.
    assert (process.returncode, errors) == (0, '') or 'norms.' in errors
    assert 'Traceback' not in errors and said == ''


def test_each_executable_loads_its_own_node(monkeypatch):
    loaded = []

    class Module:
        @staticmethod
        def main() -> int:
            return len(loaded)

    def load(name):
        assert not gc.isenabled()
        loaded.append(name)
        return Module

    monkeypatch.setattr(executables, 'import_module', load)
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        for at, name in enumerate(executables.__all__, 1):
            assert getattr(executables, name)() == at
    finally:
        gc.unfreeze()
        for number, handler in before.items():
            signal.signal(number, handler)
    assert loaded == [f'heading_intercompare.nodes.{name}' for name in executables.__all__]
    assert gc.isenabled()


WITHOUT = """
import signal, sys
class Missing:
    def find_spec(self, name, *_):
        if name.partition('.')[0] in ('mcap', 'lz4', 'zstandard'):
            raise ModuleNotFoundError(f'No module named {name!r}', name=name)
sys.meta_path.insert(0, Missing())
from heading_intercompare import node_executables as executables
code = getattr(executables, sys.argv.pop(1))()
sys.exit(code)
"""


@pytest.mark.parametrize('name', ['recorder', 'replayer'])
def test_without_mcap_a_node_for_bags_says_what_to_install(name):
    done = subprocess.run([sys.executable, '-c', WITHOUT, name], capture_output=True, text=True)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert done.stderr.startswith(f'{name}: error: bags need the module ')
    assert 'pip install mcap lz4 zstandard' in done.stderr


@pytest.mark.parametrize('name', sorted({*executables.__all__} - {'recorder', 'replayer'}))
def test_the_live_graph_needs_no_mcap(name):
    """Each node gets as far as to its own settings."""
    done = subprocess.run([sys.executable, '-c', WITHOUT, name, '--ros-args', '-p', 'nonsense:=1'],
                          capture_output=True, text=True)
    assert done.returncode == 2 and 'nonsense' in done.stderr, done.stderr
    assert 'pip' not in done.stderr
