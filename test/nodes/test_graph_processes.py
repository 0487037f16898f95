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

"""The graph as the launch files start it: one process per node, ended by a signal."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
import fcntl
import json
import os
import pty
import signal
import struct
import subprocess
import sys
import termios
import time

from deadlines import DEADLINE_S, Stopwatch
from nodes import launch_files
from nodes.graph_checks import assert_same, count_recorded, log, offline, settings_for_bags
from nodes.launch_files import make_environment, nodes
from nodes.lines import free_port, TurningShip
from nodes.processes import Processes, wait_for
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS
import pytest
from ros_domain import DOMAIN
import yaml

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.config import LIVE
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.motion_topics import read_bag_motion
from heading_intercompare.bags.rosbag2.quality_topics import read_quality
from heading_intercompare.cli import main
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.records import Headings
from heading_intercompare.core.sensors.sensors_verdict import (
    find_sensor_differences,
    SensorsVerdict,
)
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.drivers.logs import read_log
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.report.json import read

pytestmark = pytest.mark.process

#: What a node takes to load at most where little else is at work, seconds.
QUICK_START_S = 2.0


@pytest.fixture
def processes(tmp_path):
    """Return the processes of a test."""
    made = Processes(tmp_path)
    yield made
    made.reap()


def config_of(folder, ts, rs, speed, rule=NORMS):
    """Write a parameter file with two logs as sources."""
    path = folder / 'config.yaml'
    path.write_text(yaml.dump({
        '/**': {'ros__parameters': dict(rule)},
        'ts_driver': {'ros__parameters': {'source': ts, 'speed': speed}},
        'rs_driver': {'ros__parameters': {'source': rs, 'speed': speed}}}, sort_keys=False))
    return str(path)


def plan_trial(config, bag, reports):
    """Return the nodes of a live trial by name."""
    return {node.label: node for node in nodes('intercompare.launch.py', config=config,
                                              output=str(bag), report_dir=str(reports))}


def short_lease(path, seconds):
    """Write a profile of the middleware that gives up a silent process after some seconds."""
    profile = launch_files.LOOPBACK.read_text('utf-8')
    lease = (f'<builtin><discovery_config><leaseDuration><sec>{seconds}</sec></leaseDuration>'
             '<leaseAnnouncement><sec>1</sec></leaseAnnouncement></discovery_config></builtin>')
    assert '<rtps>' in profile
    path.write_text(profile.replace('<rtps>', f'<rtps>{lease}'), 'utf-8')
    return path


def end_trial(processes, *judging):
    """Wait for the drivers, end the other nodes with a signal; they end well."""
    processes.wait('ts_driver', 'rs_driver')
    processes.signal(signal.SIGINT)
    processes.wait(*(judging or ('intercompare',)), 'recorder')


def run_live(processes, config, order, number):
    """Run the live graph on two logs, end it with a signal; return its report and its bag."""
    folder = processes.folder
    bag, reports = folder / 'bag', folder / 'reports'
    made = plan_trial(config, bag, reports)
    for name in order:
        processes.start(made[name])
    processes.wait('ts_driver', 'rs_driver')
    processes.signal(number)
    processes.wait('intercompare', 'recorder')
    written, = reports.iterdir()
    return json.loads(written.read_text('utf-8')), bag


def kill_and_restart(processes, node, bag) -> int:
    """Kill a node, and start it again; return how many states of the verdict are in the bag."""
    name = node.file or node.label
    processes.running[name].kill()
    processes.running[name].wait()
    n_states = count_recorded(bag, '/compliance/verdict')
    processes.start(node)
    return n_states


def pace(speed: float) -> float:
    """
    Return the speed of a log that lasts until nodes have been killed, and are back.

    A node that starts takes as long as this machine lets it: the log follows.
    """
    watch_s = time.monotonic()
    subprocess.run([sys.executable, '-c', 'import heading_intercompare.nodes.compliance'],
                   check=True)
    return speed / max(1.0, (time.monotonic() - watch_s) / QUICK_START_S)


DRIVERS_LAST = ('recorder', 'intercompare', 'ts_driver', 'rs_driver')


@pytest.mark.slow
@pytest.mark.parametrize('order, number', [(DRIVERS_LAST, signal.SIGINT),
                                           (DRIVERS_LAST[::-1], signal.SIGTERM)])
def test_in_any_order_of_start_nothing_is_lost(processes, tmp_path, order, number):
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 300, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 300, 0.05, 90.1), 30.0)
    report, bag = run_live(processes, config, order, number)
    run, = report['runs']
    assert (run['pairing']['ts_received'], run['pairing']['rs_received']) == (300, 300)
    assert run['pairing']['paired'] == run['n'] == 299
    counts = {name: info.count for name, info in BagReader(bag).topics.items()}
    assert (counts['/ts/heading'], counts['/rs/heading'], counts['/pairs']) == (300, 300, 299)
    assert counts['/compliance/report'] == 1
    assert_same(report, offline(bag))


@pytest.mark.slow
@pytest.mark.endurance
def test_real_logs_at_20_times_the_speed_give_the_offline_verdict(
        processes, tmp_path, shared_data):
    """Gyro against Seapath: every sentence of both logs arrives, is paired and recorded."""
    logs = [shared_data / 'nbp1406' / f'NBP1406_{name}-2014-08-01' for name in ('gyr1', 's330')]
    config = config_of(tmp_path, *(f'file:{path}' for path in logs), 20.0)
    report, bag = run_live(processes, config, DRIVERS_LAST, signal.SIGINT)
    ts, rs = (read_log(path, DriverSettings(source=f'file:{path}'))[0] for path in logs)
    run, = report['runs']
    assert run['pairing']['ts_received'] == len(ts) == 5000
    assert run['pairing']['rs_received'] == len(rs)
    reader = BagReader(bag)
    chunks = list(reader.headings({'ts/heading': 'enu', 'rs/heading': 'enu'}))
    recorded = [Headings.concatenate(c[t] for c in chunks) for t in ('ts/heading', 'rs/heading')]
    assert [h.stamp_ns.tolist() for h in recorded] == [ts.stamp_ns.tolist(), rs.stamp_ns.tolist()]
    assert reader.topics['/pairs'].count == len(pair(*recorded)[0])
    comparison = Intercomparison(settings_for_bags(NORMS, bag))
    comparison.take_motion(read_bag_motion(reader, MotionRule()).rows)
    for stream in ('ts', 'rs'):
        comparison.take_quality(stream, read_quality(reader, f'{stream}/heading', []))
    comparison.update(*recorded)
    comparison.finish()
    assert_same(report, json.loads(json.dumps(comparison.verdict().to_dict())))


@pytest.mark.slow
def test_a_replay_as_processes_ends_by_itself_and_gives_the_same_report(processes, tmp_path):
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 300, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 300, 0.05, 90.1), 60.0)
    live, bag = run_live(processes, config, DRIVERS_LAST, signal.SIGINT)
    reports = tmp_path / 'replayed'
    for node in nodes('replay.launch.py', config=config, bag=str(bag), rate='50.0',
                      report_dir=str(reports)):
        processes.start(node)
    processes.wait('replayer')
    # What `ros2 launch` does when a node with on_exit=Shutdown() has ended.
    processes.signal(signal.SIGINT)
    processes.wait('intercompare')
    written, = reports.iterdir()
    assert_same(json.loads(written.read_text('utf-8')), live)


@pytest.mark.slow
def test_a_driver_that_is_stopped_keeps_the_times_of_receipt(processes, tmp_path):
    """Stopped for 3 s while the ship turns at 2 deg/s: 6 deg of error by the driver's clock."""
    ports = [free_port(), free_port()]
    config = tmp_path / 'config.yaml'
    config.write_text(yaml.dump({
        '/**': {'ros__parameters': NORMS}, **{
            name: {'ros__parameters': {'source': f'udp://127.0.0.1:{port}', 'sentence': 'HDT'}}
            for name, port in zip(('ts_driver', 'rs_driver'), ports)}}))
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    for node in nodes('intercompare.launch.py', config=str(config), output=str(bag),
                      report_dir=str(reports)):
        processes.start(node)
    ship = TurningShip(ports)
    ship.start()
    try:
        wait_for(lambda: count_recorded(bag) > 40)
        driver = processes.running['ts_driver']
        driver.send_signal(signal.SIGSTOP)
        before = len(ship.sent)
        wait_for(lambda: len(ship.sent) > before + 60)
        driver.send_signal(signal.SIGCONT)
        wait_for(lambda: count_recorded(bag) > before + 80)
    finally:
        ship.stopped.set()
        ship.join()
    processes.signal(signal.SIGINT)
    processes.wait('ts_driver', 'rs_driver', 'intercompare', 'recorder')
    reader = BagReader(bag)
    recorded = Headings.concatenate([chunk['ts/heading'] for chunk in reader.headings(
        {'ts/heading': 'enu'})])
    for stamp_ns, heading in zip(recorded.stamp_ns.tolist(), recorded.heading_deg.tolist()):
        before_ns, after_ns = ship.sent[round(heading % 360.0, 1)]
        # A busy kernel delivers a datagram some time after it was sent, 0.1 s once.
        assert before_ns <= stamp_ns <= after_ns + 500_000_000, heading
    written, = reports.iterdir()
    run, = json.loads(written.read_text('utf-8'))['runs']
    # By the driver's clock it would be 1.4.
    assert run['std_deg'] < 0.3


