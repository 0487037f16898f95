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

"""The node that plays bags."""

from __future__ import annotations

import json
import subprocess
import sys
import time

from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from nodes.graph_checks import assert_same
from nodes.rclpy_objects import headings_from, ledger_from, marker_message, marks_from
from nodes.ros_nodes import EITHER_EXECUTOR, NORMS, Ros
import numpy as np
import pytest
from rclpy.node import Node
from rclpy.serialization import serialize_message
from ros_domain import take_domain
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from std_srvs.srv import Trigger

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.bags.errors import BagError
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.cli import main
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import encode_imu
from heading_intercompare.messages.ledger_messages import encode_losses
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.replayer import Replayer
from heading_intercompare.nodes.synchronizer import Synchronizer

T0_NS = 1_700_000_000_000_000_000
HEADINGS = Headings.as_sent(T0_NS + np.arange(300) * 10 ** 8, np.arange(300) % 360.0)


def stamp_of(time):
    """Return a stamp in nanoseconds."""
    return time.sec * 10 ** 9 + time.nanosec


def bag_of(path, marks=(), ts_topic='/ts/heading', noise_deg=None, place=''):
    """Write 30 s of both sensors at 10 Hz, and marks at the end of the file."""
    with BagWriter(path) as bag:
        rows, ts_topic, marker = [], place + ts_topic, f'{place}/compliance/marker'
        for topic in (ts_topic, f'{place}/rs/heading'):
            readings = HEADINGS
            if topic == ts_topic and noise_deg is not None:
                readings = Headings.as_sent(HEADINGS.stamp_ns,
                                       (HEADINGS.heading_deg + noise_deg) % 360.0)
            bag.add_topic(topic, 'sensor_msgs/msg/Imu')
            rows.append(Rows(topic, encode_imu(readings, 'gyro'), HEADINGS.stamp_ns + 5))
        bag.write_rows(rows)
        if marks:
            bag.add_topic(marker, 'diagnostic_msgs/msg/DiagnosticArray')
        for kind, ns in marks:
            bag.write(marker, serialize_message(marker_message(kind, ns)),
                      T0_NS + 10 ** 12)
    return str(path)


def listeners(ros, node=None):
    """Return the messages on the topics of both sensors, which the test or a node hears."""
    return [ros.listen(Imu, f'{role}/heading', qos.PAIRS_TAKEN, node) for role in ('ts', 'rs')]


def test_headings_come_as_they_were_recorded_and_then_the_node_is_done(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0)
    ts, rs = listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == len(rs) == 300)
    chunk_ns = headings_from(ts, 'enu').stamp_ns.tolist()
    assert chunk_ns == HEADINGS.stamp_ns.tolist()
    assert headings_from(ts, 'enu') == headings_from(rs, 'enu')
    assert node.published == 600


def test_a_bag_of_a_graph_in_a_namespace_is_replayed_in_that_of_the_node(ros, tmp_path):
    bag = bag_of(tmp_path / 'bag', [('start', T0_NS)], place='/ship1')
    with pytest.raises(BagError, match=r"'ts/heading', but /ship1/ts/heading \(bag_namespace="):
        ros.ours(Replayer, bag=bag)
    marks = ros.listen(DiagnosticArray, 'compliance/marker', qos.MARKER)
    node = ros.ours(Replayer, bag=bag, rate=0.0, bag_namespace='/ship1')
    ts, rs = listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == len(rs) == 300 and len(marks) == 1)


def test_a_replay_says_for_whom_it_waits_and_how_it_goes_on(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), subscribers=2, start_paused=True)
    ros.spin_until(lambda: node.state == (
        'waiting for 2 subscribers of /ts/heading and /rs/heading (0 and 0 there); then paused at '
        '0.000 s of 29.900 s'))
    listeners(ros)
    ros.spin_until(lambda: '(1 and 1 there); then' in node.state)
    listeners(ros, ros.add(Node, 'second'))
    ros.spin_until(lambda: node.state == 'paused at 0.000 s of 29.900 s')
    node.pause(False)
    ros.spin_until(lambda: node.state.startswith('replaying at '))


