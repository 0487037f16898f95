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

"""The node that pairs."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import QuaternionStamped, TwistStamped
from nodes.inside_nodes import pairer_of, stream_alarms_of
from nodes.rclpy_objects import (
    heading_messages,
    headings_from,
    ledger_from,
    marker_message,
    pairs_from,
)
from nodes.ros_nodes import EITHER_EXECUTOR
import numpy as np
import pytest
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.pairer import pair
from heading_intercompare.core.records import Headings, Losses
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import IMU, imu_messages
from heading_intercompare.messages.ledger_messages import encode_losses
from heading_intercompare.messages.status_messages import encode_mark
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.interface.message_types import PAIRS_TYPES
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.synchronizer import Synchronizer
from heading_intercompare.nodes.taking.intake import Intake

T0_NS = 1_700_000_000_000_000_000


def fates(ledger):
    """Return the counts of pairs and readings, without those of steps and gaps."""
    return {key: n for key, n in ledger.total.counts.items()
            if key.stream or key is LedgerKey.PAIRED}


def stream(rng, rate_hz, span_s, offset_ns=0):
    """Return readings at a rate, headings near north so that they wrap."""
    n = int(rate_hz * span_s)
    stamps = T0_NS + offset_ns + (np.arange(n) * (1e9 / rate_hz)).astype(np.int64)
    return Headings.as_sent(stamps, (rng.normal(0.0, 1.0, n)) % 360.0)


def graph(ros, **values):
    """Return a synchronizer, publishers of its inputs, and what it publishes."""
    pairs = ros.listen(TwistStamped, 'pairs', qos.PAIRS_TAKEN)
    ledgers = ros.listen(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    sensors = [ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
               for role in ('ts', 'rs')]
    node = ros.ours(Synchronizer, **values)
    ros.spin_until(lambda: all(s.get_subscription_count() == 1 for s in sensors))
    return node, sensors, pairs, ledgers


def send(publisher, headings):
    """Publish headings."""
    for message in heading_messages(headings, 'x'):
        publisher.publish(message)


def arrived(headings):
    """Return headings as their messages carry them."""
    return headings_from(heading_messages(headings, 'x'), 'enu')


def finish(ros, node, sensors, ledgers):
    """End the synchronizer as its process would; return the final ledger."""
    for sensor in sensors:
        ros.plain.destroy_publisher(sensor)
    ros.end(node)
    ros.spin_until(lambda: ledgers and ledger_from(ledgers[-1])[1])
    return ledger_from(ledgers[-1])[0]


@EITHER_EXECUTOR
def test_live_pairs_are_those_of_the_pure_pairer_to_the_bit(ros, rng):
    node, sensors, pairs, ledgers = graph(ros)
    ts, rs = stream(rng, 10.0, 20.0, 13_000_000), stream(rng, 4.0, 20.0)
    for lo in range(0, 200, 20):
        send(sensors[0], ts[lo:lo + 20])
        send(sensors[1], rs[lo * 2 // 5:(lo + 20) * 2 // 5])
        ros.spin_until(lambda: node.executor is not None and ros.executor.spin_once(0.01) is None)
    ledger = finish(ros, node, sensors, ledgers)
    expected, pure = pair(arrived(ts), arrived(rs), Settings())
    ros.spin_until(lambda: len(pairs) >= len(expected))
    assert pairs_from(pairs) == expected
    assert ledger.total.counts == pure.total.counts
    assert ledger.segments == pure.segments


def test_one_stream_ahead_of_the_other_changes_nothing(ros, rng):
    node, sensors, pairs, ledgers = graph(ros)
    ts, rs = stream(rng, 10.0, 5.0, 7), stream(rng, 10.0, 5.0)
    send(sensors[0], ts)
    ros.spin_until(lambda: ros.executor.spin_once(0.05) is None)
    send(sensors[1], rs)
    finish(ros, node, sensors, ledgers)
    expected, _ = pair(arrived(ts), arrived(rs), Settings())
    ros.spin_until(lambda: len(pairs) >= len(expected))
    assert pairs_from(pairs) == expected


def test_a_recorder_that_replaces_its_subscription_does_not_stand_for_compliance(ros):
    """It had two for a while. So the inputs were opened, and 189 readings never came."""
    node = ros.ours(Synchronizer, subscribers=2, startup_wait_s=600.0)
    recorder, other = ros.add(Node, 'recorder'), ros.add(Node, 'compliance')
    outlet, = node._outlets.values()
    for one in (recorder, recorder):
        one.create_subscription(TwistStamped, 'pairs', lambda _: None, qos.PAIRS_TAKEN)
    ros.spin_until(lambda: outlet._pairs.get_subscription_count() == 2)
    for _ in range(20):
        ros.executor.spin_once(0.02)
    assert not node._opened
    other.create_subscription(TwistStamped, 'pairs', lambda _: None, qos.PAIRS_TAKEN)
    ros.spin_until(lambda: node._opened)


def test_a_burst_of_pairs_does_not_overrun_who_takes_them(ros, rng):
    """The RS comes late: 2500 pairs at once, of which a subscription keeps 1000."""
    heard = ros.add(Node, 'taker')
    intake = Intake(heard, 'pairs', PAIRS_TYPES, qos.PAIRS_TAKEN, Health(heard))
    every(heard, 0.05, intake.take)
    node, sensors, _, ledgers = graph(ros)
    ts, rs = stream(rng, 100.0, 25.0), stream(rng, 10.0, 25.1)
    for lo in range(0, len(ts), 500):
        send(sensors[0], ts[lo:lo + 500])
        ros.spin_until(lambda lo=lo: pairer_of(node).ledger.total.received('ts') == lo + 500)
    send(sensors[1], rs)
    finish(ros, node, sensors, ledgers)
    ros.spin_until(lambda: intake.received == 2500)
    assert intake.lost == 0


def test_a_reading_without_a_partner_is_given_up_after_the_wait(ros, rng):
    _, sensors, _, ledgers = graph(ros, pairing__max_wait_s=0.2, pairing__silent_wait_s=0.0)
    send(sensors[0], stream(rng, 10.0, 2.0))
    # The last two of twenty are less than 0.2 s older than what came last.
    ros.spin_until(lambda: ledgers and ledger_from(ledgers[-1])[0].total.counts.get(
        'ts_unpaired') == 18)


@pytest.mark.slow
def test_a_driver_that_lags_costs_no_pair_and_is_named_as_overload(ros, rng):
    """The RS goes on at half its pace."""
    node, sensors, _, ledgers = graph(ros, pairing__method='interpolate',
                                      pairing__max_wait_s=0.2)
    both, sent = (stream(rng, 10.0, 4000.0, 13_000_000), stream(rng, 10.0, 4000.0)), [0, 0]

    def go_on(rs=1):
        ros.spin_until(lambda: ros.executor.spin_once(0.02) is None)
        for at, n in ((0, 2), (1, rs)):
            send(sensors[at], both[at][sent[at]:sent[at] + n])
            sent[at] += n
    while len(ledgers) < 8:
        go_on(rs=2)
    alarms = stream_alarms_of(node).panel
    while not alarms['overload'].state.active:
        go_on()
        assert sent[0] < 40_000
    assert alarms['overload'].words.startswith('overload: the readings of the RS lag')
    assert not alarms['clock_step'].state.active
    send(sensors[1], both[1][sent[1]:sent[0]])
    expected, pure = pair(*(arrived(headings[:sent[0]]) for headings in both),
                          Settings.from_mapping({'pairing.method': 'interpolate'}))
    ros.spin_until(lambda: pairer_of(node).ledger.paired >= len(expected) - 3)
    ledger = finish(ros, node, sensors, ledgers)
    assert ledger.paired == len(expected) and ledger.total.counts == pure.total.counts


def test_the_ledger_comes_every_second_and_its_last_one_is_final(ros, rng):
    node, sensors, _, ledgers = graph(ros)
    ros.spin_until(lambda: len(ledgers) >= 2)
    assert not ledger_from(ledgers[-1])[1]
    send(sensors[0], stream(rng, 10.0, 1.0))
    ledger = finish(ros, node, sensors, ledgers)
    assert fates(ledger) == {'ts_unpaired': 10}
    assert ledger.newest_ns == T0_NS + 900_000_000


def test_rejected_readings_are_counted_by_reason(ros):
    node, sensors, _, ledgers = graph(ros)
    send(sensors[0], Headings.as_sent([T0_NS, T0_NS, 0, T0_NS + 1], [1.0, 2.0, 3.0, np.nan]))
    ledger = finish(ros, node, sensors, ledgers)
    assert fates(ledger) == {
        'ts_rejected.invalid': 1, 'ts_rejected.no_stamp': 1,
        'ts_rejected.stamp_not_increasing': 1, 'ts_unpaired': 1}


def test_a_mark_of_either_kind_opens_a_segment_as_offline(ros, rng):
    marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
    node, sensors, _, ledgers = graph(ros)
    marker.publish(marker_message('start', T0_NS + 450_000_000))
    marker.publish(marker_message('stop', T0_NS + 700_000_000))
    ros.spin_until(lambda: ledgers and len(ledger_from(ledgers[-1])[0].segments) == 3)
    send(sensors[0], stream(rng, 10.0, 1.0))
    ledger = finish(ros, node, sensors, ledgers)
    first, second, third = ledger.segments
    assert (second.start_ns, third.start_ns) == (T0_NS + 450_000_001, T0_NS + 700_000_001)
    assert [s.counts['ts_unpaired'] for s in (first, second, third)] == [5, 3, 2]


def test_inputs_open_only_when_somebody_takes_the_pairs(ros):
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    node = ros.ours(Synchronizer)
    ros.spin_until(lambda: ros.executor.spin_once(0.2) is None)
    assert sensor.get_subscription_count() == 0
    assert node.count_publishers('ts/heading') == 1
    ros.listen(TwistStamped, 'pairs', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)


def test_inputs_open_without_a_taker_after_the_startup_wait(ros):
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    ros.ours(Synchronizer, startup_wait_s=0.3)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)


def test_the_convention_of_an_input_is_honoured(ros):
    pairs = ros.listen(TwistStamped, 'pairs', qos.PAIRS_TAKEN)
    ts = ros.plain.create_publisher(QuaternionStamped, 'compass', qos.HEADINGS_OUT)
    rs = ros.plain.create_publisher(Imu, 'rs/heading', qos.HEADINGS_OUT)
    ros.ours(Synchronizer, ts_topic='compass', ts_convention='ned',
             pairing__method='interpolate')
    ros.spin_until(lambda: all(p.get_subscription_count() == 1 for p in (ts, rs)))
    # The first second of a stream is held.
    for second in (100, 101, 102):
        north_ned = QuaternionStamped()
        north_ned.header.stamp.sec = second
        ts.publish(north_ned)
        send(rs, Headings.as_sent([second * 10 ** 9], [1.0]))
    ros.spin_until(lambda: pairs)
    assert pairs_from(pairs).ts_deg[0] == pytest.approx(0.0)
    assert pairs_from(pairs).rs_deg[0] == pytest.approx(1.0)


def test_a_wrong_setting_ends_the_node_before_it_begins(ros):
    with pytest.raises(SettingsError, match='unknown parameter'):
        ros.ours(Synchronizer, tolerance_s=0.1)


def pairing_states(ros):
    """Return a function that gives level, words and figures of the part `pairing`, newest last."""
    heard = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    return lambda: [(s.level, s.message, {v.key: v.value for v in s.values}) for m in heard
                    for s in m.status if s.name == 'synchronizer: pairing']


@pytest.mark.parametrize('who', [0, 1])
@pytest.mark.parametrize('rows', [[122], [0], [200, 201]])
def test_a_stamp_an_hour_ahead_costs_only_its_reading(ros, rng, who, rows):
    """Of 400 readings 399 are used, and the pairs are those of the recording."""
    node, sensors, pairs, ledgers = graph(ros, pairing__method='interpolate')
    both = [stream(rng, 10.0, 40.0), stream(rng, 10.0, 40.0)]
    stamps = both[who].stamp_ns.copy()
    stamps[rows] += 3600 * 10 ** 9
    both[who] = Headings.as_sent(stamps, both[who].heading_deg)
    for lo in range(0, 400, 20):
        for sensor, headings in zip(sensors, both):
            send(sensor, headings[lo:lo + 20])
        ros.spin_until(lambda lo=lo: pairer_of(node).ledger.total.received('rs') == lo + 20
                       == pairer_of(node).ledger.total.received('ts'))
    ledger = finish(ros, node, sensors, ledgers)
    expected, pure = pair(*map(arrived, both), Settings.from_mapping(
        {'pairing.method': 'interpolate'}))
    ros.spin_until(lambda: len(pairs) >= len(expected))
    assert pairs_from(pairs) == expected
    assert ledger.segments == pure.segments
    rejected = ledger.total.rejected(('ts', 'rs')[who])
    assert rejected == {'jump': len(rows)} and len(expected) >= 400 - len(rows)


def test_a_ts_clock_an_hour_off_is_told_in_words(ros, rng):
    states = pairing_states(ros)
    _, sensors, _, _ = graph(ros, pairing__max_wait_s=0.2)
    hour_ns = 3600 * 10 ** 9
    both = stream(rng, 10.0, 60.0, hour_ns), stream(rng, 10.0, 60.0)
    sent = [0]

    def told():
        if sent[0] < 600 and ros.executor.spin_once(0.02) is None:
            for sensor, headings in zip(sensors, both):
                send(sensor, headings[sent[0]:sent[0] + 2])
            sent[0] += 2
        return any(words.startswith(
            'the stamps of TS and RS lie 3600.0 s apart: nothing can be paired')
            for _, words, _ in states())
    ros.spin_until(told)
    level, _, figures = states()[-1]
    assert level == DiagnosticStatus.WARN
    assert float(figures['paired_share']) == 0.0
    assert float(figures['offset_s']) == pytest.approx(3600.0, abs=1.0)


def test_a_sound_pairing_shows_its_share_and_offset(ros, rng):
    states = pairing_states(ros)
    _, sensors, _, _ = graph(ros, pairing__method='interpolate')
    for sensor in sensors:
        send(sensor, stream(rng, 10.0, 20.0))
    ros.spin_until(lambda: any('paired_share' in f for _, _, f in states()))
    level, words, figures = next(state for state in states() if 'paired_share' in state[2])
    assert (level, words) == (DiagnosticStatus.OK, 'pairing')
    assert float(figures['offset_s']) == 0.0


def test_readings_held_for_a_jump_are_pending_and_do_not_let_others_expire(ros, rng):
    """After a silence of 2 h five seconds of stamps are held."""
    node, sensors, pairs, ledgers = graph(ros, pairing__method='interpolate',
                                          pairing__max_wait_s=1.0)
    before = stream(rng, 10.0, 5.0)
    after = stream(rng, 10.0, 6.0, 7200 * 10 ** 9)
    for sensor in sensors:
        send(sensor, before)
        send(sensor, after[:40])
    ros.spin_until(lambda: ledgers and ledger_from(ledgers[-1])[0].total.counts.get(
        'ts_pending', 0) >= 40)
    for sensor in sensors:
        send(sensor, after[40:])
    ros.spin_until(lambda: len(pairs) == 110)
    ledger = finish(ros, node, sensors, ledgers)
    assert fates(ledger) == {'paired': 110, 'ts_paired': 110, 'rs_used': 110}


def test_a_clock_set_back_is_told_in_words_and_in_the_ledger(ros, rng):
    states = pairing_states(ros)
    node, sensors, _, ledgers = graph(ros, pairing__method='interpolate')
    for sensor in sensors:
        send(sensor, stream(rng, 10.0, 20.0))
        send(sensor, stream(rng, 10.0, 20.0, -3580 * 10 ** 9))
    words = ('the clock of the TS was set back by 3600.0 s at 2023-11-14 22:13:39.900 UTC; the '
             'clock of the RS was set back by 3600.0 s at 2023-11-14 22:13:39.900 UTC')
    ros.spin_until(lambda: any(said == words for _, said, _ in states()))
    ledger = finish(ros, node, sensors, ledgers)
    assert [(step.stream, step.size_ns) for step in ledger.all_set_backs] == [
        ('ts', 3600 * 10 ** 9), ('rs', 3600 * 10 ** 9)]
    assert ledger.total.rejected('ts') == {}
    assert [part.paired for part in ledger.clock_segments] == [200, 400]


def big_endian(message):
    """Return an Imu message as a computer with the other byte order sends it."""
    typesys = pytest.importorskip('rosbags.typesys')
    store = typesys.get_typestore(typesys.Stores.ROS2_JAZZY)
    return bytes(store.serialize_cdr(store.deserialize_cdr(message, IMU), IMU,
                                     little_endian=False))


def test_either_byte_order_is_paired_and_other_encodings_are_counted(ros, rng):
    """Of ten readings three are in parameter lists or XCDR2, and the other ones big-endian."""
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    node, sensors, pairs, ledgers = graph(ros)
    headings = stream(rng, 10.0, 1.0)
    for i, message in enumerate(imu_messages(headings, 'x')):
        foreign = {3: b'\0\3', 5: b'\0\7', 8: b'\0\x0b'}.get(i)
        sensors[0].publish(big_endian(message) if foreign is None else foreign + message[2:])
        sensors[1].publish(message)
    ros.spin_until(lambda: any(
        s.message == '3 messages refused: sensor_msgs/msg/Imu message does not start as CDR'
        and {v.key: v.value for v in s.values}['refused'] == '3'
        for m in states for s in m.status if s.name == 'synchronizer: ts/heading lost'))
    ledger = finish(ros, node, sensors, ledgers)
    assert ledger.total.received('ts') == 7 and ledger.total.received('rs') == 10
    sound = np.delete(np.arange(10), [3, 5, 8])
    ros.spin_until(lambda: len(pairs) == len(sound))
    assert pairs_from(pairs).ts_deg.tolist() == arrived(headings).heading_deg[sound].tolist()


def test_a_mark_that_cannot_be_read_is_counted_and_changes_nothing(ros):
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    node, _, _, _ = graph(ros)
    marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
    ros.spin_until(lambda: marker.get_subscription_count() == 1)
    marker.publish(b'\0\7' + encode_mark('start', T0_NS)[2:])
    ros.spin_until(lambda: any(s.message.startswith('1 messages refused: diagnostic_msgs/msg/')
                               for m in states for s in m.status))
    assert len(pairer_of(node).ledger.segments) == 1


def test_messages_lost_on_the_way_are_in_the_ledger_at_the_reading_after_them(
        ros, rng, monkeypatch):
    """The subscription keeps the last ten: of 30 messages that it is not there for, 20 go."""
    monkeypatch.setattr(qos, 'HEADINGS_UNRELIABLE', QoSProfile(
        depth=10, reliability=ReliabilityPolicy.BEST_EFFORT))
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_UNRELIABLE)
    marker = ros.plain.create_publisher(DiagnosticArray, 'compliance/marker', qos.MARKER)
    ros.listen(TwistStamped, 'pairs', qos.PAIRS_TAKEN)
    ledgers = ros.listen(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    node = ros.ours(Synchronizer)
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)
    headings = stream(rng, 10.0, 4.0)
    marker.publish(marker_message('start', int(headings.stamp_ns[30]) - 1))
    for lo, hi in ((0, 5), (5, 35), (35, 40)):
        send(sensor, headings[lo:hi])
        last = int(headings.stamp_ns[hi - 1])
        ros.spin_until(lambda last=last: pairer_of(node).ledger.newest_ns == last)
    ledger = finish(ros, node, [sensor], ledgers)
    # The first one after the gap is number 25, before the mark.
    assert [s.lost('ts') for s in ledger.segments] == [{'on_the_way': 20}, {}]
    total = ledger.total
    assert total.received('ts') + total.lost('ts')['on_the_way'] == 40


def test_what_a_driver_lost_is_in_the_ledger(ros, rng):
    told = ros.plain.create_publisher(DiagnosticArray, 'rs/heading/lost', qos.LOST)
    node, sensors, _, ledgers = graph(ros)
    ros.spin_until(lambda: told.get_subscription_count() == 1)
    send(sensors[1], stream(rng, 10.0, 1.0))
    told.publish(deserialize_message(encode_losses({
        'lost.at_source': Losses.of([T0_NS], [0], [7]),
        'rejected.burst': Losses.of([T0_NS], [0], [3])}), DiagnosticArray))
    ros.spin_until(lambda: pairer_of(node).ledger.total.lost('rs')
                   and pairer_of(node).ledger.total.received('rs') == 13)
    ledger = finish(ros, node, [*sensors, told], ledgers)
    assert fates(ledger) == {'rs_lost.at_source': 7, 'rs_rejected.burst': 3,
                                   'rs_unused': 10}


@EITHER_EXECUTOR
def test_what_was_sent_before_the_synchronizer_listened_has_a_row(ros, rng):
    sensors = [ros.plain.create_publisher(Imu, f'{role}/heading', QoSProfile(depth=5000))
               for role in ('ts', 'rs')]
    headings = stream(rng, 10.0, 20.0)
    send(sensors[0], headings[:120])
    pairs = ros.listen(TwistStamped, 'pairs', qos.PAIRS_TAKEN)
    ledgers = ros.listen(DiagnosticArray, 'pairs/ledger', qos.LEDGER)
    node = ros.ours(Synchronizer)
    ros.spin_until(lambda: all(s.get_subscription_count() == 1 for s in sensors))
    send(sensors[0], headings[120:])
    send(sensors[1], headings)
    ledger = finish(ros, node, sensors, ledgers)
    assert ledger.total.lost('ts') == {'before_start': 120} and ledger.total.lost('rs') == {}
    assert ledger.paired == 80
    ros.spin_until(lambda: len(pairs) == 80)
    inside = ledger.count_between(int(headings.stamp_ns[120]), int(headings.stamp_ns[-1]))
    assert inside.lost('ts') == {}