@pytest.mark.slow
@pytest.mark.parametrize('rate', ['0.0', '400.0'])
def test_a_replay_as_fast_as_possible_loses_nothing(processes, tmp_path, rate):
    """24 000 headings; best effort lost thousands of them."""
    bag, reports = tmp_path / 'trial', tmp_path / 'replayed'
    assert main(['simulate', '--quiet', '--scenario', 'demo', '-o', str(bag)]) == 0
    config = tmp_path / 'config.yaml'
    config.write_text(yaml.dump({'/**': {'ros__parameters': NORMS}}))
    for node in nodes('replay.launch.py', config=str(config), bag=str(bag), rate=rate,
                      report_dir=str(reports)):
        processes.start(node)
    processes.wait('replayer')
    processes.signal(signal.SIGINT)
    processes.wait('intercompare')
    written, = reports.iterdir()
    report = json.loads(written.read_text('utf-8'))
    run, = report['runs']
    assert (run['pairing']['ts_received'], run['pairing']['rs_received']) == (12000, 12000)
    assert_same(report, offline(bag))


@pytest.mark.slow
def test_a_recorder_that_is_stopped_for_a_while_records_everything(processes, tmp_path):
    """500 headings a second of each sensor go on for 4 s in which the recorder stands still."""
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 6000, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 6000, 0.05, 90.1), 100.0)
    bag = tmp_path / 'bag'
    for node in nodes('intercompare.launch.py', config=config, output=str(bag)):
        processes.start(node)
    wait_for(lambda: count_recorded(bag) >= 200)
    recorder = processes.running['recorder']
    recorder.send_signal(signal.SIGSTOP)
    began_s = time.monotonic()
    wait_for(lambda: time.monotonic() > began_s + 4.0)
    recorder.send_signal(signal.SIGCONT)
    processes.wait('ts_driver', 'rs_driver')
    processes.signal(signal.SIGINT)
    processes.wait('intercompare', 'recorder')
    counts = {name: info.count for name, info in BagReader(bag).topics.items()}
    assert (counts['/ts/heading'], counts['/rs/heading']) == (6000, 6000)