def test_a_replay_counts_what_its_recording_lacks_as_the_analysis_does(ros, tmp_path):
    """A third of the RS is missing by its numbers, and its driver dropped some."""
    kept = np.sort(np.random.default_rng(3).choice(np.arange(2, 300), 200, replace=False))
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata('heading_intercompare', {})
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, 'sensor_msgs/msg/Imu')
            mine = kept if topic == '/rs/heading' else np.arange(300)
            bag.write_rows([Rows(topic, encode_imu(HEADINGS[mine], 'gyro'),
                                 HEADINGS.stamp_ns[mine] + 5, sequence=mine + 1)])
        bag.add_topic('/rs/heading/lost', 'diagnostic_msgs/msg/DiagnosticArray')
        bag.write('/rs/heading/lost', encode_losses({'lost.at_source': Losses.of(
            [HEADINGS.stamp_ns[100]], [HEADINGS.stamp_ns[99]], [11])}), T0_NS + 10 ** 10)
    settings = {'runs.min_duration_s': 0.0, 'pairing.method': 'interpolate'}
    offline = judge_bags([tmp_path / 'bag'],
                         Settings.from_mapping({**NORMS, **settings})).verdict.to_dict()
    synchronizer = ros.ours(Synchronizer, **settings)
    compliance = ros.ours(Compliance, **settings)
    replayer = ros.ours(Replayer, bag=str(tmp_path / 'bag'), rate=100.0)
    ros.spin_until(lambda: replayer.done)
    ros.end(replayer, synchronizer, compliance)
    live = compliance.verdict.to_dict()
    missing = int(kept[-1] - kept[0] + 1 - 200)
    assert live['runs'][0]['pairing']['lost'] == {
        'ts': {}, 'rs': {'on_the_way': missing, 'at_source': 11, 'before_start': int(kept[0])}}
    assert_same(live, offline)


def test_the_rate_is_kept(ros, tmp_path):
    """The bag lasts 30 s."""
    began_s, watch = time.monotonic(), Stopwatch()
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=30.0)
    listeners(ros)
    ros.spin_until(lambda: node.done)
    assert time.monotonic() - began_s > 0.95 and watch.passed_s < 15.0


def test_a_part_can_be_replayed(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, start_s=10.0,
                    duration_s=5.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == 50)
    assert headings_from(ts, 'enu') == HEADINGS[100:150] or headings_from(
        ts, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns[100:150].tolist()


def test_nothing_is_sent_before_both_topics_are_heard(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0)
    ts = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: ros.executor.spin_once(0.3) is None)
    assert (ts, node.done) == ([], False)
    ros.listen(Imu, 'rs/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: node.done)


def test_marks_come_before_any_heading_wherever_they_stand_in_the_bag(ros, tmp_path):
    marks = [('start', T0_NS + 10 ** 9), ('stop', T0_NS + 2 * 10 ** 9)]
    order = []
    for kind, topic, profile in ((DiagnosticArray, 'compliance/marker', qos.MARKER),
                                 (Imu, 'ts/heading', qos.PAIRS_TAKEN),
                                 (Imu, 'rs/heading', qos.PAIRS_TAKEN)):
        for _ in range(2):
            ros.plain.create_subscription(kind, topic, lambda m: order.append(m), profile)
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag', marks), rate=0.0)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(order) == 2 * 602)
    first = [m for m in order if isinstance(m, DiagnosticArray)]
    assert order[:4] == first
    assert {mark for m in first for mark in marks_from(m)} == set(marks)


def test_the_clock_of_the_recording_can_be_published(ros, tmp_path):
    heard = ros.listen(Clock, '/clock', qos.CLOCK)
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=30.0, clock=True)
    listeners(ros)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: heard and stamp_of(heard[-1].clock) - T0_NS > 27e9)
    shown = [stamp_of(m.clock) for m in heard]
    assert len(shown) > 10 and shown == sorted(shown)
    assert T0_NS <= shown[0] and shown[-1] - T0_NS < 33e9


def test_without_being_asked_no_clock_is_published(ros, tmp_path):
    ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'))
    assert ros.plain.count_publishers('/clock') == 0


def test_a_loop_begins_again(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, loop=True,
                    duration_s=1.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: len(ts) >= 25)
    assert not node.done
    assert headings_from(ts[:20], 'enu').stamp_ns.tolist() == 2 * HEADINGS.stamp_ns[:10].tolist()


