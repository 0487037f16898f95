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

"""Each trouble on the running graph: raised while it happens, cleared when it ends."""

from __future__ import annotations

import socket
import time

from checksums import checksum_of
from deadlines import Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from nodes.inside_nodes import judgement_of, stream_alarms_of
import numpy as np
import pytest
from sensor_msgs.msg import Imu
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.messages.status_messages import ERROR, OK, WARN
from heading_intercompare.nodes.compliance import Compliance
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.nmea_driver import NmeaDriver
from heading_intercompare.nodes.synchronizer import Synchronizer

T0_NS = 1_700_000_000_000_000_000
RATE_HZ = 10


class Bridge:
    """The graph of a bridge, two sensors that a test plays, and the alarms told."""

    def __init__(self, ros, rng):
        self.ros, self.rng = ros, rng
        self.alarms = ros.listen(DiagnosticArray, 'compliance/alarms', qos.STATE_IN)
        self.health = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
        self.sensors = [ros.plain.create_publisher(Imu, f'{role}/heading', qos.HEADINGS_OUT)
                        for role in ('ts', 'rs')]
        self.compliance = ros.ours(Compliance, name='compliance')
        self.synchronizer = ros.ours(Synchronizer, name='synchronizer',
                                     pairing__method='interpolate')
        ros.spin_until(lambda: all(s.get_subscription_count() == 1 for s in self.sensors))
        self.at_s, self.heading_deg, self.sent = 0, 20.0, 0

    def play(self, seconds, rate_deg_s=0.0, ts=lambda true, rs: true, off_s=0.0, behind_s=1):
        """Play seconds of data as fast as they are taken, and let compliance look at each."""
        for _ in range(seconds):
            self.send(rate_deg_s, ts, off_s)
            # The newest second waits for the RS reading after it.
            self.ros.spin_until(
                lambda: self.compliance.n_pairs >= self.sent - behind_s * RATE_HZ)
            judgement_of(self.compliance).alarms.look()
        self.ros.spin_until(lambda: self.ros.executor.spin_once(0.01) is None)

    def send(self, rate_deg_s=0.0, ts=lambda true, rs: true, off_s=0.0, pace=lambda: None):
        """
        Publish a second of data; `ts` makes the readings of the TS, given the true ones.

        Before each pair of readings, `pace` waits.
        """
        t = np.arange(RATE_HZ) / RATE_HZ
        stamps = T0_NS + self.at_s * 10 ** 9 + np.rint(t * 1e9).astype(np.int64)
        true = self.heading_deg + rate_deg_s * t
        self.heading_deg += rate_deg_s
        rs = true + self.rng.normal(0.0, 0.03, RATE_HZ)
        good = ts(true + self.rng.normal(0.0, 0.05, RATE_HZ), rs)
        rows = Headings.of(stamps + round(off_s * 1e9), np.asarray(good) % 360.0), \
            Headings.of(stamps, rs % 360.0)
        for messages in zip(*(imu_messages(headings, 'x') for headings in rows)):
            pace()
            for sensor, message in zip(self.sensors, messages):
                sensor.publish(message)
        self.at_s, self.sent = self.at_s + 1, self.sent + RATE_HZ

    def state(self, name):
        """Return state and level of an alarm as last told."""
        for message in reversed(self.alarms):
            for status in message.status:
                if status.name.endswith(f': {name}'):
                    values = {pair.key: pair.value for pair in status.values}
                    return values['state'], status.level[0]
        return None

    def active(self):
        """Return the names of the alarms of compliance that are active."""
        return [name for name in ('ts_frozen', 'rs_frozen', 'rotated', 'mirrored', 'jump',
                                  'outliers', 'same_source', 'clock_step')
                if judgement_of(self.compliance).alarms.panel[name].state.active]


@pytest.fixture
def bridge(ros, rng):
    """Return the graph."""
    return Bridge(ros, rng)


def heard(bridge, name, state):
    """Wait until an alarm is told in a state."""
    bridge.ros.spin_until(lambda: (bridge.state(name) or [''])[0] == state)


def acted_out(bridge, name, during, *, seconds=4, before=20, rate_deg_s=0.0, hold_s=14):
    """Play a trouble: it must be raised within `seconds` of data, alone, and clear afterwards."""
    bridge.play(before, rate_deg_s)
    assert bridge.active() == []
    bridge.play(seconds, rate_deg_s, during)
    assert bridge.active() == [name]
    heard(bridge, name, 'active_unacknowledged')
    bridge.play(hold_s, rate_deg_s)
    assert bridge.active() == []
    heard(bridge, name, 'rectified_unacknowledged')


