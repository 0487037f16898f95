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

"""Without any optional library, each command works or says what to install."""

from __future__ import annotations

import json
import os
import subprocess
import sys

from checksums import with_checksum
from command_line import NORMS
import pytest

from heading_intercompare.cli.program import COMMANDS

pytestmark = pytest.mark.process

#: The modules that the extras install, and some of their dependencies.
EXTRAS = ('jinja2', 'markupsafe', 'matplotlib', 'rich', 'argcomplete', 'serial', 'isal', 'numba',
          'distributed', 'dask', 'threadpoolctl', 'pandas', 'weasyprint', 'segno', 'ephem')
ROS = ('rclpy', 'sensor_msgs', 'std_msgs', 'geometry_msgs', 'nav_msgs', 'std_srvs',
       'diagnostic_msgs', 'rosgraph_msgs', 'rcl_interfaces', 'builtin_interfaces')

#: A program that hides them, as if they were not installed.
PROGRAM = f"""
import sys
from importlib.machinery import PathFinder

class Without(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        absent = name.partition('.')[0] in sys.argv[1].split(',')
        return None if absent else PathFinder.find_spec(name, path, target)

sys.meta_path[:] = [Without if finder is PathFinder else finder for finder in sys.meta_path]
sys.path[:0] = {sys.path!r}
from heading_intercompare.cli import main
sys.exit(main(sys.argv[2:]))
"""

RUNS_NODES = {'demo', 'live', 'record', 'note', 'replay'}


@pytest.fixture(scope='module')
def place(tmp_path_factory):
    """Return a folder with a bag, a csv of pairs, its verdict, a parameter file and logs."""
    folder = tmp_path_factory.mktemp('place')
    rows = [f'{1_400_000_000 + i},{100.0 + 0.1 * (i % 3)},100.0' for i in range(400)]
    (folder / 'pairs.csv').write_text('\n'.join(['stamp_s,ts_deg,rs_deg', *rows]) + '\n')
    for role in ('ts', 'rs'):
        (folder / f'{role}.log').write_text(''.join(
            f'2014-08-01T00:00:{i:02d}.000Z {with_checksum(text)}\r\n'
            for i, text in enumerate(f'HEHDT,100.{i},T' for i in range(8))))
    (folder / 'seen.csv').write_text('time,true_heading_deg,ts_heading_deg\n' + ''.join(
        f'2026-03-10 10:0{i}:00,100.{i},100.0\n' for i in range(3)))
    (folder / 'scenario.yaml').write_text('duration_s: 20.0\n')
    (folder / 'live.yaml').write_text(
        '/**: {ros__parameters: {norms: {sigma_max_deg: 0.2, sigma_ref_max_deg: 0.1}}}\n'
        'ts_driver: {ros__parameters: {source: "serial:/dev/null"}}\n'
        'rs_driver: {ros__parameters: {source: "serial:/dev/null"}}\n')
    subprocess.run(['ssh-keygen', '-q', '-t', 'ed25519', '-N', '', '-f', folder / 'key'],
                   check=True)
    (folder / 'signers').write_text(f'mate {(folder / "key.pub").read_text()}')
    assert done(folder, 'simulate', '--scenario', 'scenario.yaml', '-o', 'bag').returncode == 0
    assert done(folder, 'analyze', 'pairs.csv', *NORMS, '--json', 'v.json', '--logbook',
                'l.sqlite').returncode == 0
    (folder / 'signed.json').write_bytes((folder / 'v.json').read_bytes())
    assert done(folder, 'sign', 'signed.json', '--key', 'key').returncode == 0
    return folder


def done(folder, *arguments, absent=(*EXTRAS, *ROS)):
    """Run a command without some modules."""
    environment = {name: value for name, value in os.environ.items()
                   if name not in ('PYTHONPATH', 'CI')}
    return subprocess.run([sys.executable, '-c', PROGRAM, ','.join(absent), *arguments],
                          cwd=folder, text=True, timeout=300, env=environment,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)