def test_a_loop_is_for_watching_for_its_stamps_go_back_and_are_rejected(ros, tmp_path):
    books = ros.listen(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    ros.ours(Synchronizer, subscribers=0, pairing__method='interpolate')
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, loop=True, duration_s=2.0)
    ros.spin_until(lambda: node.published >= 160)

    def counts():
        return ledger_from(books[-1])[0].total.counts if books else {}
    ros.spin_until(lambda: counts().get('ts_rejected.stamp_not_increasing', 0) >= 20)
    assert counts()['paired'] in (19, 20)
    assert counts()['rs_rejected.stamp_not_increasing'] >= 20


class SteadyClock:
    """A clock that stands still until it is set; nanoseconds."""

    def __init__(self):
        self.ns = 10 ** 12

    def __call__(self):
        return self.ns


def paced(ros, path, **values):
    """Return a replayer on a clock that stands, the clock, and what is heard of both topics."""
    clock = SteadyClock()
    node = ros.add(Replayer, clock_ns=clock, parameter_overrides=make_overrides({
        **NORMS, 'bag': bag_of(path), 'max_rate_hz': 100000.0, **values}))
    ts, rs = listeners(ros)
    ros.spin_until(lambda: node.published == 2 or 'paused at' in node.state)
    return node, clock, ts, rs


def until_published(ros, node, n):
    """Spin until `n` messages are out."""
    ros.spin_until(lambda: node.published >= n)


def ticks(ros, n=4):
    """Spin until the replayer has looked at the clock several times more."""
    seen = []
    timer = ros.plain.create_timer(0.02, lambda: seen.append(1))
    ros.spin_until(lambda: len(seen) > n)
    ros.plain.destroy_timer(timer)


def test_each_message_goes_out_when_it_is_due_and_not_before(ros, tmp_path):
    """At half speed, pair k is due 0.2 s times k after the first, to the ns."""
    node, clock, ts, rs = paced(ros, tmp_path / 'bag', rate=0.5)
    begin_ns = clock.ns
    for k in (1, 2, 50, 51, 52, 298):
        clock.ns = begin_ns + k * 200_000_000 - 2
        until_published(ros, node, 2 * k)
        ticks(ros)
        assert node.published == 2 * k
        clock.ns += 2
        until_published(ros, node, 2 * k + 2)
    ros.spin_until(lambda: len(ts) == len(rs) == 299)
    assert headings_from(ts, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns[:299].tolist()


def asked(ros, name):
    """Call a service of the replayer; return its answer."""
    client = ros.plain.create_client(Trigger, f'replayer/{name}')
    ros.spin_until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    ros.spin_until(answer.done)
    ros.plain.destroy_client(client)
    return answer.result().success, answer.result().message


@EITHER_EXECUTOR
def test_the_services_pause_and_resume_and_say_where(ros, tmp_path):
    node, clock, ts, _ = paced(ros, tmp_path / 'bag')
    clock.ns += 1_000_000_000
    ros.spin_until(lambda: node.published == 22)
    assert asked(ros, 'resume') == (True, 'not paused, at 1.000 s of 29.900 s')
    assert asked(ros, 'pause') == (True, 'paused at 1.000 s of 29.900 s')
    assert asked(ros, 'pause') == (True, 'already paused at 1.000 s of 29.900 s')
    clock.ns += 5_000_000_000
    ticks(ros)
    assert node.state == 'paused at 1.000 s of 29.900 s' and node.published == 22
    assert asked(ros, 'toggle_paused') == (True, 'resumed at 1.000 s of 29.900 s')
    ticks(ros)
    assert node.published == 22
    clock.ns += 99_999_999
    ticks(ros)
    assert node.published == 22
    clock.ns += 1
    ros.spin_until(lambda: node.published == 24)
    assert asked(ros, 'toggle_paused') == (True, 'paused at 1.100 s of 29.900 s')
    assert asked(ros, 'resume') == (True, 'resumed at 1.100 s of 29.900 s')
    clock.ns += 40_000_000_000
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(ts) == 300)
    assert headings_from(ts, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns.tolist()
    assert asked(ros, 'pause') == (False, 'the replay is over')


def test_a_replay_without_waiting_can_be_paused(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, max_rate_hz=200.0)
    ts, rs = listeners(ros)
    ros.spin_until(lambda: ts)
    assert asked(ros, 'pause')[1].startswith('paused at ')
    before = node.published
    assert 0 < before < 600
    ticks(ros, 10)
    assert node.published == before
    asked(ros, 'resume')
    ros.spin_until(lambda: len(ts) == len(rs) == 300)
    assert headings_from(ts, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns.tolist()


def test_a_loop_without_waiting_or_bound_still_answers(ros, tmp_path):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=0.0, loop=True,
                    max_rate_hz=100000.0)
    ts, _ = listeners(ros)
    until_published(ros, node, 1300)
    assert asked(ros, 'pause')[1].startswith('paused at ')
    before = node.published
    ticks(ros)
    assert node.published == before and not node.done


def test_it_can_start_paused_with_its_clock_standing(ros, tmp_path):
    shown = ros.listen(Clock, '/clock', qos.CLOCK)
    node, clock, ts, _ = paced(ros, tmp_path / 'bag', start_paused=True, clock=True, start_s=2.0)
    clock.ns += 9_000_000_000
    shown.clear()
    ros.spin_until(lambda: len(shown) > 5)
    assert {stamp_of(m.clock) for m in shown} == {T0_NS + 5 + 2 * 10 ** 9}
    assert (node.published, ts) == (0, [])
    assert asked(ros, 'resume')[1] == 'resumed at 2.000 s of 29.900 s'
    clock.ns += 10 ** 8
    ros.spin_until(lambda: node.published == 4)
    asked(ros, 'pause')
    shown.clear()
    ros.spin_until(lambda: len(shown) > 5)
    assert {stamp_of(m.clock) for m in shown} == {T0_NS + 5 + 21 * 10 ** 8}


def test_the_clock_does_not_run_ahead_of_messages_that_are_held_up(ros, tmp_path):
    """An hour in a moment: the rate of messages is limited, and the clock waits for them."""
    shown = ros.listen(Clock, '/clock', qos.CLOCK)
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), rate=3600.0, clock=True,
                    max_rate_hz=500.0)
    ts, _ = listeners(ros)
    ros.spin_until(lambda: node.done)
    times = [stamp_of(m.clock) for m in shown]
    # Some 20 in the 1.2 s that the messages take, best effort; at its own rate it would be 2.
    assert times == sorted(times) and len(set(times)) > 8
    assert max(times) <= T0_NS + 5 + 29_900_000_000