@pytest.mark.slow
@pytest.mark.parametrize('seconds, speed', [
    (7.0, 5.0), pytest.param(20.0, 10.0, marks=pytest.mark.endurance)])
def test_a_synchronizer_that_the_middleware_had_given_up_misses_nothing(
        processes, tmp_path, monkeypatch, seconds, speed):
    """
    Synchronizer and recorder stand still for longer than the lease of the middleware.

    So they are gone for the drivers, as after a cut of the network. The lease is 3 s here. After
    20 s the logs are over: before, the drivers ended, and what they had published was gone with
    them. Two processes of which only one has given up the other may need minutes to connect again,
    longer than a driver waits at its end. So some may be missing in the bag, which counts them.
    """
    monkeypatch.setattr(launch_files, 'LOOPBACK', short_lease(tmp_path / 'lease.xml', 3))
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 1200, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 1200, 0.05, 90.1), pace(speed))
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    for node in plan_trial(config, bag, reports).values():
        processes.start(node)
    wait_for(lambda: count_recorded(bag) >= 300)
    stopped = [processes.running[name] for name in ('intercompare', 'recorder')]
    for process in stopped:
        process.send_signal(signal.SIGSTOP)
    began_s = time.monotonic()
    wait_for(lambda: time.monotonic() > began_s + seconds)
    for process in stopped:
        process.send_signal(signal.SIGCONT)
    processes.wait('ts_driver', 'rs_driver')
    ended_s = time.monotonic()
    wait_for(lambda: count_recorded(bag, '/pairs') >= 1198 or time.monotonic() > ended_s + 40.0)
    end_trial(processes)
    written, = reports.iterdir()
    report = json.loads(written.read_text('utf-8'))
    run, = report['runs']
    assert (run['n'], run['pairing']['ts_received'], run['pairing']['rs_received']) == (
        1199, 1200, 1200)
    assert report['ledger_problems'] == []
    offline = judge_bags([str(bag)], settings_for_bags(NORMS, bag)).verdict.to_dict()
    pairing = offline['runs'][0]['pairing']
    for stream in ('ts', 'rs'):
        assert pairing[f'{stream}_received'] == count_recorded(bag, f'/{stream}/heading') >= 300
        assert pairing[f'{stream}_received'] + sum(pairing['lost'][stream].values()) == 1200


