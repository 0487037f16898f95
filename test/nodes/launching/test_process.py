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

"""A node as a process: exit codes, one line for a mistake, a clean end on signals."""

from __future__ import annotations

from functools import partial
import json
import os
import signal
import subprocess
import sys
import time

from deadlines import DEADLINE_S
from nodes.rclpy_objects import heading_messages
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS
import numpy as np
import pytest
from sensor_msgs.msg import Imu

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.verdict.verdict_document import SCHEMA
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.launching import process
from heading_intercompare.nodes.launching.process import error_words, run, Stop
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.recorder import Recorder
from heading_intercompare.nodes.sensor_simulator import SensorSimulator
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.spinning.executors import EXECUTOR
from heading_intercompare.nodes.synchronizer import Synchronizer

pytestmark = pytest.mark.process

T0_NS = 1_700_000_000_000_000_000


def signalled(make, *numbers, **values):
    """Return a maker whose node sends signals to its own process once it spins."""
    def made(context):
        node = make(context=context, parameter_overrides=make_overrides({**NORMS, **values}))
        waiting = list(numbers)
        every(node, 0.05, lambda: waiting and os.kill(os.getpid(), waiting.pop(0)))
        return node
    return made


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize('make', [Synchronizer, Compliance, Recorder])
def test_a_signal_ends_a_node_with_exit_code_0(make, number, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    before = signal.getsignal(number)
    assert run('node', signalled(make, number), args=[]) == 0
    assert signal.getsignal(number) is before
    assert 'Traceback' not in capfd.readouterr().err


@EITHER_EXECUTOR
def test_the_verdict_is_written_after_a_signal(tmp_path):
    assert run('compliance', signalled(Compliance, signal.SIGTERM, report_dir=str(tmp_path)),
               args=[]) == 0
    written, = tmp_path.iterdir()
    assert json.loads(written.read_text('utf-8'))['schema'] == SCHEMA


@EITHER_EXECUTOR
def test_further_signals_do_not_disturb_the_end(tmp_path):
    """Ctrl-C in a terminal reaches a launched node twice."""
    bag = tmp_path / 'bag'
    make = signalled(Recorder, signal.SIGINT, signal.SIGINT, signal.SIGTERM, output=str(bag))
    assert run('recorder', make, args=[]) == 0
    assert BagReader(bag).incomplete is None


@pytest.mark.parametrize('make, values, line', [
    (Compliance, {'norms.sigma_max_deg': None},
     'node: error: norms.sigma_max_deg is '),
    (Compliance, {'norms.sigma_max': 1.0},
     "node: error: unknown parameter 'norms.sigma_max'; did you mean 'norms.sigma_max_deg'?"),
    (NmeaDriver, {}, 'node: error: source is required: must be file:PATH'),
    (NmeaDriver, {'source': 'file:no/such.log'}, 'node: error: no/such.log: No such file'),
    (Synchronizer, {'ts_topic': 'two words'}, "node: error: topic 'two words': topic name must"),
    (SensorSimulator, {'rs_topic': '1st'}, "node: error: topic '1st': topic name token must"),
    (NmeaDriver, {'source': 'udp://127.0.0.1:10110', 'topic': ''}, "node: error: topic '': "),
])
def test_a_mistake_is_one_line_and_exit_code_2(make, values, line, capfd):
    make = partial(make, parameter_overrides=make_overrides({**NORMS, **values}))
    assert run('node', make, args=[]) == 2
    said = capfd.readouterr().err.strip().splitlines()
    assert said[-1].startswith(line)
    assert not any('Traceback' in text for text in said)


def test_an_executor_that_is_unknown_is_one_line_and_exit_code_2(monkeypatch, capfd):
    monkeypatch.setenv(EXECUTOR, 'fast')
    assert run('synchronizer', Synchronizer, args=[]) == 2
    assert capfd.readouterr().err == (
        f"synchronizer: error: {EXECUTOR} = 'fast': must be quick or rclpy\n")


@pytest.mark.parametrize('args, word', [
    (['--ros-args', '--params-file', 'no/such.yaml'], 'no/such.yaml'),
    (['--ros-args', '-p', 'window_s'], 'window_s'),
    (['--ros-args', '--no-such-option'], '--no-such-option'),
])
def test_wrong_arguments_of_ros_are_one_line_and_exit_code_2(args, word, capfd):
    assert run('synchronizer', Synchronizer, args) == 2
    said = capfd.readouterr().err.strip().splitlines()
    assert said[-1].startswith('synchronizer: error: ') and word in said[-1]


def test_a_name_that_ros_refuses_is_named():
    error = OSError(2, 'No such file or directory', 'a.log')
    assert error_words(error) == 'a.log: No such file or directory'
    assert error_words(ValueError('two\n  lines')) == 'two lines'


def test_stop_restores_the_handlers_that_were_there():
    before = signal.getsignal(signal.SIGTERM)
    with Stop() as stop:
        os.kill(os.getpid(), signal.SIGTERM)
        assert stop.requested
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_terminal_that_is_closed_is_ignored_where_it_was_before():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with Stop() as stop:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not stop.requested
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_recorder_whose_terminal_is_closed_closes_its_bag(tmp_path):
    """Nothing can then be written to the terminal."""
    bag, (mine, its) = tmp_path / 'bag', os.openpty()
    with subprocess.Popen([sys.executable, '-m', 'heading_intercompare', 'record', '-o', str(bag)],
                          stdin=its, stdout=its, stderr=its, start_new_session=True) as process:
        os.close(its)
        try:
            deadline_s = time.monotonic() + DEADLINE_S
            while not (bag / 'metadata.yaml').exists():
                assert time.monotonic() < deadline_s and process.poll() is None
                time.sleep(0.02)
            os.close(mine)
            process.send_signal(signal.SIGHUP)
            assert process.wait(timeout=DEADLINE_S) == 0
        finally:
            process.kill()
    assert BagReader(bag).incomplete is None


@pytest.mark.parametrize('name', ['nmea_driver', 'sensor_simulator', 'synchronizer', 'compliance',
                                  'recorder', 'replayer', 'motion_driver', 'alert_sender'])
def test_every_executable_of_the_package_is_a_node_that_refuses_what_it_does_not_know(name):
    code = f'from heading_intercompare.nodes.{name} import main; raise SystemExit(main())'
    done = subprocess.run([sys.executable, '-c', code, '--ros-args', '-p', 'zzz:=1'],
                          capture_output=True, text=True, timeout=DEADLINE_S)
    assert done.returncode == 2
    assert done.stderr.strip() == f"{name}: error: unknown parameter 'zzz'"


HANGS = """
import ctypes, signal, sys
from functools import partial
from heading_intercompare.nodes.launching import process
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.synchronizer import Synchronizer
process._HUNG_S = 0.5
class Hung(Synchronizer):
    def destroy_node(self):
        # It holds the interpreter lock, as the middleware does.
        ctypes.PyDLL(None).sleep(600)
def made(context):
    node = Hung(context=context)
    every(node, 0.05, partial(signal.raise_signal, signal.SIGTERM))
    return node
process.run('hung', made, [], more=sys.argv[1] == 'more')
"""


@pytest.mark.parametrize('more, code', [('nothing', 0), ('more', 1)])
def test_a_process_whose_middleware_hangs_at_the_end_ends_all_the_same(more, code):
    """A driver that had published all ended with 1, and a launch file said that it had died."""
    done = subprocess.run([sys.executable, '-c', HANGS, more], capture_output=True, text=True,
                          timeout=DEADLINE_S)
    assert (done.returncode, done.stdout, done.stderr) == (code, '', '')


WAITS = """
import os, signal, sys
from heading_intercompare import node_executables
from heading_intercompare.nodes import compliance
class Waiting(compliance.Compliance):
    def _beat(self):
        super()._beat()
        print('scipy' in sys.modules)
        os.kill(os.getpid(), signal.SIGTERM)
compliance.Compliance = Waiting
sys.exit(node_executables.compliance())
"""


def test_a_node_that_judges_waits_for_its_first_pairs_without_scipy():
    settings = [word for name, value in NORMS.items() for word in ('-p', f'{name}:={value}')]
    done = subprocess.run([sys.executable, '-c', WAITS, '--ros-args', *settings],
                          capture_output=True, text=True, timeout=DEADLINE_S)
    assert done.returncode == 0, done.stderr
    assert {*done.stdout.split()} == {'False'}


def test_pairs_that_find_no_room_are_named_at_the_end(ros, monkeypatch, capfd):
    """They are missing in the bag, and the synchronizer is the one that knows why."""
    monkeypatch.setattr(process, '_END_S', 0.5)
    node = ros.ours(Synchronizer, end_wait_s=0.0)
    outlet, = node._outlets.values()
    monkeypatch.setattr(outlet._waiting._flow, 'has_room', lambda: False)
    outlet.add(Pairs.of([1, 2, 3], [0.1, 0.2, 0.3], [0.0, 0.0, 0.0]))
    process.end(ros.executor, [node], destroy=lambda _: None)
    assert not node.ended
    assert ('ends after 0.5 s all the same, although 3 pairs are not published'
            in capfd.readouterr().err)


def test_a_synchronizer_that_cannot_end_in_time_leaves_no_reading_without_its_fate(
        ros, monkeypatch, rng):
    """Its computer is busy, and headings still come: what came is paired and judged."""
    monkeypatch.setattr(process, '_END_S', 0.5)
    judge = ros.ours(partial(Compliance, True), **NORMS)
    node = ros.ours(partial(Synchronizer, judge), **NORMS, subscribers=0)
    publisher = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)
    stamps = T0_NS + np.arange(20) * 100_000_000
    for message in heading_messages(Headings.of(stamps, rng.uniform(0.0, 360.0, 20)), 'x'):
        publisher.publish(message)
    ros.spin_until(lambda: node._headings.intakes['ts'].received == 20)
    process.end(ros.executor, [node, judge], destroy=lambda _: None)
    assert not node.ended and judge.ended
    ledger = judge.comparison.pairs['ts', 'rs'].maker.pairer.ledger
    assert ledger.total.counts['ts_unpaired'] == 20