def test_the_diagnostics_say_that_it_is_paused(ros, tmp_path):
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    node, *_ = paced(ros, tmp_path / 'bag', start_paused=True)

    def said(message):
        return next(({v.key: v.value for v in s.values}['paused'], s.message)
                    for s in message.status if s.name == 'replayer: bag')
    ros.spin_until(lambda: heard)
    heard.clear()
    ros.spin_until(lambda: heard)
    assert said(heard[-1]) == ('true', 'paused at 0.000 s of 29.900 s')
    for wanted, words in ((False, ('false', 'replaying at 0.000 s of 29.900 s')),
                          (True, ('true', 'paused at 0.000 s of 29.900 s'))):
        heard.clear()
        node.pause(wanted)
        # At once, though one of each second may have been under way.
        ros.spin_until(lambda words=words: words in [said(m) for m in heard[:2]])


REMAP = ['--ros-args', '-r', 'ts/heading:=gyro/heading', '-r', 'compliance/marker:=old/marks']


@pytest.mark.parametrize('marks, rules, options', [
    ([('start', T0_NS + 10 ** 9)], REMAP, {}),
    # As the command line gives them: the rules, and what they are about.
    ([('start', T0_NS + 10 ** 9)], REMAP,
     {'remapped': ['/ts/heading', 'compliance/marker']})])