# `play` looks a second late, because the RS reading after a second is still to come: four seconds
# of trouble are three for the alarm.
def test_a_quarter_turn(bridge):
    acted_out(bridge, 'rotated', lambda true, rs: true + 90.0)


def test_a_jump(bridge):
    acted_out(bridge, 'jump', lambda true, rs: true - 5.0)


def test_outliers(bridge):
    acted_out(bridge, 'outliers', lambda true, rs: true + 20.0 * (np.arange(RATE_HZ) == 4),
              hold_s=20)


def test_a_mirrored_sensor(bridge):
    """From the start; after three seconds the ship turns, and at 3 deg is enough of it seen."""
    mirrored = {'ts': lambda true, rs: 50.0 - true}
    bridge.play(10, 0.0, **mirrored)
    assert 'mirrored' not in bridge.active()
    bridge.play(4, 2.0, **mirrored)
    assert bridge.active() == ['mirrored']
    bridge.play(20, 2.0)
    assert 'mirrored' not in bridge.active()
    heard(bridge, 'mirrored', 'rectified_unacknowledged')


def test_a_frozen_sensor_in_a_turn_but_not_alongside(bridge):
    """
    Frozen for 12 s alongside: no alarm. The ship turns: within some seconds of that.

    Repeated values wait for 15 s, for a logger may hold them.
    """
    bridge.play(30)
    last = bridge.heading_deg
    bridge.play(12, 0.0, lambda true, rs: np.full(RATE_HZ, last), behind_s=17)
    assert bridge.active() == []
    bridge.play(6, 2.0, lambda true, rs: np.full(RATE_HZ, last), behind_s=17)
    bridge.play(2, 2.0, lambda true, rs: np.full(RATE_HZ, last))
    assert bridge.active() == ['ts_frozen']
    heard(bridge, 'ts_frozen', 'active_unacknowledged')
    bridge.play(6, 2.0)
    assert 'ts_frozen' not in bridge.active()
    heard(bridge, 'ts_frozen', 'rectified_unacknowledged')


def test_one_source_for_both(bridge):
    """Three hundred changes of both readings, at 10 Hz half a minute, and the noise of two."""
    acted_out(bridge, 'same_source', lambda true, rs: rs, seconds=34, before=30, hold_s=40)


def test_a_turn_raises_nothing_even_if_the_ts_is_late(bridge):
    """At 3 deg/s a second late: 3 deg, sixty times the errors."""
    shown = []

    def late(true, rs):
        shown.append(true)
        return shown[max(0, len(shown) - 2)]
    bridge.play(30, 0.0, late)
    for rate_deg_s in (3.0, 0.0, -3.0, 0.0):
        bridge.play(15, rate_deg_s, late)
        assert bridge.active() == []


def run_in_time(bridge, seconds, **how):
    """Play seconds of data at the pace of the clock; the nodes look by themselves."""
    next_s = time.monotonic()

    def pace():
        nonlocal next_s
        next_s += 1.0 / RATE_HZ
        bridge.ros.spin_until(lambda: time.monotonic() >= next_s)
    for _ in range(seconds):
        bridge.send(**how, pace=pace)


@pytest.mark.slow
def test_a_clock_that_steps_is_raised_by_the_synchronizer(bridge):
    """A step of 2 s: the pairs could show it only by the motion of the ship, after minutes."""
    run_in_time(bridge, 8)
    assert bridge.state('clock_step')[0] == 'normal'
    run_in_time(bridge, 4, off_s=2.0)
    assert stream_alarms_of(bridge.synchronizer).panel['clock_step'].state.active
    heard(bridge, 'clock_step', 'active_unacknowledged')


@pytest.mark.slow
def test_the_nodes_look_by_themselves_within_3_s(bridge):
    run_in_time(bridge, 5)
    watch = Stopwatch()
    while 'rotated' not in bridge.active():
        run_in_time(bridge, 1, ts=lambda true, rs: true + 90.0)
        assert watch.passed_s < 4.5
    heard(bridge, 'rotated', 'active_unacknowledged')


def test_a_silent_sensor_is_raised_and_cleared_by_the_synchronizer(bridge):
    bridge.play(3)
    panel = stream_alarms_of(bridge.synchronizer).panel
    bridge.ros.spin_until(lambda: panel['ts_silent'].state.active)
    heard(bridge, 'ts_silent', 'active_unacknowledged')

    def goes_on():
        bridge.send()
        bridge.ros.spin_until(lambda: bridge.ros.executor.spin_once(0.1) is None)
        return not panel['ts_silent'].state.active
    bridge.ros.spin_until(goes_on)


