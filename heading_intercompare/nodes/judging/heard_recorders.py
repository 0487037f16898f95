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

"""What the recorders of a graph say of their bags, for the verdict."""

from __future__ import annotations

from contextlib import suppress
import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from heading_intercompare.bags.recording.part_states import DIAGNOSTICS_TOPIC
from heading_intercompare.bags.recording.recorder_losses import BAG_PART, CHAIN_SHA256
from heading_intercompare.core.verdict.verdict_document import RecordedChunks
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import decode_statuses, Status
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.batches import take_all, Unwatched
from heading_intercompare.nodes.taking.vouchers import Vouchers

#: Bags in messages of others must not fill the memory.
_MOST_BAGS = 100


class HeardRecorders:
    """
    The hash chains of the bags that recorders in the namespace of a node write.

    A recorder says its chain on /diagnostics once a second. One whose name another node took, and
    that was started later, is not heard.
    """

    def __init__(self, node: Node, health: Health) -> None:
        self._namespace, self._vouchers = node.get_namespace().strip('/'), Vouchers()
        self._recordings: dict[str, RecordedChunks] = {}
        # Taken once a second: to wake for each message would cost more than all else here.
        self._heard = node.create_subscription(
            DiagnosticArray, DIAGNOSTICS_TOPIC, lambda message: None, qos.DIAGNOSTICS_IN,
            raw=True, callback_group=Unwatched(),
            event_callbacks=health.of_subscription(DIAGNOSTICS_TOPIC))
        health.add_refresher(self._take)

    @property
    def recordings(self) -> tuple[RecordedChunks, ...]:
        """Return what was heard of each bag last, in the order of the first message of each."""
        self._take()
        return tuple(self._recordings.values())

    def _take(self) -> None:
        for data, _ in take_all(self._heard):
            if CHAIN_SHA256.encode() not in data:
                continue
            # Others may publish what they like; what cannot be read says nothing.
            with suppress(MessageError):
                _, statuses = decode_statuses(data)
                self._vouchers.hear(statuses, time.monotonic())
                for status in statuses:
                    self._take_status(status)

    def _take_status(self, status: Status) -> None:
        """Take the state of a bag from a recorder of this graph."""
        name, _, part = status.name.rpartition(': ')
        if part != BAG_PART or name.rpartition('/')[0] != self._namespace or (
                not self._vouchers.vouch(status.owner)):
            return
        with suppress(KeyError, ValueError):
            recording = RecordedChunks(status.values['path'], int(status.values['chain_chunks']),
                                       status.values[CHAIN_SHA256])
            if recording.path in self._recordings or len(self._recordings) < _MOST_BAGS:
                self._recordings[recording.path] = recording