def test_remapping_changes_what_is_published_and_not_what_is_read(
        ros, tmp_path, marks, rules, options):
    heard = ros.listen(Imu, 'gyro/heading', qos.PAIRS_TAKEN)
    old, _ = (ros.listen(DiagnosticArray, 'old/marks', qos.MARKER) for _ in range(2))
    listeners(ros)
    node = ros.add(Replayer, cli_args=rules, **options, parameter_overrides=make_overrides({
        **NORMS, 'bag': bag_of(tmp_path / 'bag', marks), 'rate': 0.0}))
    ros.spin_until(lambda: node.done and len(heard) == 300 and old)
    assert headings_from(heard, 'enu').stamp_ns.tolist() == HEADINGS.stamp_ns.tolist()
    assert marks_from(old[0]) == marks
    assert [ros.plain.count_publishers(name) for name in (
        'ts/heading', 'rs/heading', 'gyro/heading', 'compliance/marker', 'old/marks')] == [
        0, 1, 1, 0, 1]


def test_a_bag_with_a_topic_of_its_own_name_can_go_out_under_the_usual_one(ros, tmp_path):
    ts, _ = listeners(ros)
    bag = bag_of(tmp_path / 'bag', ts_topic='/bridge/gyro_1')
    node = ros.add(Replayer, cli_args=['--ros-args', '-r', 'bridge/gyro_1:=ts/heading'],
                   remapped=['bridge/gyro_1'], parameter_overrides=make_overrides({
                       **NORMS, 'bag': bag, 'rate': 0.0, 'ts_topic': 'bridge/gyro_1'}))
    ros.spin_until(lambda: node.done and len(ts) == 300)
    with pytest.raises(BagError, match="has no topic 'ts/heading'"):
        ros.add(Replayer, cli_args=['--ros-args', '-r', 'ts/heading:=bridge/gyro_1'],
                parameter_overrides=make_overrides({**NORMS, 'bag': bag}))


@pytest.mark.parametrize('rules, remapped, words', [
    ([], ['pairs'], "remap 'pairs': is not replayed; must be one of ts/heading, rs/heading, "
     'compliance/marker'),
    ([], ['/clock'], "remap '/clock': is not replayed"),
    ([], ['ts/heading', '/ts/heading'], "remap 'ts/heading': is given 2 times"),
    (['ts/heading:=rs/heading'], [], "topic 'rs/heading' would be published as /rs/heading, "
     "which is already the name of 'ts/heading'"),
    (['compliance/marker:=ts/heading'], [], "topic 'compliance/marker' would be published"),
    (['rs/heading:=/rosout'], [], "topic 'rs/heading' would be published as /rosout"),
])
def test_a_remapping_that_cannot_be_is_refused(ros, tmp_path, rules, remapped, words):
    args = [part for rule in rules for part in ('-r', rule)]
    with pytest.raises(SettingsError) as raised:
        ros.add(Replayer, remapped=remapped, cli_args=['--ros-args', *args] if args else [],
                parameter_overrides=make_overrides({**NORMS, 'bag': bag_of(tmp_path / 'bag')}))
    assert str(raised.value).startswith(words)


def test_two_sensors_cannot_be_swapped_into_one_but_with_each_other(ros, tmp_path):
    ts, rs = listeners(ros)
    bag = bag_of(tmp_path / 'bag', noise_deg=np.full(300, 90.0))
    node = ros.add(Replayer, cli_args=['--ros-args', '-r', 'ts/heading:=rs/heading', '-r',
                                       'rs/heading:=ts/heading'],
                   parameter_overrides=make_overrides({**NORMS, 'bag': bag, 'rate': 0.0}))
    ros.spin_until(lambda: node.done and len(ts) == len(rs) == 300)
    assert headings_from(ts, 'enu').heading_deg[7] == pytest.approx(7.0)
    assert headings_from(rs, 'enu').heading_deg[7] == pytest.approx(97.0)


def offline(bag, capsys):
    """Return the JSON that the command analyze makes of a bag."""
    norms = [part for name, value in NORMS.items() for part in ('--set', f'{name}={value}')]
    assert main(['analyze', bag, *norms, '--json', '-']) == 0
    return json.loads(capsys.readouterr().out)


