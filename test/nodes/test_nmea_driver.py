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

"""The node that turns sentences into headings."""

from __future__ import annotations

from collections import Counter
import socket
import threading
import time
from types import SimpleNamespace

from deadlines import DEADLINE_S, Stopwatch
from diagnostic_msgs.msg import DiagnosticArray
from nodes.lines import free_port, sentence
from nodes.rclpy_objects import headings_from
from nodes.ros_nodes import EITHER_EXECUTOR
import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.alerts.alert_sentences import tag
from heading_intercompare.drivers.settings import DriverError
from heading_intercompare.drivers.sources import UdpSource
from heading_intercompare.messages.ledger_messages import decode_losses
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.motion_driver import MotionDriver
from heading_intercompare.nodes.nmea_driver import NmeaDriver


def log(path, n, start='2014-08-01T00:00:', rate_hz=10):
    """Write a log of n stamped sentences that turn to starboard, 0.1 deg each."""
    path.write_text(''.join(f'{start}{i / rate_hz:09.6f}Z {sentence(round(10.0 + i / 10, 2))}'
                            for i in range(n)))
    return f'file:{path}'


@EITHER_EXECUTOR
def test_a_log_is_published_whole_with_its_stamps_and_then_the_node_is_done(ros, tmp_path):
    node = ros.ours(NmeaDriver, source=log(tmp_path / 'gyro.log', 300), speed=0.0)
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: node.done)
    ros.spin_until(lambda: len(heard) == 300)
    headings = headings_from(heard, 'enu')
    assert headings.stamp_ns.tolist() == [1406851200 * 10 ** 9 + i * 10 ** 8 for i in range(300)]
    assert headings.heading_deg.tolist() == pytest.approx([10.0 + i / 10 for i in range(300)])
    assert {m.header.frame_id for m in heard} == {'ts_heading'}


def test_a_log_is_not_begun_before_it_is_heard(ros, tmp_path):
    node = ros.ours(NmeaDriver, source=log(tmp_path / 'gyro.log', 5), speed=0.0, subscribers=2)
    first = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: ros.executor.spin_once(0.3) is None)
    assert (first, node.done) == ([], False)
    second = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN, ros.add(Node, 'second'))
    ros.spin_until(lambda: len(first) == len(second) == 5)


def test_a_log_is_played_at_its_own_pace_times_the_speed(ros, tmp_path):
    """The log lasts 8 s."""
    began_s, watch = time.monotonic(), Stopwatch()
    node = ros.ours(NmeaDriver, source=log(tmp_path / 'gyro.log', 81), speed=10.0)
    ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: node.done)
    assert time.monotonic() - began_s > 0.78 and watch.passed_s < 6.0


def test_logs_that_begin_apart_are_played_in_step_from_one_origin(ros, tmp_path):
    """The second log begins 10 s later: at 20 times the speed, half a second."""
    early = log(tmp_path / 'a.log', 30)
    late = log(tmp_path / 'b.log', 10, '2014-08-01T00:01:')
    node = ros.ours(NmeaDriver, source=late, topic='rs/heading', speed=20.0)
    assert node.first_ns == 1406851260 * 10 ** 9
    heard = ros.listen(Imu, 'rs/heading', qos.PAIRS_TAKEN)
    began_s, watch = time.monotonic(), Stopwatch()
    node.play_from(node.first_ns - 10 * 10 ** 9)
    ros.spin_until(lambda: heard)
    assert time.monotonic() - began_s > 0.48 and watch.passed_s < 5.0
    other = ros.ours(NmeaDriver, name='other', source=early, origin_ns=node.first_ns, speed=0.0)
    assert other.first_ns == 1406851200 * 10 ** 9


@EITHER_EXECUTOR
def test_sentences_over_udp_are_stamped_when_they_come(ros):
    port = free_port()
    ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', sentence='HDT')
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        before_ns = time.time_ns()
        sender.sendto(sentence(123.45).encode(), ('127.0.0.1', port))
        sent_ns = time.time_ns()
        # The node is busy elsewhere for a while: the stamp must not know.
        time.sleep(1.0)
        ros.spin_until(lambda: heard)
    headings = headings_from(heard, 'enu')
    assert before_ns <= headings.stamp_ns[0] <= sent_ns + 500_000_000
    assert headings.heading_deg[0] == pytest.approx(123.45)


def test_a_heading_has_the_stamp_of_the_kernel_when_the_reading_thread_is_late(ros, monkeypatch):
    """The thread reads a datagram 2 s after it came; a busy kernel delivers it within 1 s."""
    reads, pauses, read = threading.Event(), threading.Event(), UdpSource.read

    def read_late(self, timeout_s):
        if reads.wait(0.01):
            return read(self, timeout_s)
        pauses.set()
        return []
    monkeypatch.setattr(UdpSource, 'read', read_late)
    port = free_port()
    ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', sentence='HDT')
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        # The kernel stamps from a moment after the first socket asked for stamps.
        reads.set()
        sender.sendto(sentence(1.0).encode(), ('127.0.0.1', port))
        ros.spin_until(lambda: heard)
        reads.clear()
        pauses.clear()
        ros.spin_until(pauses.is_set)
        before_ns = time.time_ns()
        sender.sendto(sentence(123.45).encode(), ('127.0.0.1', port))
        sent_ns = time.time_ns()
        ros.spin_until(lambda: time.time_ns() > sent_ns + 2_000_000_000)
        assert len(heard) == 1
        reads.set()
        ros.spin_until(lambda: len(heard) == 2)
    stamp_ns = headings_from(heard, 'enu').stamp_ns[1]
    assert before_ns <= stamp_ns <= sent_ns + 1_000_000_000