@pytest.mark.slow
def test_a_recorder_that_is_killed_goes_on_and_both_bags_are_one_whole(processes, tmp_path):
    """Started again by the launch file, it takes what the publishers still hold."""
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 2000, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 2000, 0.05, 90.1), 20.0)
    bag = tmp_path / 'bag'
    made = plan_trial(config, bag, tmp_path / 'reports')
    for node in made.values():
        processes.start(node)

    wait_for(lambda: count_recorded(bag) >= 300)
    began_s, before = time.monotonic(), count_recorded(bag)
    # 100 a second for two seconds, less the last one and a quarter; a busy machine takes longer.
    wait_for(lambda: time.monotonic() > began_s + 2.0 and count_recorded(bag) >= before + 75)
    processes.running['recorder'].kill()
    processes.running['recorder'].wait()
    assert BagReader(bag).incomplete
    wait_for(lambda: time.monotonic() > began_s + 5.0)
    processes.start(made['recorder'])
    rest = tmp_path / 'bag_2'
    wait_for(lambda: count_recorded(rest) >= 100)
    end_trial(processes)
    assert not BagReader(rest).incomplete
    judged = judge_bags([str(bag), str(rest)], settings_for_bags(NORMS, bag, rest)).verdict
    assert [part.continues for part in judged.inputs] == [None, str(bag)]
    written, = (tmp_path / 'reports').iterdir()
    assert_same(json.loads(written.read_text('utf-8')), judged.to_dict())
    assert judged.runs[0].n == 1999
    for topic in ('/ts/heading', '/rs/heading', '/pairs'):
        numbers = [message.sequence for part in (bag, rest)
                   for message in BagReader(part).messages([topic])]
        assert numbers == [*range(1, len(numbers) + 1)], topic
        assert len(numbers) == (1999 if topic == '/pairs' else 2000)
    counts = BagReader(rest).metadata()['recording']
    assert {key: n for key, n in counts.items()
            if n != '0' and not key.startswith('received.')} == {}


def start_graph(processes, config, namespace, bag=None, reports=None):
    """Start a graph in a namespace; return the names of its processes."""
    made = []
    for node in nodes('intercompare.launch.py', config=config, namespace=namespace,
                      output=str(bag) if bag else '', record='true' if bag else 'false',
                      report_dir=str(reports) if reports else ''):
        node.file = f'{node.label}{namespace.replace("/", "_")}'
        processes.start(node)
        made.append(node.file)
    return made


