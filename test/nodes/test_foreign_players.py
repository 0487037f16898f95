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

"""A bag played into a running graph by a program that waits for nobody, at 20 times its speed."""

from __future__ import annotations

import json
from pathlib import Path
import signal
import subprocess
import sys

from nodes import plain_player
from nodes.graph_checks import assert_same, settings_for_bags
from nodes.launch_files import make_environment, nodes
from nodes.processes import Processes
from nodes.ros_nodes import NORMS
import numpy as np
import pytest
from ros_domain import DOMAIN
from trials import write_headings
import yaml

from heading_intercompare import Headings, judge_bags
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.messages.heading_messages import IMU

pytestmark = [pytest.mark.process, pytest.mark.slow]

N = 1200


@pytest.fixture
def processes(tmp_path):
    """Return the processes of a test."""
    made = Processes(tmp_path)
    yield made
    made.reap()


def write_bag(path):
    """Write two minutes of two sensors at 10 Hz, without the numbers of their publishers."""
    rng = np.random.default_rng(17)
    stamps = 1_700_000_000_000_000_000 + np.arange(N) * 10 ** 8
    write_headings(path, {topic: Headings.of(stamps, 90.0 + 0.1 * rng.standard_normal(N))
                          for topic in ('/ts/heading', '/rs/heading')})
    return path


def run_player(*arguments):
    """Run the plain player as a process, and wait for its end; return what it has printed."""
    return subprocess.run(
        [sys.executable, plain_player.__file__, *map(str, arguments)], check=True,
        env=make_environment(DOMAIN, 'UDPv4'), timeout=240.0, stdout=subprocess.PIPE).stdout


@pytest.mark.parametrize('kind, given', [
    ('kept', {}), ('volatile', {}), ('best_effort', {}),
    ('volatile', {'ts_message_type': IMU, 'rs_message_type': IMU})])
def test_a_bag_played_into_a_running_graph_is_paired_whole_or_what_is_missing_is_counted(
        processes, tmp_path, kind, given):
    """The graph has been there for a while. Of 3120 pairs 110 were missing without a word."""
    config, reports = tmp_path / 'config.yaml', tmp_path / 'reports'
    config.write_text(yaml.dump({
        '/**': {'ros__parameters': NORMS},
        **{name: {'ros__parameters': dict(given)}
           for name in ('synchronizer', 'recorder') if given}}))
    for node in nodes('intercompare.launch.py', config=str(config), drivers='false',
                      output=str(tmp_path / 'bag'), report_dir=str(reports)):
        processes.start(node)
    run_player('await', 1)
    run_player('play', write_bag(tmp_path / 'played'), 20, kind, '/ts/heading', '/rs/heading')
    processes.signal(signal.SIGINT)
    processes.wait('intercompare', 'recorder')
    written, = Path(reports).iterdir()
    report = json.loads(written.read_text('utf-8'))
    pairing = report['runs'][0]['pairing']
    for stream in ('ts', 'rs'):
        lost = pairing['lost'][stream]
        assert pairing[f'{stream}_received'] + sum(lost.values()) == N
        # Until the middleware has connected the two, a player that keeps nothing is not heard.
        # What a best-effort one sends is not sent again where a packet is lost.
        assert lost.keys() <= {'kept': set(), 'volatile': {'before_start'},
                               'best_effort': {'before_start', 'on_the_way'}}[kind]
    if kind == 'kept':
        # One of the two may be heard seconds after the other.
        assert pairing['paired'] == N
        assert_same(report, judge_bags([tmp_path / 'bag'], settings_for_bags(
            NORMS, tmp_path / 'bag')).verdict.to_dict())