def test_what_was_held_back_until_the_sentence_was_chosen_overruns_nobody(ros):
    """A subscription holds 1000 messages."""
    port = free_port()
    node = ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', learn_s=2.0, max_rate_hz=1000.0)
    heard = ros.listen(Imu, 'ts/heading', qos.HEADINGS_IN)
    ros.spin_until(lambda: node.count_subscribers('ts/heading'))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for first in range(0, 3000, 50):
            sender.sendto(''.join(sentence(round(0.1 * n, 1)) for n in range(
                first, first + 50)).encode(), ('127.0.0.1', port))
            ros.executor.spin_once(0.001)
    ros.spin_until(lambda: len(heard) == 3000)


def test_what_gave_no_heading_is_in_the_diagnostics_by_reason(ros, tmp_path):
    path = tmp_path / 'gyro.log'
    source = log(path, 20)
    path.write_text(f'{path.read_text()}2014-08-01T00:00:59Z {sentence("")}')
    states = ros.listen(DiagnosticArray, '/diagnostics', qos.STATUS)
    ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.ours(NmeaDriver, source=source, speed=0.0)

    def shown():
        return [{v.key: v.value for v in s.values} for m in states for s in m.status
                if s.name == 'nmea_driver: source']
    ros.spin_until(lambda: shown() and shown()[-1].get('empty_heading') == '1')
    assert shown()[-1]['published'] == '20'


def test_the_name_of_the_node_can_be_given(ros, tmp_path):
    node = ros.ours(NmeaDriver, name='rs_driver', source=log(tmp_path / 'gyro.log', 1))
    assert node.get_name() == 'rs_driver'


def test_the_end_stops_a_log_that_is_under_way(ros, tmp_path):
    node = ros.ours(NmeaDriver, source=log(tmp_path / 'gyro.log', 600))
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: len(heard) > 2)
    ros.end(node)
    assert node.ended
    assert len(heard) < 600


@pytest.mark.parametrize('values, error, message', [
    ({}, SettingsError, 'source is required: must be file:PATH'),
    ({'source': 'usb:1'}, SettingsError, "source = 'usb:1': must be file:PATH"),
    ({'source': 'file:no/such.log'}, OSError, 'No such file'),
    ({'source': 'udp://127.0.0.1:10110', 'sentense': 'HDT'}, SettingsError,
     "unknown parameter 'sentense'; did you mean 'sentence'?"),
])
def test_a_mistake_ends_the_node_before_it_begins(ros, values, error, message):
    with pytest.raises(error) as raised:
        ros.ours(NmeaDriver, **values)
    assert message in str(raised.value)


def test_an_empty_log_is_refused(ros, tmp_path):
    (tmp_path / 'empty.log').touch()
    with pytest.raises(DriverError, match='no lines'):
        ros.ours(NmeaDriver, source=f'file:{tmp_path}/empty.log')


def test_an_error_of_the_source_reaches_the_process(ros, tmp_path):
    node = ros.ours(NmeaDriver, source=log(tmp_path / 'gyro.log', 600))

    def read(timeout_s):
        raise OSError(5, 'Input/output error', 'gyro')
    node._reading.source.read = read
    ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    with pytest.raises(OSError, match='Input/output error'):
        ros.spin_until(lambda: node.done)


def losses_from(messages):
    """Return the losses in messages, each with stamp, stamp before and count, by kind."""
    rows = [(lost_as, row) for message in messages
            for lost_as, losses in decode_losses(serialize_message(message)).items()
            for row in zip(losses.stamp_ns.tolist(), losses.since_ns.tolist(),
                           losses.count.tolist())]
    return sorted(rows)


def start_udp_driver(ros):
    """Return the port, a driver that reads it, its headings, and what it says is lost."""
    port = free_port()
    node = ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', sentence='HDT')
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    lost = ros.listen(DiagnosticArray, 'ts/heading/lost', qos.LOST)
    ros.spin_until(lambda: node.count_subscribers('ts/heading/lost'))
    return port, node, heard, lost


def test_what_the_kernel_dropped_is_told_with_the_stamp_of_the_next_heading(ros):
    port, node, heard, lost = start_udp_driver(ros)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for n in range(3):
            sender.sendto(sentence(10.0 + n).encode(), ('127.0.0.1', port))
            ros.spin_until(lambda n=n: len(heard) == n + 1)
            node._reading.source.counts['kernel_dropped'] += 100 * n
    ros.end(node)
    ros.spin_until(lambda: len(lost) == 2)
    stamps = headings_from(heard, 'enu').stamp_ns.tolist()
    # The last ones were dropped after the last heading.
    assert losses_from(lost) == [('lost.at_source', (stamps[2], stamps[1], 100)),
                                 ('lost.at_source', (stamps[2], stamps[2], 200))]


