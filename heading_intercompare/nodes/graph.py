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

"""
The graph in one process and one context; the launch files run it as several processes.

The nodes that pair and judge have a thread of their own. Judging a long run takes seconds, and
meanwhile readings must still be stamped and recorded.
"""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
import os
from queue import SimpleQueue
import threading
import time
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Sequence, TypeVar

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from heading_intercompare.core.alarms.graph_watch import ONE_PROCESS_S
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.nodes.interface.parameters import make_overrides
from heading_intercompare.nodes.launching.process import (
    check_security,
    end,
    say_security_errors,
    settle_memory,
    spin_nodes,
    Stop,
)
from heading_intercompare.nodes.launching.systemd_link import SystemdLink
from heading_intercompare.nodes.presence.endpoints import check_namespace
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.transports import prefer_udp, RANGE, set_variable
from heading_intercompare.nodes.sending.source_thread import ReadingNode
from heading_intercompare.nodes.spinning.executors import StockExecutor
from heading_intercompare.web.bridge.bridge_view import BridgeView

from .alert_sender import AlertSender
from .compliance import Compliance
from .dashboard import Dashboard
from .recorder import Recorder
from .synchronizer import Synchronizer
from .watcher import Watcher

_SHOW_S = 0.3

#: What pairs and judges has a thread of its own.
_JUDGES = (Compliance, Synchronizer)
_Kind = TypeVar('_Kind')


class Source(NamedTuple):
    """
    A node that publishes headings.

    Attributes
    ----------
    make
        `NmeaDriver`, `MotionDriver`, `SensorSimulator` or `Replayer`.
    name
        Name of the node.
    settings
        Its own parameters, by dotted name.

    """

    make: Callable[..., GraphNode]
    name: str
    settings: Mapping[str, Any]


class _Planned(NamedTuple):
    """A node to make: its class, name and own parameters."""

    make: Callable[..., GraphNode]
    name: str
    parameters: Mapping[str, Any]


@contextmanager
def _context(private: bool) -> Iterator[Context]:
    """Yield a ROS context; a private one is cut off from everything outside this process."""
    context = Context()
    with set_variable(RANGE, 'OFF') if private else prefer_udp():
        try:
            check_security()
            with say_security_errors():
                rclpy.init(args=[], context=context,
                           signal_handler_options=SignalHandlerOptions.NO)
            yield context
        finally:
            context.try_shutdown()


def _align_logs(sources: Sequence[GraphNode]) -> None:
    """Start all logs at the earliest first stamp of any, so that they play in step."""
    logs = {source: source.first_ns for source in sources if isinstance(source, ReadingNode)}
    stamps_ns = [first_ns for first_ns in logs.values() if first_ns is not None]
    for log, first_ns in logs.items():
        if first_ns is not None:
            log.play_from(min(stamps_ns))


@contextmanager
def _spin_in_thread(executor: StockExecutor, systemd: SystemdLink) -> Iterator[Future[None]]:
    """Spin an executor in its own thread; yield its future, which ends early only on an error."""
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(0.05)
    with systemd.watch(executor), ThreadPoolExecutor(1) as pool:
        spun = pool.submit(spin)
        try:
            yield spun
        finally:
            over.set()
    spun.result()


class _Look:
    """Passes on what a graph does, if anybody wants to know, several times per second."""

    def __init__(self, graph: '_Graph', show: Callable[[BridgeView, str], None] | None,
                 tell: Callable[[str], None] | None, progress: Callable[[int], None]) -> None:
        self._graph, self._show, self._tell, self._progress = graph, show, tell, progress
        self._next_s = 0.0
        self._alarm_lines: SimpleQueue[str] = SimpleQueue()

    def pass_on(self, phase: str = '', *, at_once: bool = False) -> None:
        """Show the graph if it is time to."""
        now_s = time.monotonic()
        if self._show is not None and (at_once or now_s >= self._next_s):
            self._next_s = now_s + _SHOW_S
            self._show(self._graph.of(Watcher)[-1].view(), phase)

    def hear_alarms(self) -> None:
        """Let the nodes hand over changes of alarms instead of logging them."""
        for node in self._graph.nodes if self._tell is not None else ():
            node.health.tell = self._alarm_lines.put

    def count_pairs(self) -> None:
        """Pass on the number of pairs."""
        self._progress(sum(node.n_pairs for node in self._graph.of(Compliance)))

    def tell_alarms(self) -> None:
        """Pass on the changes of alarms: the judge has its own thread, which must not write."""
        while self._tell is not None and not self._alarm_lines.empty():
            self._tell(self._alarm_lines.get())


def _plan(sources: Sequence[Source], own: Mapping[str, Mapping[str, Any]],
          output: str | None, report_dir: str | None, page: Mapping[str, Any] | None,
          is_shown: bool) -> tuple[list[_Planned], list[_Planned]]:
    """Return the nodes that hear the others, and those to make then: a recorder, the sources."""
    recorded = output is not None
    judging_own = {**own.get('compliance', {}), 'report_dir': report_dir}
    if output is not None:
        judging_own['bag'] = os.path.abspath(output)
    hearing = [_Planned(partial(Compliance, True), 'compliance', judging_own),
               _Planned(Synchronizer, 'synchronizer', {
                   **own.get('synchronizer', {}), 'subscribers': int(recorded)})]
    if page is not None:
        hearing.append(_Planned(Dashboard, 'dashboard', page))
    if {'destination', 'push_url'} & own.get('alert_sender', {}).keys():
        hearing.append(_Planned(AlertSender, 'alert_sender', own['alert_sender']))
    if is_shown:
        hearing.append(_Planned(Watcher, 'watcher', {}))
    # One node takes headings, or motion; the recorder does, too.
    audience = {'subscribers': 1 + recorded}
    speaking = [_Planned(source.make, source.name, {**audience, **source.settings})
                for source in sources]
    if recorded:
        speaking.insert(0, _Planned(Recorder, 'recorder',
                                    {**own.get('recorder', {}), 'output': output}))
    return hearing, speaking