def write_with_steps(path, name):
    """Write two minutes of two sensors, of which clocks are set back; they come at true times."""
    rng = np.random.default_rng(17)
    came_ns = 1_700_000_000_000_000_000 + np.arange(N) * 10 ** 8
    stamps = {'ts': came_ns.copy(), 'rs': came_ns.copy()}
    hour_ns = 3600 * 10 ** 9
    if name == 'ahead for 20 s':
        stamps['ts'][400:600] += hour_ns
    else:
        for stream in stamps:
            stamps[stream][400:] -= hour_ns
    topics = {f'/{stream}/heading': Headings.of(stamp_ns, 90.0 + 0.1 * rng.standard_normal(N))
              for stream, stamp_ns in stamps.items()}
    return write_headings(path, topics, came_ns=dict.fromkeys(topics, came_ns))


@pytest.mark.parametrize('name, counts', [
    ('ahead for 20 s', [400, 600]), ('both set back', [400, 800])])
def test_a_clock_that_is_set_back_ends_the_run_live_as_in_the_bag(
        processes, tmp_path, name, counts):
    """Before, the sensor was not heard until its stamps had caught up, an hour later."""
    config, reports, bag = tmp_path / 'config.yaml', tmp_path / 'reports', tmp_path / 'bag'
    norms = {**NORMS, 'runs.min_duration_s': 10.0}
    config.write_text(yaml.dump({'/**': {'ros__parameters': norms}}))
    for node in nodes('intercompare.launch.py', config=str(config), drivers='false',
                      output=str(bag), report_dir=str(reports)):
        processes.start(node)
    run_player('await', 1)
    run_player('play', write_with_steps(tmp_path / 'played', name), 10, 'kept', '/ts/heading',
               '/rs/heading')
    processes.signal(signal.SIGINT)
    processes.wait('intercompare', 'recorder')
    report = json.loads(sorted(reports.iterdir())[-1].read_text('utf-8'))
    assert [run['pairing']['paired'] for run in report['runs']] == counts
    assert [run.get('clock_segment') for run in report['runs']] == [None, 1]
    assert 'was set back by 3600.0 s' in report['headline']
    assert_same(report, judge_bags([bag], settings_for_bags(norms, bag)).verdict.to_dict())


STARTS = 8


def count_account(pairing, stream):
    """Return how many readings of a sensor were received, and how many have a row as lost."""
    return pairing[f'{stream}_received'], sum(pairing['lost'][stream].values())


@pytest.mark.parametrize('kind', ['volatile', 'best_effort'])
def test_a_foreign_publisher_that_restarts_has_a_row_for_what_was_not_heard(
        processes, tmp_path, kind):
    """Before, 28 of 1579 had none live and 49 in the bag, and both ledgers were complete."""
    config, reports, bag = tmp_path / 'config.yaml', tmp_path / 'reports', tmp_path / 'bag'
    # On a loaded machine, minutes may pass until the next publisher is there.
    rule = {**NORMS, 'pairing.method': 'interpolate', 'runs.gap_s': 3600.0}
    config.write_text(yaml.dump({'/**': {'ros__parameters': rule}}))
    for node in nodes('intercompare.launch.py', config=str(config), drivers='false',
                      output=str(bag), report_dir=str(reports)):
        processes.start(node)
    run_player('await', 1)
    sent = latest = 0
    for start in range(STARTS):
        # Of each second one the first number heard is the one that follows the last.
        latest = int(run_player('send', latest * (start % 2), 100, 100, kind, 2,
                                '/ts/heading', '/rs/heading'))
        sent += latest
    processes.signal(signal.SIGINT)
    processes.wait('intercompare', 'recorder')
    written, = reports.iterdir()
    live, = json.loads(written.read_text('utf-8'))['runs']
    offline, = judge_bags([bag], settings_for_bags(rule, bag)).verdict.to_dict()['runs']
    counts = BagReader(bag).metadata()['recording']
    for stream in ('ts', 'rs'):
        received, lost = count_account(live['pairing'], stream)
        assert received + lost == sent and lost > 0
        recorded, missing = count_account(offline['pairing'], stream)
        assert recorded + missing == sent
        # Two subscriptions do not hear the same first message; the bag says what was judged.
        assert received - recorded <= sum(
            int(counts[f'{key}./{stream}/heading']) for key in (
                'missed_at_first', 'lost_on_the_way'))
