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

"""A signal ends the program, whatever happens to the exception by which it leaves."""

from __future__ import annotations

import signal
import subprocess
import sys

from deadlines import DEADLINE_S
import pytest

BEGIN = ('import os, signal, sys, time\n'
         'from heading_intercompare.cli.program import ended_by_signals\n')


def run_until_the_signal(number, body):
    """Run a body within the program's handling of signals; return exit code and output."""
    lines = ''.join(f'    {line}\n' for line in body.splitlines())
    done = subprocess.run([sys.executable, '-c', f'{BEGIN}with ended_by_signals():\n{lines}',
                           str(int(number))], capture_output=True, text=True, timeout=DEADLINE_S)
    assert 'Traceback' not in done.stderr
    return done.returncode, done.stdout


@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize('swallow', [
    'try:\n    os.kill(os.getpid(), int(sys.argv[1]))\n    time.sleep(60)\n'
    'except SystemExit:\n    pass',
    'class Deaf:\n    def __getattr__(self, name):\n'
    '        os.kill(os.getpid(), int(sys.argv[1]))\n        time.sleep(60)\n'
    'try:\n    Deaf().name\nexcept BaseException:\n    pass'])
def test_a_dropped_exception_is_raised_once_more(number, swallow):
    """As by the loading of numpy.random, whose C code clears it."""
    code, shown = run_until_the_signal(number, f'{swallow}\ntime.sleep(60)\nprint("went on")')
    assert (code, shown) == (128 + number, '')


def test_a_clean_up_that_takes_long_is_not_interrupted():
    code, shown = run_until_the_signal(signal.SIGTERM, (
        'try:\n    os.kill(os.getpid(), int(sys.argv[1]))\n    time.sleep(60)\nfinally:\n'
        '    for k in range(30): time.sleep(0.05)\n    print("cleaned up")'))
    assert (code, shown) == (143, 'cleaned up\n')


def test_a_clean_up_that_fails_on_its_way_is_not_interrupted():
    code, shown = run_until_the_signal(signal.SIGTERM, (
        'try:\n    os.kill(os.getpid(), int(sys.argv[1]))\n    time.sleep(60)\nfinally:\n'
        '    try:\n        raise OSError\n    except OSError:\n        time.sleep(1.5)\n'
        '    print("cleaned up")'))
    assert (code, shown) == (143, 'cleaned up\n')