class _Graph:
    """The nodes of a graph: those that pair and judge in one executor, the others in another."""

    def __init__(self, context: Context, judging: StockExecutor, executor: StockExecutor,
                 nodes: list[GraphNode]) -> None:
        self._context, self.judging, self.executor, self.nodes = context, judging, executor, nodes

    def start(self, plan: Sequence[_Planned], settings: Mapping[str, Any],
              namespace: str) -> None:
        """Make nodes."""
        for planned in plan:
            make = planned.make
            if make is Synchronizer:
                # Its pairs go to the compliance node before it.
                make = partial(Synchronizer, self.of(Compliance)[-1])
            with say_security_errors():
                node = make(
                    context=self._context, cli_args=[
                        '--ros-args', '-r', f'__node:={planned.name}', '-r', f'__ns:={namespace}'],
                    parameter_overrides=make_overrides({**settings, **planned.parameters}))
            node.health.within_s = ONE_PROCESS_S
            self.nodes.append(node)
            (self.judging if isinstance(node, _JUDGES) else self.executor).add_node(node)

    def of(self, kind: type[_Kind]) -> list[_Kind]:
        """Return the nodes of a class."""
        return [node for node in self.nodes if isinstance(node, kind)]

    def is_sole(self) -> bool:
        """Tell whether no other graph publishes what this one does."""
        return all(node.sole.clear for node in self.nodes if isinstance(node, _JUDGES))

    def end(self, sources: Sequence[GraphNode]) -> None:
        """End the sources first, and last those that show and record what the judges say last."""
        for node in [node for node in self.nodes if isinstance(node, _JUDGES)]:
            self.judging.remove_node(node)
            self.executor.add_node(node)
        for dashboard in self.of(Dashboard):
            dashboard.drop_action()  # While the recorder can keep that it was not done.
        kinds = Synchronizer, Compliance, Recorder, AlertSender, Dashboard, Watcher
        end(self.executor, [*sources, *(node for kind in kinds for node in self.of(kind))])


def intercompare(sources: Sequence[Source], settings: Mapping[str, Any], *,
                 output: str | None = None, report_dir: str | None = None,
                 own: Mapping[str, Mapping[str, Any]] | None = None, private: bool = False,
                 namespace: str = '/', page: Mapping[str, Any] | None = None,
                 progress: Callable[[int], None] = lambda n_pairs: None,
                 show: Callable[[BridgeView, str], None] | None = None,
                 tell: Callable[[str], None] | None = None) -> Verdict | SensorsVerdict:
    """
    Run sources, synchronizer and compliance until all sources have finished, or a signal comes.

    Without sources the graph listens to topics that others publish, until a signal comes.

    Parameters
    ----------
    sources
        The nodes that publish headings and motion; a sensor without one is heard on its topic.
    settings
        Settings of the analysis, by dotted name.
    output
        Bag to record.
    report_dir
        Folder for the reports.
    own
        Further parameters of synchronizer, compliance and recorder, by node name;
        with a destination of `alert_sender` it sends the alarms to the bridge.
    private
        Hide the graph from other processes.
    namespace
        Namespace of all nodes and relative topics.
    page
        Parameters of the node dashboard, which then serves the live page; it prints the address.
    progress
        Called with the number of pairs several times per second, and at the end.
    show
        Called several times per second with what to show of the graph, and with what it does if
        it does not just run.
    tell
        Called with a line for each change of an alarm, which is then not logged.

    Returns
    -------
    Verdict or SensorsVerdict
        The verdict of the last report; on several sensors with the setting `sensors`.

    Raises
    ------
    SettingsError, DriverError, BagError, OSError
        If something the user gave is wrong; the message is one line.

    """
    # A mistake is said before anything is made.
    Settings.from_mapping({k: v for k, v in settings.items() if v is not None})
    check_namespace(namespace)
    hearing, speaking = _plan(sources, own or {}, output, report_dir, page,
                              show is not None)
    systemd = SystemdLink()
    with (_context(private) as context, Stop() as stop,
          spin_nodes(context) as (judging, _), spin_nodes(context) as (executor, nodes),
          systemd.watch(executor)):
        graph = _Graph(context, judging, executor, nodes)
        graph.start(hearing, settings, namespace)
        look = _Look(graph, show, tell, progress)
        # Beside another graph no bag is begun.
        while not (stop.requested or graph.is_sole()):
            judging.spin_once(0.01)
            executor.spin_once(0.01)
            look.pass_on('starting: looking for other graphs')
        graph.start(speaking, settings, namespace)
        running = nodes[len(nodes) - len(sources):]
        for recorder in graph.of(Recorder):
            recorder.state_sources({source.name: source.settings for source in sources})
        look.hear_alarms()
        _align_logs(running)
        settle_memory()
        systemd.tell('READY=1')
        with _spin_in_thread(judging, systemd) as judged:
            while not (stop.requested or judged.done()
                       or (running and all(s.done for s in running))):
                executor.spin_once(0.2)
                look.count_pairs()
                look.pass_on()
                look.tell_alarms()
        systemd.tell('STOPPING=1')
        look.pass_on('ending: taking the last pairs, closing the bag', at_once=True)
        graph.end(running)
        # The last pairs come while the nodes end.
        look.count_pairs()
        verdict = graph.of(Compliance)[-1].verdict
    if verdict is None:
        raise TimeoutError(None, 'no verdict: the nodes that judge did not end in time')
    return verdict