def test_an_alarm_is_acknowledged_by_its_name_or_all_at_once(bridge, ros):
    """On the topic `compliance/acknowledge` one of them; by the service all, of every node."""
    bridge.play(20)
    bridge.play(4, 0.0, lambda true, rs: true + 90.0)
    heard(bridge, 'rotated', 'active_unacknowledged')
    assert bridge.state('rotated')[1] == ERROR
    acknowledge = ros.plain.create_publisher(String, 'compliance/acknowledge', qos.ACKNOWLEDGE)
    ros.spin_until(lambda: acknowledge.get_subscription_count() == 2)
    acknowledge.publish(String(data='compliance: rotated'))
    heard(bridge, 'rotated', 'active_acknowledged')
    assert bridge.state('rotated')[1] == WARN
    ros.spin_until(lambda: stream_alarms_of(bridge.synchronizer).panel['rs_silent'].state.active)
    client = ros.plain.create_client(Trigger, 'compliance/acknowledge')
    ros.spin_until(client.service_is_ready)
    done = client.call_async(Trigger.Request())
    ros.spin_until(done.done)
    assert done.result().success
    heard(bridge, 'rs_silent', 'active_acknowledged')
    bridge.play(8)
    heard(bridge, 'rotated', 'normal')
    assert bridge.state('rotated')[1] == OK


def test_alarms_are_on_diagnostics_and_leave_the_verdict_alone(bridge, ros):
    bridge.play(20)
    bridge.play(4, 0.0, lambda true, rs: true + 90.0)

    def shown():
        return any(s.name == 'compliance: alarms' and s.level[0] == ERROR
                   and 'rotated' in s.message for m in bridge.health for s in m.status)
    ros.spin_until(shown)
    assert bridge.compliance.verdict is None


def sentence(heading, talker='HE', damaged=False):
    """Return an HDT sentence."""
    body = f'{talker}HDT,{heading:.1f},T'
    return f'${body}*{checksum_of(body) ^ damaged:02X}\r\n'.encode()


class Line:
    """A driver on UDP, and what is sent to it."""

    def __init__(self, ros):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(('127.0.0.1', 0))
            self.port = probe.getsockname()[1]
        self.ros, self.next_s = ros, 0.0
        self.alarms = ros.listen(DiagnosticArray, 'compliance/alarms', qos.STATE_IN)
        self.driver = ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{self.port}', learn_s=0.0)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    def send_from(self, host, data):
        """Send a sentence from another address."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            sender.bind((host, 0))
            sender.sendto(data, ('127.0.0.1', self.port))

    def send_until(self, condition, *more):
        """Send a good sentence and more, ten times a second, until a condition holds; time it."""
        def step():
            if time.monotonic() >= self.next_s:
                self.next_s = time.monotonic() + 0.1
                for data in (sentence(90.0), *more):
                    self.socket.sendto(data, ('127.0.0.1', self.port))
            return condition()
        watch = Stopwatch()
        self.ros.spin_until(step)
        return watch.passed_s


def test_a_second_sender_of_the_same_talker_is_named(ros):
    line = Line(ros)
    try:
        panel = line.driver.alarms.panel
        line.send_until(lambda: line.driver._published > 5)
        assert not panel['second_sender'].state.active

        def forge():
            line.send_from('127.0.0.2', sentence(87.0))
            return panel['second_sender'].state.active
        assert line.send_until(forge) < 3.5
        assert '127.0.0.1' in (words := panel['second_sender'].words) and '127.0.0.2' in words
    finally:
        line.socket.close()


@pytest.mark.parametrize('name, more', [
    ('checksum', sentence(90.0, damaged=True)),
    pytest.param('second_talker', sentence(91.0, 'GP'), marks=pytest.mark.endurance)])
def test_a_flood_of_bad_checksums_and_a_second_talker(ros, name, more):
    line = Line(ros)
    try:
        panel = line.driver.alarms.panel
        line.send_until(lambda: line.driver._published > 5)
        assert not panel[name].state.active
        assert line.send_until(lambda: panel[name].state.active, more) < 3.5
        ros.spin_until(lambda: any(s.name == f'nmea_driver: {name}' and s.level[0] != OK
                                   for m in line.alarms for s in m.status))
        line.send_until(lambda: not panel[name].state.active)
    finally:
        line.socket.close()
