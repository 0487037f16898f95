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

"""The recorder as a process of its own, at a thousand headings per second and sensor."""

from __future__ import annotations

import signal
import subprocess
import sys

from nodes.launch_files import make_environment, Node
from nodes.processes import Processes
import numpy as np
import pytest
from ros_domain import DOMAIN

from heading_intercompare.bags.rosbag2.bag_reader import BagReader

pytestmark = pytest.mark.process

TOPICS = ('/ts/heading', '/rs/heading')
RATE_HZ = 1000

SENDER = """
import sys, time
import numpy as np, rclpy
from sensor_msgs.msg import Imu
from heading_intercompare.messages.heading_messages import encode_imu
from heading_intercompare.core.records import Headings
from heading_intercompare.nodes.interface import qos

count, rate_hz, *topics = int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]
rclpy.init()
node = rclpy.create_node('sender')
publishers = [node.create_publisher(Imu, topic, qos.HEADINGS_OUT) for topic in topics]
stamp_ns = 10 ** 18 + np.arange(count) * (10 ** 9 // rate_hz)
readings = Headings.as_sent(stamp_ns, np.full(count, 90.0))
messages = [row.tobytes() for row in encode_imu(readings, 'x')]
until_s = time.monotonic() + 120.0
while min(p.get_subscription_count() for p in publishers) < 1:
    if time.monotonic() > until_s:
        raise SystemExit('nobody listens')
    time.sleep(0.01)
began_s, sent = time.monotonic(), 0
while sent < count:
    due = min(count, int((time.monotonic() - began_s) * rate_hz) + 1)
    for message in messages[sent:due]:
        for publisher in publishers:
            publisher.publish(message)
    sent = due
    time.sleep(0.0005)
print('sent', flush=True)
sys.stdin.read()
"""


@pytest.fixture
def recording(tmp_path):
    """Return the processes of a recorder, and the folder of its bag."""
    processes = Processes(tmp_path)
    processes.start(Node('heading_intercompare', 'recorder', '/',
                         [{'output': str(tmp_path / 'bag')}], 'screen', 'recorder'))
    yield processes, tmp_path / 'bag'
    processes.reap()


def sender(count: int) -> subprocess.Popen:
    """Start to send to both topics; the process stays until its input is closed."""
    return subprocess.Popen(
        [sys.executable, '-c', SENDER, str(count), str(RATE_HZ), *TOPICS],
        env=make_environment(DOMAIN), stdin=subprocess.PIPE, stdout=subprocess.PIPE)


def stamps(bag) -> dict[str, np.ndarray]:
    """Return the stamps of all headings by topic."""
    parts = list(BagReader(bag).headings(dict.fromkeys(TOPICS, 'enu')))
    return {topic: np.concatenate([part[topic].stamp_ns for part in parts]) for topic in TOPICS}


def test_a_thousand_a_second_of_each_sensor_are_recorded_and_losses_counted(recording):
    processes, bag = recording
    count = 3000
    with sender(count) as sending:
        assert sending.stdout.readline() == b'sent\n'
        # Best effort may lose under load; what it loses it says.
        processes.signal(signal.SIGINT)
        sending.stdin.close()
        processes.wait('recorder')
    reader = BagReader(bag)
    assert reader.incomplete is None
    said, found = reader.metadata()['recording'], stamps(bag)
    for topic in TOPICS:
        kept, lost = len(found[topic]), int(said[f'lost_on_the_way.{topic}'])
        assert int(said[f'received.{topic}']) == kept
        assert int(said[f'not_written.{topic}']) == 0
        assert kept + lost == count
        assert kept > count / 2