def test_lines_that_come_a_second_time_and_gaps_of_their_numbers_are_told(ros):
    """Each datagram comes by two paths; then three lines are missing."""
    port, node, heard, lost = start_udp_driver(ros)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for n in [*range(1, 21), *range(24, 31)]:
            data = tag(['s:HE0001', f'n:{n}']) + sentence(10.0 + n).encode()
            for _ in range(1 + (n > 15)):
                sender.sendto(data, ('127.0.0.1', port))
    ros.spin_until(lambda: len(heard) == 27)
    ros.end(node)
    ros.spin_until(lambda: sum(row[2] for _, row in losses_from(lost)) == 15)
    counts = Counter()
    for lost_as, (_, _, n) in losses_from(lost):
        counts[lost_as] += n
    assert counts == {'rejected.repeated': 12, 'lost.at_source': 3}
    assert node._decoder.numbers.n_missing == 3


def test_a_burst_is_told_with_the_stamp_of_the_next_heading(ros):
    with socket.create_server(('127.0.0.1', 0)) as server:
        node = ros.ours(NmeaDriver, source=f'tcp://127.0.0.1:{server.getsockname()[1]}',
                        sentence='HDT')
        heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
        told = ros.listen(DiagnosticArray, 'ts/heading/lost', qos.LOST)
        server.settimeout(DEADLINE_S)
        line, _ = server.accept()
        ros.spin_until(lambda: node.count_subscribers('ts/heading/lost'))
        with line:
            line.sendall(sentence(1.0).encode())
            ros.spin_until(lambda: len(heard) == 1)
            line.sendall(''.join(sentence(2.0 + n) for n in range(4)).encode())
            ros.spin_until(lambda: node._decoder.counts.get('burst') == 4)
            line.sendall(sentence(7.0).encode())
            ros.spin_until(lambda: len(heard) == 2 and told)
    first, second = headings_from(heard, 'enu').stamp_ns.tolist()
    assert losses_from(told) == [('rejected.burst', (second, first, 4))]


def send_lines(port, first, n):
    """Send sentences to a port, and return the headings in them."""
    said = [round(10.0 + (first + at) / 10, 1) for at in range(n)]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for heading_deg in said:
            sender.sendto(sentence(heading_deg).encode(), ('127.0.0.1', port))
    return said


def test_what_a_live_source_says_before_its_subscribers_are_there_waits_for_them(ros):
    """On a loaded machine a synchronizer starts seconds later than its drivers."""
    port = free_port()
    node = ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', sentence='HDT', subscribers=2,
                    start_wait_s=60.0)
    early = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    said = send_lines(port, 0, 30)
    ros.spin_until(lambda: len(node._waiting) == 30)
    assert early == []
    late = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN, ros.add(Node, 'late'))
    ros.spin_until(lambda: len(early) == len(late) == 30)
    assert headings_from(late, 'enu').heading_deg.tolist() == pytest.approx(said)


@pytest.mark.parametrize('make, noun', [(NmeaDriver, 'heading'), (MotionDriver, 'motion')])
def test_how_long_a_source_may_be_silent_changes_while_the_driver_runs(ros, make, noun):
    node = ros.ours(make, source=f'udp://127.0.0.1:{free_port()}', first_wait_s=0.2)
    words = []
    node.health.note = lambda part, level, said, **values: words.append(said)
    ros.spin_until(lambda: f'no {noun} for more than 0.2 s; ' in ''.join(words))
    node._published = 1
    node._motion = SimpleNamespace(n_published=1, publish=bool, publishers=[])
    node.set_parameters([Parameter('stale_s', value=0.3)])
    ros.spin_until(lambda: f'no {noun} for more than 0.3 s; ' in ''.join(words))
    result, = node.set_parameters([Parameter('stale_s', value=-1.0)])
    assert not result.successful


def test_a_live_source_does_not_wait_for_ever(ros):
    port = free_port()
    ros.ours(NmeaDriver, source=f'udp://127.0.0.1:{port}', sentence='HDT', subscribers=2,
             start_wait_s=0.5)
    heard = ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    send_lines(port, 0, 30)
    ros.spin_until(lambda: len(heard) == 30)


def test_a_stamp_in_the_future_is_a_warning_with_what_to_do(ros, tmp_path):
    source = log(tmp_path / 'gyro.log', 5, start='2037-01-01T00:00:')
    node = ros.ours(NmeaDriver, source=source, speed=0.0)
    ros.listen(Imu, 'ts/heading', qos.PAIRS_TAKEN)
    ros.spin_until(lambda: 'stamps' in node.health._parts)
    assert 'in the future: the clock' in node.health._parts['stamps'].message