@pytest.mark.slow
def test_graphs_in_several_namespaces_of_one_domain_do_not_mix(processes, tmp_path):
    """The TS of one graph is 90 deg off; the other one does not notice."""
    found = {}
    for name, heading in (('a', 90.0), ('b', 180.0)):
        folder = tmp_path / name
        folder.mkdir()
        config = config_of(folder, log(folder / 'ts.log', 300, 0.0, heading),
                           log(folder / 'rs.log', 300, 0.05, 90.1), 30.0)
        found[name] = start_graph(processes, config, f'/{name}', folder / 'bag',
                                  folder / 'reports')
    drivers = [name for names in found.values() for name in names if 'driver' in name]
    processes.wait(*drivers)
    processes.signal(signal.SIGINT)
    processes.wait(*(name for names in found.values() for name in names))
    for name, mean_deg in (('a', -0.1), ('b', 89.9)):
        written, = (tmp_path / name / 'reports').iterdir()
        run, = json.loads(written.read_text('utf-8'))['runs']
        assert run['n'] == run['pairing']['paired'] == 299
        assert run['mean_deg'] == pytest.approx(mean_deg, abs=0.05)


@pytest.mark.slow
def test_a_second_graph_in_one_namespace_is_refused_and_the_first_goes_on(processes, tmp_path):
    """Its nodes end with exit code 2 and one line each; before, the verdict mixed both."""
    # Long enough that the first graph still publishes when the second is up on a busy computer.
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 2000, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 2000, 0.05, 90.1), 4.0)
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    first = start_graph(processes, config, '/', bag, reports)
    wait_for(lambda: count_recorded(bag) >= 20)
    other = config_of(tmp_path, log(tmp_path / 'wrong.log', 300, 0.0, 190.0),
                      log(tmp_path / 'rs_again.log', 300, 0.05, 90.1), 4.0)
    second = []
    for node in nodes('intercompare.launch.py', config=other, record='false'):
        node.file = f'{node.label}_second'
        processes.start(node)
        second.append(node.file)
    for name in second:
        assert processes.running[name].wait(DEADLINE_S) == 2, name
        said = (tmp_path / f'{name}.log').read_text()
        line, = [line for line in said.splitlines() if 'error:' in line]
        assert 'also publishes' in line and 'namespace' in line and 'Traceback' not in said
    before = count_recorded(bag)
    wait_for(lambda: count_recorded(bag) >= before + 20)
    processes.signal(signal.SIGINT)
    processes.wait(*first)
    written, = reports.iterdir()
    run, = json.loads(written.read_text('utf-8'))['runs']
    expected, = offline(bag)['runs']
    # On a busy computer the second drivers may be late to see the first ones. What they publish
    # until then is older, and rejected.
    assert run['n'] == run['pairing']['paired'] == expected['n'] > before
    assert (run['mean_deg'], run['std_deg']) == pytest.approx(
        (expected['mean_deg'], expected['std_deg']), rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('method, kills', [('interpolate', (250, 500, 750)), ('auto', (200, 700))])
def test_a_comparison_that_is_killed_goes_on_and_misses_nothing(
        processes, tmp_path, method, kills):
    """
    What pairs and what judges dies, and starts again at once, within 2 min of a log.

    With `auto` all readings wait for the choice when it is killed first. DDS lists the dead
    process for some 20 s.
    """
    rule = {**NORMS, 'pairing.method': method}
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 1200, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 1200, 0.05, 90.1), pace(10.0), rule)
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    made = plan_trial(config, bag, reports)
    for node in made.values():
        processes.start(node)
    for n in kills:
        wait_for(lambda n=n: count_recorded(bag) >= n)
        n_states = kill_and_restart(processes, made['intercompare'], bag)
    wait_for(lambda: count_recorded(bag, '/compliance/verdict') > n_states)
    end_trial(processes)
    written, = reports.iterdir()
    report = json.loads(written.read_text('utf-8'))
    run, = report['runs']
    judged = judge_bags([bag], settings_for_bags(rule, bag)).verdict
    assert_same(report, json.loads(json.dumps(judged.to_dict())))
    assert report['ledger_problems'] == []
    assert (run['pairing']['ts_received'], run['pairing']['rs_received']) == (1200, 1200)
    assert run['n'] == run['pairing']['paired'] == 1199
    assert run['pairing']['lost'] == {'ts': {}, 'rs': {}}
    counts = BagReader(bag).metadata()['recording']
    assert {key: n for key, n in counts.items() if 'heading' in key and n != '0'} == {
        f'received./{stream}/heading': '1200' for stream in ('ts', 'rs')}


