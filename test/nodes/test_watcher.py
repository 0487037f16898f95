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

"""The node whose view the terminal shows; what it hears is tested with the dashboard."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import Imu

from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import imu_messages
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.watcher import Watcher

T0_NS = 1_700_000_000_000_000_000


def test_a_watcher_without_a_synchronizer_or_norms_hears_headings_once_it_is_opened(ros):
    sensor = ros.plain.create_publisher(Imu, 'ts/heading', qos.HEADINGS_OUT)
    watcher = ros.add(Watcher)
    ros.spin_until(lambda: [node.name for node in watcher.view().nodes] == ['watcher'])
    # It is not among the subscribers that a log waits for.
    assert sensor.get_subscription_count() == 0
    watcher.open()
    ros.spin_until(lambda: sensor.get_subscription_count() == 1)
    readings = Headings.of(T0_NS + np.arange(5) * 10 ** 8, np.full(5, 20.5))
    for message in imu_messages(readings, 'x'):
        sensor.publish(message)
    ros.spin_until(lambda: watcher.view().ts.heading_deg == pytest.approx(20.5))
    assert watcher.view().rs.age_s is None
    assert watcher.view().validity.words == 'not known: the compliance node is not heard'
    ros.end(watcher)
    assert watcher.ended