def test_paused_and_remapped_and_faster_the_verdict_is_that_of_analyze(
        ros, tmp_path, capsys, rng):
    """With two runs cut by marks at the end of the file, and pauses in either."""
    marks = [('stop', T0_NS + 10 * 10 ** 9), ('start', T0_NS + 15 * 10 ** 9)]
    bag = bag_of(tmp_path / 'bag', marks, noise_deg=0.15 * rng.standard_normal(300))
    compliance = ros.ours(Compliance)
    synchronizer = ros.add(Synchronizer, cli_args=[
        '--ros-args', '-r', 'ts/heading:=gyro/heading'], parameter_overrides=make_overrides(NORMS))
    node = ros.add(Replayer, cli_args=['--ros-args', '-r', 'ts/heading:=gyro/heading'],
                   remapped=['ts/heading'], parameter_overrides=make_overrides({
                       **NORMS, 'bag': bag, 'rate': 20.0, 'clock': True, 'start_paused': True}))
    ros.spin_until(lambda: 'paused at 0.000 s' in node.state)
    assert node.published == 0
    asked(ros, 'resume')
    for at in (100, 350):
        until_published(ros, node, at)
        asked(ros, 'toggle_paused')
        before = node.published
        ticks(ros)
        assert node.published == before < 600
        asked(ros, 'toggle_paused')
    ros.spin_until(lambda: node.done)
    ros.end(node, synchronizer, compliance)
    replayed, analyzed = compliance.verdict.to_dict(), offline(bag, capsys)
    assert [run['n'] for run in analyzed['runs']] == [101, 149]
    assert BagReader(bag).topics['/ts/heading'].count == sum(
        run['pairing']['ts_received'] for run in replayed['runs'])
    assert_same(replayed, analyzed)


@pytest.mark.parametrize('loop', [False, True])
def test_where_there_is_nothing_to_replay_it_says_so_and_ends(ros, tmp_path, loop, capfd):
    node = ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), start_s=10.01, duration_s=0.05,
                    loop=loop)
    ros.spin_until(lambda: node.done)
    assert node.published == 0
    assert (f'nothing to replay: {tmp_path / "bag"} from 10.01 s to before 10.06 s has no heading'
            in capfd.readouterr().err)


def test_a_start_behind_the_end_of_the_bag_is_refused(ros, tmp_path):
    with pytest.raises(SettingsError, match=r'start_s = 31.0: .*bag is 29.900 s long'):
        ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), start_s=31.0)


@pytest.mark.parametrize('values, error, message', [
    ({}, SettingsError, 'bag is required'),
    ({'bag': 'no/such/bag'}, OSError, 'No such file'),
    ({'rate': -1.0}, SettingsError, 'rate = -1.0'),
    ({'start_s': -0.5}, SettingsError, 'start_s = -0.5: must be a number of at least 0'),
    ({'duration_s': -2.0}, SettingsError, 'duration_s = -2.0: must be a number of at least 0'),
])
def test_a_mistake_ends_the_node_before_it_begins(ros, values, error, message):
    with pytest.raises(error) as raised:
        ros.ours(Replayer, **values)
    assert message in str(raised.value)


def test_a_bag_without_the_topics_is_refused_with_those_it_has(ros, tmp_path):
    with pytest.raises(BagError, match="has no topic 'gyro'; it has /rs/heading"):
        ros.ours(Replayer, bag=bag_of(tmp_path / 'bag'), ts_topic='gyro')


NODE = ('-c', 'from heading_intercompare.nodes.replayer import main; raise SystemExit(main())',
        '--ros-args', '-p', 'rate:=0.0', '-r', 'ts/heading:=gyro/heading', '-p', 'bag:={}')
COMMAND = ('-m', 'heading_intercompare', 'replay', '{}', '--rate', '0', '--remap',
           '/ts/heading:=/gyro/heading')


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize('arguments', [NODE, COMMAND], ids=['node', 'command'])
def test_another_process_hears_it_under_the_new_name(arguments, tmp_path, monkeypatch):
    monkeypatch.setenv('ROS_DOMAIN_ID', str(take_domain()))
    monkeypatch.setenv('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    ros = Ros()
    bag = bag_of(tmp_path / 'bag')
    gyro, rs = (ros.listen(Imu, name, qos.PAIRS_TAKEN) for name in ('gyro/heading', 'rs/heading'))
    replayer = subprocess.Popen([sys.executable, *(part.format(bag) for part in arguments)],
                                stdin=subprocess.DEVNULL)
    try:
        ros.spin_until(lambda: replayer.poll() is not None)
        ros.spin_until(lambda: len(gyro) == len(rs) == 300)
        assert replayer.returncode == 0
    finally:
        replayer.kill()
        replayer.wait()
        ros.close()