def plan_apart(config, bag, reports):
    """Return the nodes of a trial by name, where each is a process, as by `ros2 run`."""
    made = plan_trial(config, bag, reports)
    both = made.pop('intercompare')
    for name, own in (('synchronizer', {'subscribers': 2}), ('compliance', {
            'report_dir': str(reports), **LIVE})):
        made[name] = replace(both, executable=name, name=name, parameters=[config, own])
    return made


@EITHER_EXECUTOR
@pytest.mark.slow
def test_a_compliance_apart_that_is_killed_goes_on_and_the_verdict_is_that_of_the_bag(
        processes, tmp_path):
    """Killed three times within 2 min of a log: nothing is missing, and nothing counts twice."""
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 1200, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 1200, 0.05, 90.1), pace(10.0))
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    made = plan_apart(config, bag, reports)
    for node in made.values():
        processes.start(node)
    for n in (250, 500, 750):
        wait_for(lambda n=n: count_recorded(bag) >= n)
        n_states = kill_and_restart(processes, made['compliance'], bag)
    wait_for(lambda: count_recorded(bag, '/compliance/verdict') > n_states)
    end_trial(processes, 'synchronizer', 'compliance')
    written, = reports.iterdir()
    report = json.loads(written.read_text('utf-8'))
    assert report['ledger_problems'] == []
    assert report['runs'][0]['n'] == report['runs'][0]['pairing']['paired'] == 1199
    assert_same(report, offline(bag))


@pytest.mark.slow
def test_a_synchronizer_apart_that_is_killed_ends_the_run_with_a_row(processes, tmp_path):
    """What it held is lost with it; the next one begins with what comes."""
    config = config_of(tmp_path, log(tmp_path / 'ts.log', 3000, 0.0, 90.0),
                       log(tmp_path / 'rs.log', 3000, 0.05, 90.1), 10.0)
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    made = plan_apart(config, bag, reports)
    for node in made.values():
        processes.start(node)
    wait_for(lambda: count_recorded(bag) >= 700)
    processes.running['synchronizer'].kill()
    processes.running['synchronizer'].wait()
    processes.start(made['synchronizer'])
    end_trial(processes, 'synchronizer', 'compliance')
    report = json.loads(max(reports.iterdir()).read_text('utf-8'))
    before, after = report['runs']
    assert (before.get('clock_segment'), after.get('clock_segment')) == (None, 1)
    assert before['n'] >= 600 and after['n'] >= 200
    for stream in ('ts', 'rs'):
        assert sum(run['pairing'][f'{stream}_received'] + sum(
            run['pairing']['lost'][stream].values()) for run in report['runs']) == 3000
    problem, = report['ledger_problems']
    assert 'and the run ended there' in problem and 'count as lost' in problem


@pytest.mark.slow
@pytest.mark.endurance
@pytest.mark.parametrize('word', [' rs', ''], ids=['reference', 'free'])
def test_several_sensors_whose_comparison_is_killed_have_the_verdict_of_the_bag(
        processes, tmp_path, word):
    """Killed twice within 2 min of three logs: nothing is missing, and nothing counts twice."""
    rows = f'a sigma_max_deg=0.3; b sigma_max_deg=0.3; c sigma_max_deg=0.3{word}'
    rule = {'sensors': rows, 'pairing.method': 'interpolate', 'risk.min_duration_s': 60.0}
    config = tmp_path / 'config.yaml'
    config.write_text(yaml.dump({'/**': {'ros__parameters': rule}, **{
        f'{name}_driver': {'ros__parameters': {
            'source': log(tmp_path / f'{name}.log', 900, 0.05 * at, 90.0 + 0.1 * at),
            'speed': 5.0}} for at, name in enumerate('abc')}}))
    bag, reports = tmp_path / 'bag', tmp_path / 'reports'
    made = nodes('intercompare.launch.py', config=str(config), output=str(bag),
                 report_dir=str(reports))
    for node in made:
        processes.start(node)
    judging = next(node for node in made if node.label == 'intercompare')
    for n in (300, 600):
        wait_for(lambda n=n: count_recorded(bag, '/a/heading') >= n)
        assert (reports / 'compliance.journal').exists()
        processes.running['intercompare'].kill()
        processes.running['intercompare'].wait()
        processes.start(judging)
    processes.wait('a_driver', 'b_driver', 'c_driver')
    # In this order, so that a busy computer does not decide who is late.
    for name in ('intercompare', 'recorder'):
        processes.running[name].send_signal(signal.SIGINT)
        processes.wait(name)
    written, = reports.glob('sensors_*.json')
    found = SensorsVerdict.from_dict(json.loads(written.read_text('utf-8')))
    whole = judge_bags([str(bag)], settings_for_bags(rule, bag)).verdict
    assert [*find_sensor_differences(found, whole)] == []
    assert not [*tmp_path.rglob('*.journal*')]