WORKS = {
    'analyze': (('pairs.csv', *NORMS, '--report', 'again.json'), 'VERDICT: '),
    'observe': (('seen.csv', '--common-u-deg', '0.1'), 'VERDICT: INDETERMINATE: no norm'),
    'rejudge': (('bag', *NORMS), 'of 1: '),
    'history': (('l.sqlite',), 'no charts yet: '),
    'import': (('--ts', 'ts.log', '--rs', 'rs.log', '-o', 'imported'), 'bag: imported'),
    'simulate': (('--scenario', 'scenario.yaml', '-o', 'simulated'), 'bag: simulated'),
    'report': (('v.json', '-o', 'same.json'), 'VERDICT: '),
    'plan': ((*NORMS, '--set', 'risk.slowest_error_s=9', '--trials', '2'), 'a run must last '),
    'norms': ((), 'imo_msc116: '),
    'sign': (('v.json', '--key', 'key'), 'signature: v.json.sig'),
    'verify': (('signed.json', '--signers', 'signers'), 'signed.json: signed by mate '),
    'info': (('bag', '--check'), 'every checksum is correct'),
    'recover': (('bag', '-o', 'recovered'), 'lost: nothing'),
}
REFUSED = {
    'analyze': [(('pairs.csv', *NORMS, '--report', 'x.html'), 'x.html: the protocol needs Jinja2'),
                (('pairs.csv', *NORMS, '--dask', 'tcp://127.0.0.1:1'),
                 'install heading_intercompare[dask]')],
    'report': [(('pairs.csv', *NORMS, '-o', 'x.html'), 'x.html: the protocol needs Jinja2'),
               (('v.json', '-o', 'x.html'), 'x.html: the protocol needs Jinja2'),
               (('v.json', '-o', 'x.pdf'), 'x.pdf: the protocol needs Jinja2')],
    'observe': [(('seen.csv', '--sun', '--position', '54 10', '--common-u-deg', '0.1'),
                 'install heading_intercompare[sun]')],
    'history': [(('l.sqlite', '--html', 'x.html'), 'x.html: the protocol needs Jinja2')],
    'info': [(('bag', '--plot', 'x.png'), 'x.png: a picture needs matplotlib')],
    'demo': [((), 'needs ROS 2 (no module ')],
    'live': [(('--config', 'live.yaml', '--quiet'), 'needs ROS 2 (no module ')],
    'record': [(('-o', 'b'), 'needs ROS 2 (no module ')],
    'note': [(('turn',), 'needs ROS 2 (no module ')],
    'replay': [(('bag',), 'needs ROS 2 (no module ')],
}


def test_every_command_is_tried():
    assert {*WORKS} == {*COMMANDS, 'report'} - RUNS_NODES
    assert RUNS_NODES <= {*REFUSED}


@pytest.mark.parametrize('command', WORKS)
def test_a_command_works_without_extras_as_plain_text(command, place):
    arguments, words = WORKS[command]
    ended = done(place, command, *arguments)
    assert (ended.returncode, ended.stderr.count('Traceback')) == (0, 0), ended.stderr
    assert words in ended.stdout and '\x1b' not in ended.stdout + ended.stderr


@pytest.mark.parametrize('command, arguments, words', [
    (command, *case) for command, cases in REFUSED.items() for case in cases])
def test_a_command_that_needs_an_extra_says_which_in_one_line(command, arguments, words, place):
    ended = done(place, command, *arguments)
    assert ended.returncode == 2
    assert ended.stdout == '' and ended.stderr.count('\n') == 1
    assert words in ended.stderr
    assert not (place / 'x.html').exists()


def test_a_pdf_is_refused_with_what_to_install_if_only_its_library_is_missing(place):
    ended = done(place, 'report', 'nowhere.csv', *NORMS, '-o', 'x.pdf', absent=('weasyprint',))
    assert ended.returncode == 2 and ended.stdout == '' and ended.stderr.count('\n') == 1
    for words in ("pip install 'heading_intercompare[pdf]'", 'libpango-1.0-0 libpangoft2-1.0-0',
                  'x.html needs neither'):
        assert words in ended.stderr


def test_the_protocol_is_refused_before_any_work_with_what_to_do(place):
    """The input is not even looked at."""
    said = done(place, 'analyze', 'nowhere.csv', *NORMS, '--report', 'folder.d/x.html').stderr
    assert said == (
        'heading-intercompare: error: folder.d/x.html: the protocol needs Jinja2 and matplotlib: '
        "pip install 'heading_intercompare[report]' (or apt: python3-jinja2 python3-matplotlib); "
        "folder.d/x.json needs neither [No module named 'jinja2']\n")


def test_a_serial_line_says_what_it_needs(place):
    pytest.importorskip('rclpy')
    ended = done(place, 'live', '--config', 'live.yaml', '--quiet', '-o', 'live', absent=EXTRAS)
    assert ended.returncode == 2 and ended.stdout == ''
    assert ended.stderr.splitlines()[-1] == (
        'heading-intercompare: error: serial:/dev/null needs pyserial: install python3-serial or '
        'pip install pyserial')
    assert 'Traceback' not in ended.stderr


def test_the_verdict_is_the_same_with_and_without_extras(place):
    ours = done(place, 'analyze', 'pairs.csv', *NORMS, '--json', '-').stdout
    theirs = subprocess.run([sys.executable, '-m', 'heading_intercompare', 'analyze', 'pairs.csv',
                             *NORMS, '--json', '-'], cwd=place, text=True, check=True,
                            stdout=subprocess.PIPE, timeout=300, env={
                                **os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)}).stdout
    assert json.loads(ours) == json.loads(theirs)
