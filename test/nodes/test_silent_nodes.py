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

"""Processes of a graph that are stopped, killed or ended: who is missed, and for how long."""

from __future__ import annotations

import signal

from nodes.launch_files import nodes
from nodes.lines import free_port, TurningShip
from nodes.processes import Processes, wait_for
from nodes.ros_nodes import NORMS
import pytest
import yaml

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.messages.status_messages import decode_statuses

pytestmark = pytest.mark.process

SILENT = {f'compliance: {name}_silent' for name in ('ts_driver', 'rs_driver', 'recorder')}


@pytest.fixture
def processes(tmp_path):
    """Return the processes of a test."""
    started = Processes(tmp_path)
    yield started
    started.reap()


def start_graph(processes, ports):
    """Start a live graph of two drivers; return its nodes by name, and its bag."""
    config, bag = processes.folder / 'config.yaml', processes.folder / 'bag'
    config.write_text(yaml.dump({
        '/**': {'ros__parameters': NORMS}, **{
            name: {'ros__parameters': {'source': f'udp://127.0.0.1:{port}', 'sentence': 'HDT'}}
            for name, port in zip(('ts_driver', 'rs_driver'), ports)}}))
    graph = {node.label: node for node in nodes(
        'intercompare.launch.py', config=str(config), output=str(bag),
        report_dir=str(processes.folder / 'reports'))}
    for node in graph.values():
        processes.start(node)
    return graph, bag


def list_alarms(bag):
    """Return the values of each alarm in a bag that may be open, as last recorded, by name."""
    try:
        messages = [*BagReader(bag).messages(['/compliance/alarms'])]
    except (OSError, ValueError):
        return {}
    return {status.name: status.values for message in messages
            for status in decode_statuses(message.data)[1]}


def has_said(processes, name, words):
    """Tell whether a process has written these words."""
    return words in (processes.folder / f'{name}.log').read_text(errors='replace')


def stop_for_a_while(processes, name, watcher, node=''):
    """
    Stop a process until it is missed, let it go on, and wait until it is missed no more.

    The watcher misses one of its nodes, if it has several.
    """
    missed = node or name
    processes.running[name].send_signal(signal.SIGSTOP)
    wait_for(lambda: has_said(processes, watcher, f'alarm raised: {missed}_silent: {missed} has '
                              'not been heard for more than'))
    processes.running[name].send_signal(signal.SIGCONT)
    wait_for(lambda: has_said(processes, watcher,
                              f'alarm cleared, not acknowledged: {missed}_silent'))


def kill(processes, name, watcher, start, node=''):
    """Kill a process until it is missed, and start it again until it is missed no more."""
    missed = node or name
    processes.running[name].kill()
    processes.running[name].wait()
    wait_for(lambda: has_said(processes, watcher, f'alarm raised: {missed}_silent'))
    processes.start(start)
    wait_for(lambda: has_said(processes, watcher,
                              f'alarm cleared, not acknowledged: {missed}_silent'))


@pytest.fixture
def ship():
    """Return a ship that sends to two ports."""
    sender = TurningShip([free_port(), free_port()])
    sender.start()
    yield sender
    sender.stopped.set()
    sender.join()


@pytest.mark.slow
def test_each_node_that_stands_still_is_missed_until_it_goes_on(processes, ship):
    _, bag = start_graph(processes, ship.ports)
    wait_for(lambda: SILENT | {'recorder: compliance_silent'} <= list_alarms(bag).keys())
    for name in ('recorder', 'ts_driver'):
        stop_for_a_while(processes, name, 'intercompare')
    stop_for_a_while(processes, 'intercompare', 'recorder', 'compliance')
    processes.signal(signal.SIGINT)
    processes.wait(*processes.running)
    times = {name: int(values['times']) for name, values in list_alarms(bag).items()
             if values['times'] != '0'}
    assert times.pop('synchronizer: ts_silent') >= 1
    # While the synchronizer stands still, its own look finds both streams silent.
    times.pop('synchronizer: rs_silent', None)
    assert times == {'compliance: recorder_silent': 1, 'compliance: ts_driver_silent': 1,
                     'recorder: compliance_silent': 1}


@pytest.mark.slow
def test_a_node_that_was_killed_is_missed_until_it_is_started_again(processes, ship):
    graph, bag = start_graph(processes, ship.ports)
    wait_for(lambda: SILENT | {'recorder: compliance_silent'} <= list_alarms(bag).keys())
    kill(processes, 'rs_driver', 'intercompare', graph['rs_driver'])
    kill(processes, 'intercompare', 'recorder', graph['intercompare'], 'compliance')
    # The log of compliance began anew, and so did its knowledge of the others.
    wait_for(lambda: SILENT <= list_alarms(bag).keys())
    kill(processes, 'recorder', 'intercompare', graph['recorder'])


@pytest.mark.slow
def test_a_node_that_ends_in_order_is_not_missed(processes, ship):
    """A driver that is stopped afterwards is, so the time for it has passed."""
    _, bag = start_graph(processes, ship.ports)
    wait_for(lambda: SILENT <= list_alarms(bag).keys())
    for name in ('recorder', 'rs_driver'):
        processes.running[name].send_signal(signal.SIGINT)
        processes.wait(name)
    stop_for_a_while(processes, 'ts_driver', 'intercompare')
    for name in ('recorder', 'rs_driver'):
        assert not has_said(processes, 'intercompare', f'{name}_silent')