def start_live(processes, folder, config, name):
    """Start `live` as a user would, always with the same command."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(DOMAIN),
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}
    with open(folder / f'{name}.log', 'wb') as said:
        processes.running[name] = subprocess.Popen(
            [sys.executable, '-m', 'heading_intercompare', 'live', '--config', str(config),
             '-o', 'trial', '--json', 'verdict.json'],
            env=environment, cwd=folder, stdout=said, stderr=said)


def write_udp_config(folder, rule):
    """Write a parameter file of two UDP drivers; return it and their ports."""
    ports = [free_port(), free_port()]
    config = folder / 'config.yaml'
    config.write_text(yaml.dump({
        '/**': {'ros__parameters': rule}, **{
            name: {'ros__parameters': {'source': f'udp://127.0.0.1:{port}', 'sentence': 'HDT'}}
            for name, port in zip(('ts_driver', 'rs_driver'), ports)}}))
    return config, ports


SENSORS = """
import rclpy, sys
from rclpy.node import Node
from sensor_msgs.msg import Imu
rclpy.init()
node = Node('other_sensors')
publishers = [node.create_publisher(Imu, f'{name}/imu', 10) for name in ('gyro', 'compass')]
def publish():
    for publisher in publishers:
        message = Imu()
        message.header.stamp = node.get_clock().now().to_msg()
        message.orientation.w = 1.0
        publisher.publish(message)
