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

"""What an operator asks of a graph: start or stop a run, undo that, acknowledge, keep a note."""

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
from heading_intercompare.nodes.presence.action_publisher import ActionPublisher
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.web.bridge.bridge_records import WaitingAction
from heading_intercompare.web.controls import Delay, RUN_ACTIONS

_PERIOD_S = 0.05
_NO_ANSWER = 'the compliance node does not answer: is it running?'

OPERATOR_SERVICE = 'compliance/operator_action'
"""
The service of the node that judges which also takes the name of the operator.

Its type, of another purpose, is the only standard one that takes a text and answers with one.
"""


class OperatorActions:
    """
    Asks the nodes concerned, in the thread of its node, whichever thread wants it.

    What begins or ends a run waits first, so that a person can undo it.

    Parameters
    ----------
    node, health
        The node that asks, and its state.

    Attributes
    ----------
    delay : Delay
        The action that waits.

    """

    def __init__(self, node: Node, health: Health) -> None:
        self.delay = Delay()
        self._logger = health.logger
        self._publisher = ActionPublisher(node, health)
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
        what : {'start', 'stop', 'undo', 'now', 'acknowledge', 'note'}
            The action; 'undo' and 'now' are of the one that waits.
        text
            The note; or the alarm to acknowledge, all if empty; or the action to undo or do now.
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

    def drop(self) -> None:
        """Say that the action that waits was not done, because the page ends; if one waits."""
        action, self.delay.waiting = self.delay.waiting, None
        if action is not None:
            self._say_not_done(action, 'the page ended')

    def _serve(self) -> None:
        action = self.delay.take_due()
        if action is not None:
            self._do(action, Future())
        while not self._asked.empty():
            what, text, operator, answer = self._asked.get()
            if answer.set_running_or_notify_cancel():
                self._begin(what, text, operator, answer)

    def _begin(self, what: str, text: str, operator: str, answer: Future[str]) -> None:
        if what in ('undo', 'now'):
            self._shorten(what, text, operator, answer)
        elif what == 'note' or text:
            self._tell(what, text, operator, answer)
        elif not self._caller.service_is_ready():
            answer.set_result(_NO_ANSWER)
        elif what in RUN_ACTIONS:
            words = self.delay.begin(what, operator)
            self._logger.info(sign_text(words, operator))
            answer.set_result(words)
        else:
            self._call(what, operator, answer)

    def _shorten(self, what: str, text: str, operator: str, answer: Future[str]) -> None:
        """Undo the waiting action `text`, or do it now."""
        action = self.delay.take(text)
        if action is None:
            answer.set_result('that action no longer waits: it was done or undone')
            return
        words = f'{"undid" if what == "undo" else "did now"}: {RUN_ACTIONS[action.what]}'
        self._publisher.publish(words, operator)
        if what == 'undo':
            self.delay.outcome = sign_text(words, operator)
            answer.set_result(words)
        else:
            self._do(action, answer)

    def _do(self, action: WaitingAction, answer: Future[str]) -> None:
        """Begin or end a run, in the name of the person who asked for it first."""
        self.delay.outcome = f'{RUN_ACTIONS[action.what]}: the compliance node was asked'
        answer.add_done_callback(partial(self._keep_outcome, action))
        if self._caller.service_is_ready():
            self._call(action.what, action.operator, answer)
        else:
            self._say_not_done(action, 'the compliance node does not answer')
            answer.set_result(_NO_ANSWER)

    def _keep_outcome(self, action: WaitingAction, answer: Future[str]) -> None:
        self.delay.outcome = f'{RUN_ACTIONS[action.what]}: {answer.result()}'

    def _say_not_done(self, action: WaitingAction, why: str) -> None:
        self._publisher.publish(f'not done, because {why}: {RUN_ACTIONS[action.what]}',
                                action.operator, warn=True)

    def _call(self, what: str, operator: str, answer: Future[str]) -> None:
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
