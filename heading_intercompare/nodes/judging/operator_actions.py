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

"""What an operator asks of a graph: start or stop a run, acknowledge, keep a note."""

from __future__ import annotations

from concurrent.futures import Future
from functools import partial
from queue import SimpleQueue
from typing import Any

from diagnostic_msgs.srv import AddDiagnostics
from rclpy.node import Node
from std_msgs.msg import String

from heading_intercompare.bags.rosbag2.provenance import NOTE_TOPIC
from heading_intercompare.messages.authors import sign_text
from heading_intercompare.messages.status_messages import encode_text
from heading_intercompare.nodes.alarms.alarm_panel import ACKNOWLEDGE_TOPIC
from heading_intercompare.nodes.interface import qos
from heading_intercompare.nodes.spinning.clocks import every

_PERIOD_S = 0.05

OPERATOR_SERVICE = 'compliance/operator_action'
"""
The service of the node that judges which also takes the name of the operator.

Its type, of another purpose, is the only standard one that takes a text and answers with one.
"""


class OperatorActions:
    """
    Asks the nodes concerned, in the thread of its node, whichever thread wants it.

    Parameters
    ----------
    node
        The node that asks.

    """

    def __init__(self, node: Node) -> None:
        self._caller = node.create_client(AddDiagnostics, OPERATOR_SERVICE)
        self._acknowledge = node.create_publisher(String, ACKNOWLEDGE_TOPIC, qos.ACKNOWLEDGE)
        self._note = node.create_publisher(String, NOTE_TOPIC, qos.NOTE)
        self._asked: SimpleQueue[tuple[str, str, str, Future[str]]] = SimpleQueue()
        every(node, _PERIOD_S, self._serve)

    def ask(self, what: str, text: str, operator: str) -> Future[str]:
        """
        Ask for an action, from any thread.

        Parameters
        ----------
        what : {'start', 'stop', 'acknowledge', 'note'}
            The action.
        text
            The note; or the alarm to acknowledge, all if empty.
        operator
            Name of the person who asks; '' if it is not known.

        Returns
        -------
        Future of str
            The answer in words.

        """
        answer: Future[str] = Future()
        self._asked.put((what, text, operator, answer))
        return answer

    def _serve(self) -> None:
        while not self._asked.empty():
            what, text, operator, answer = self._asked.get()
            if not answer.set_running_or_notify_cancel():
                continue
            if what == 'note' or text:
                self._tell(what, text, operator, answer)
            elif not self._caller.service_is_ready():
                answer.set_result('the compliance node does not answer: is it running?')
            else:
                request = AddDiagnostics.Request(load_namespace=sign_text(what, operator))
                self._caller.call_async(request).add_done_callback(partial(self._finish, answer))

    def _tell(self, what: str, text: str, operator: str, answer: Future[str]) -> None:
        """Publish a note, or the name of an alarm to acknowledge."""
        publisher, done, nobody = (
            (self._note, 'the note was sent to the recorder', 'no recorder listens: no note kept')
            if what == 'note' else
            (self._acknowledge, f'{text}: acknowledged', 'no node listens'))
        if publisher.get_subscription_count():
            publisher.publish(encode_text(sign_text(text, operator)))
            answer.set_result(done)
        else:
            answer.set_result(nobody)

    @staticmethod
    def _finish(answer: Future[str], called: Any) -> None:
        answer.set_result(called.result().message)