node.create_timer(0.02, publish)
rclpy.spin(node)
"""


@pytest.mark.slow
@pytest.mark.parametrize('how', ['live', 'launch'])
def test_sensors_that_go_on_when_the_graph_ends_do_not_hold_it_up(processes, tmp_path, how):
    """What they publish after the last verdict is not in the bag, which says the same as live."""
    config = tmp_path / 'config.yaml'
    config.write_text(yaml.dump({'/**': {'ros__parameters': {
        **NORMS, 'ts_topic': 'gyro/imu', 'rs_topic': 'compass/imu'}}}))
    bag, report = tmp_path / 'trial', tmp_path / 'verdict.json'
    processes.running['sensors'] = subprocess.Popen(
        [sys.executable, '-c', SENSORS],
        env=make_environment(DOMAIN, 'UDPv4' if how == 'launch' else ''),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if how == 'live':
        names = ['live']
        start_live(processes, tmp_path, config, 'live')
    else:
        made = plan_trial(str(config), bag, tmp_path / 'reports')
        names = [*made]
        for node in made.values():
            processes.start(node)
    wait_for(lambda: count_recorded(bag, '/gyro/imu') >= 200)
    watch = Stopwatch()
    for name in names:
        processes.running[name].send_signal(signal.SIGINT)
    for name in names:
        said = tmp_path / f'{name}.log'
        assert processes.running[name].wait(DEADLINE_S) == 0, said.read_text()
    assert watch.passed_s < 20.0, 'nobody waits for sensors that never end'
    assert processes.running['sensors'].poll() is None
    if how == 'launch':
        report, = (tmp_path / 'reports').glob('verdict_*.json')
    live = read(report)
    assert live.runs[0].n >= 190
    assert BagReader(bag).incomplete is None
    again = judge_bags([str(bag)], settings_for_bags(
        {**NORMS, 'ts_topic': 'gyro/imu', 'rs_topic': 'compass/imu'}, bag)).verdict
    assert list(find_differences(live, again)) == []


@pytest.mark.slow
def test_a_trial_in_order_logs_no_warning_from_its_start_to_its_end(processes, tmp_path):
    config, ports = write_udp_config(tmp_path, {**NORMS, 'pairing.method': 'interpolate'})
    ship = TurningShip(ports)
    ship.start()
    try:
        start_live(processes, tmp_path, config, 'live')
        wait_for(lambda: count_recorded(tmp_path / 'trial') > 100)
        processes.running['live'].send_signal(signal.SIGINT)
        processes.wait('live')
    finally:
        ship.stopped.set()
        ship.join()
    said = (tmp_path / 'live.log').read_text()
    assert '[compliance]: verdict on 1 run:' in said
    assert '[WARN]' not in said and '[ERROR]' not in said


@pytest.mark.slow
def test_live_and_record_on_a_terminal_show_the_graph_and_leave_the_terminal_as_it_was(
        processes, tmp_path):
    pytest.importorskip('rich')
    config, ports = write_udp_config(tmp_path, {**NORMS, 'pairing.method': 'interpolate'})
    ship, ours, theirs = TurningShip(ports), *pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0))
    before, written = termios.tcgetattr(theirs), [b'']
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(DOMAIN), 'TERM': 'xterm',
                   'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}

    def shows(*words):
        with suppress(BlockingIOError):
            written[0] += os.read(ours, 65536)
        return all(word in written[0].decode(errors='ignore') for word in words)
    os.set_blocking(ours, False)
    ship.start()
    try:
        for command, words, told in (
                (['live', '--config', str(config), '-o', 'trial'],
                 ['starting: looking for other graphs', 'NONE YET', 'recording to trial',
                  'ts_driver', 'paired ', 'nothing speaks against'], 'VERDICT: '),
                (['record', '-o', 'raw'], ['recording to raw', 'recorder'], '')):
            written[0] = b''
            live = processes.running[command[0]] = subprocess.Popen(
                [sys.executable, '-m', 'heading_intercompare', *command], env=environment,
                cwd=tmp_path, stdin=theirs, stdout=theirs, stderr=theirs)
            wait_for(lambda words=words: shows(*words))
            live.send_signal(signal.SIGINT)
            wait_for(lambda live=live: shows() and live.poll() is not None)
            assert shows(told) and live.returncode == 0
            assert termios.tcgetattr(theirs) == before
            assert b' WARN ' not in written[0] and b' ERROR ' not in written[0]
    finally:
        ship.stopped.set()
        ship.join()
        os.close(ours)
        os.close(theirs)


@pytest.mark.slow
def test_live_that_is_killed_goes_on_in_a_new_bag_of_the_same_run(processes, tmp_path):
    """The verdict covers both parts, and so does `analyze` of both bags."""
    rule = {**NORMS, 'pairing.method': 'interpolate'}
    config, ports = write_udp_config(tmp_path, rule)
    ship = TurningShip(ports)
    ship.start()
    try:
        start_live(processes, tmp_path, config, 'first')
        wait_for(lambda: count_recorded(tmp_path / 'trial') > 100)
        processes.running['first'].kill()
        processes.running['first'].wait()
        start_live(processes, tmp_path, config, 'second')
        wait_for(lambda: count_recorded(tmp_path / 'trial_2') > 100)
        processes.running['second'].send_signal(signal.SIGINT)
        processes.wait('second')
    finally:
        ship.stopped.set()
        ship.join()
    said = (tmp_path / 'second.log').read_text()
    assert f'goes on with the trial of {tmp_path / "trial"}; records trial_2' in said
    live = json.loads((tmp_path / 'verdict.json').read_text('utf-8'))
    run, = live['runs']
    assert not list(tmp_path.glob('*.journal'))
    judged = judge_bags([tmp_path / 'trial', tmp_path / 'trial_2'],
                        settings_for_bags(rule, tmp_path / 'trial', tmp_path / 'trial_2'))
    both, = judged.verdict.runs
    # A kill costs the bag up to a second, and the judge the readings on their way to it.
    assert abs(both.n - run['n']) <= 30
    assert (both.start_ns, both.end_ns) == (run['start_ns'], run['end_ns'])
    assert both.outcome.value == run['outcome']
    assert any('goes on with this trial' in note for note in judged.notes)
    assert any('was restarted at' in problem for problem in live['ledger_problems'])
    assert [one.continues for one in judged.verdict.inputs] == [None, str(tmp_path / 'trial')]
    alone = judge_bags([tmp_path / 'trial_2'], settings_for_bags(
        rule, tmp_path / 'trial_2')).verdict.runs[0]
    assert alone.n < both.n
