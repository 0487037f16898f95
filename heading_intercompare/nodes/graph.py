# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The graph in one process and one context; the launch files run it as several processes.

The node that judges has its own thread. Judging a long run takes seconds, and meanwhile readings
must still be stamped, paired and recorded.
"""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
import os
from queue import SimpleQueue
import threading
import time
from typing import Any, Callable, Iterator, Mapping, NamedTuple, Sequence

import rclpy
from rclpy.context import Context
from rclpy.exceptions import InvalidNamespaceException
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_namespace import validate_namespace

from heading_intercompare.core.settings import SettingsError
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.nodes.ros.parameters import make_overrides
from heading_intercompare.nodes.ros.process import end, settle_memory, spin_nodes, Stop
from heading_intercompare.nodes.ros.security import check_security, say_security_errors
from heading_intercompare.nodes.ros.transports import prefer_udp, set_variable
from heading_intercompare.web.bridge.bridge_view import BridgeView

from .compliance import Compliance
from .dashboard import Dashboard
from .recorder import Recorder
from .synchronizer import Synchronizer
from .watcher import Watcher

__all__ = ['intercompare', 'Source']

_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
_SHOW_S = 0.3


class Source(NamedTuple):
    """
    A node that publishes headings.

    Attributes
    ----------
    make : type
        `NmeaDriver`, `SensorSimulator` or `Replayer`.
    name : str
        Name of the node.
    settings : mapping
        Its own parameters, by dotted name.

    """

    make: type
    name: str
    settings: Mapping[str, Any]


#: The class of a node, its name, and its own parameters.
_Planned = tuple[type, str, Mapping[str, Any]]


def _check_namespace(namespace: str) -> None:
    """Raise SettingsError if a namespace is not valid."""
    try:
        validate_namespace(namespace)
    except InvalidNamespaceException as error:
        why = str(error).removeprefix('Invalid namespace: ').partition(':')[0]
        raise SettingsError(f'namespace = {namespace!r}: {why}; must be like /ship1') from error


@contextmanager
def _context(private: bool) -> Iterator[Context]:
    """Yield a ROS context; a private one is cut off from everything outside this process."""
    context = Context()
    with set_variable(_RANGE, 'OFF') if private else prefer_udp():
        try:
            check_security()
            with say_security_errors():
                rclpy.init(args=[], context=context,
                           signal_handler_options=SignalHandlerOptions.NO)
            yield context
        finally:
            context.try_shutdown()


def _align_logs(sources: Sequence[Node]) -> None:
    """Start all logs at the earliest first stamp of any, so that they play in step."""
    logs = [s for s in sources if getattr(s, 'first_ns', None) is not None]
    for log in logs:
        log.play_from(min(other.first_ns for other in logs))


@contextmanager
def _spin_in_thread(executor: Executor) -> Iterator[Future]:
    """Spin an executor in its own thread; yield its future, which ends early only on an error."""
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(0.05)
    with ThreadPoolExecutor(1) as pool:
        spun = pool.submit(spin)
        try:
            yield spun
        finally:
            over.set()
    spun.result()


class _Look:
    """Passes on what to show of a graph, if anybody wants to know, several times per second."""

    def __init__(self, watcher: Node, show: Callable[[BridgeView, str], None] | None) -> None:
        self._watcher, self._show, self._next_s = watcher, show, 0.0

    def pass_on(self, phase: str = '', *, at_once: bool = False) -> None:
        """Show the graph if it is time to."""
        now_s = time.monotonic()
        if self._show is not None and (at_once or now_s >= self._next_s):
            self._next_s = now_s + _SHOW_S
            self._show(self._watcher.view(), phase)


def intercompare(sources: Sequence[Source], settings: Mapping[str, Any], *,
                 output: str | None = None, report_dir: str | None = None,
                 own: Mapping[str, Mapping[str, Any]] | None = None, private: bool = False,
                 namespace: str = '/', page: Mapping[str, Any] | None = None,
                 progress: Callable[[int], None] = lambda n_pairs: None,
                 show: Callable[[BridgeView, str], None] | None = None,
                 tell: Callable[[str], None] | None = None,
                 served: Callable[[str], None] = lambda url: None) -> Verdict:
    """
    Run sources, synchronizer and compliance until all sources have finished, or a signal comes.

    Without sources the graph listens to topics that others publish, until a signal comes.

    Parameters
    ----------
    sources : sequence of Source
        The nodes that publish the headings; a sensor without one is heard on its topic.
    settings : mapping
        Settings of the analysis, by dotted name.
    output : str, optional
        Bag to record.
    report_dir : str, optional
        Folder for the reports.
    own : mapping of str to mapping, optional
        Further parameters of synchronizer, compliance and recorder, by node name.
    private : bool
        Hide the graph from other processes.
    namespace : str
        Namespace of all nodes and relative topics.
    page : mapping, optional
        Parameters of the node dashboard, which then serves the live page; it prints the address.
    progress : callable
        Called with the number of pairs several times per second, and at the end.
    show : callable, optional
        Called several times per second with what to show of the graph, and with what it does if
        it does not just run.
    tell : callable, optional
        Called with a line for each change of an alarm, which is then not logged.
    served : callable
        Called with the address of the page once it is served.

    Returns
    -------
    Verdict
        The verdict of the last report.

    Raises
    ------
    SettingsError, DriverError, BagError, OSError
        If something the user gave is wrong; the message is one line.

    """
    heard = {'subscribers': 1 if output is None else 2}
    own = own or {}
    judging_own = {**own.get('compliance', {}), 'report_dir': report_dir}
    if output is not None:
        judging_own['bag'] = os.path.abspath(output)
    _check_namespace(namespace)
    first: list[_Planned] = [
        (Compliance, 'compliance', judging_own),
        (Synchronizer, 'synchronizer', {**own.get('synchronizer', {}), **heard})]
    if page is not None:
        first.append((Dashboard, 'dashboard', page))
    if show is not None:
        first.append((Watcher, 'watcher', {}))
    then: list[_Planned] = [(s.make, s.name, {**heard, **s.settings}) for s in sources]
    if output is not None:
        then.insert(0, (Recorder, 'recorder', {**own.get('recorder', {}), 'output': output}))
    with (_context(private) as context, Stop() as stop,
          spin_nodes(context) as (judging, _), spin_nodes(context) as (executor, nodes)):
        def start(plan: Sequence[_Planned]) -> None:
            for make, name, parameters in plan:
                with say_security_errors():
                    nodes.append(make(
                        context=context, cli_args=['--ros-args', '-r', f'__node:={name}', '-r',
                                                   f'__ns:={namespace}'],
                        parameter_overrides=make_overrides({**settings, **parameters})))
                (judging if make is Compliance else executor).add_node(nodes[-1])
        start(first)
        compliance, synchronizer, *pages = nodes
        for one in pages:
            if isinstance(one, Dashboard):
                served(one.page.url)
        look = _Look(nodes[-1], show)
        # Beside another graph no bag is begun.
        while not (stop.requested or compliance.sole.clear and synchronizer.sole.clear):
            judging.spin_once(0.01)
            executor.spin_once(0.01)
            look.pass_on('starting: looking for other graphs')
        start(then)
        recorders = nodes[2 + len(pages):len(nodes) - len(sources)]
        running = nodes[len(nodes) - len(sources):]
        for recorder in recorders:
            recorder.state_sources({source.name: source.settings for source in sources})
        told: SimpleQueue[str] = SimpleQueue()
        for node in nodes if tell is not None else ():
            if hasattr(node, 'alarms'):
                node.alarms.panel.tell = told.put
        _align_logs(running)
        settle_memory()
        with _spin_in_thread(judging) as judged:
            while not (stop.requested or judged.done()
                       or (running and all(s.done for s in running))):
                executor.spin_once(0.2)
                progress(compliance.n_pairs)
                look.pass_on()
                # The judge has its own thread; only this one writes.
                while tell is not None and not told.empty():
                    tell(told.get())
        look.pass_on('ending: taking the last pairs, closing the bag', at_once=True)
        judging.remove_node(compliance)
        executor.add_node(compliance)
        # End the sources first, then the synchronizer, then compliance, then those that show and
        # record what it says last.
        end(executor, [*running, synchronizer, compliance, *recorders, *pages])
        # The last pairs come while the nodes end.
        progress(compliance.n_pairs)
        return compliance.verdict
