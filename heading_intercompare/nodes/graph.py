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
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from heading_intercompare.core.sensor_table import list_tested, read_sensors
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.nodes.ros.parameters import make_overrides
from heading_intercompare.nodes.ros.process import end, settle_memory, spin_nodes, Stop
from heading_intercompare.nodes.ros.remapping import check_namespace
from heading_intercompare.nodes.ros.security import check_security, say_security_errors
from heading_intercompare.nodes.ros.transports import prefer_udp, RANGE, set_variable
from heading_intercompare.nodes.sensors.places import (
    count_motion_subscribers,
    count_subscribers,
    further_subscribers,
    remap_rules,
)
from heading_intercompare.web.bridge.bridge_view import BridgeView

from .compliance import Compliance
from .dashboard import Dashboard
from .motion_driver import MotionDriver
from .recorder import Recorder
from .sensors_watch import SensorsWatch
from .synchronizer import Synchronizer
from .watcher import Watcher

__all__ = ['intercompare', 'Source']

_SHOW_S = 0.3

_JUDGES = (Compliance, SensorsWatch)
#: What those that judge have in common.
_OF_JUDGES = ('journal', 'resume_within_s', 'bag')


class Source(NamedTuple):
    """
    A node that publishes headings.

    Attributes
    ----------
    make : type
        `NmeaDriver`, `MotionDriver`, `SensorSimulator` or `Replayer`.
    name : str
        Name of the node.
    settings : mapping
        Its own parameters, by dotted name.

    """

    make: type
    name: str
    settings: Mapping[str, Any]


class _Planned(NamedTuple):
    """A node to make: its class, name, own parameters, and its sensor if it has one."""

    make: type
    name: str
    parameters: Mapping[str, Any]
    sensor: str = ''

    def arguments(self, namespace: str, remaps: Mapping[str, str]) -> list[str]:
        """Return its arguments, given the namespace of the graph and what sensors share."""
        place = f'{namespace.rstrip("/")}/{self.sensor}' if self.sensor else namespace
        rules = {'__node': self.name, '__ns': place, **(remaps if self.sensor else {})}
        return ['--ros-args', *(word for old, new in rules.items()
                                for word in ('-r', f'{old}:={new}'))]


def _plan_judging(settings: Settings, own: Mapping[str, Mapping[str, Any]],
                  judging_own: Mapping[str, Any], recorded: bool) -> list[_Planned]:
    """Return the nodes that judge: two for each tested sensor, and one for several."""
    pairing_own = {**own.get('synchronizer', {}), 'subscribers': 1 + recorded}
    sensors = read_sensors(settings.sensors)
    planned = []
    for sensor in [sensor.name for sensor in list_tested(sensors)] if sensors else ['']:
        named = {'sensor': sensor} if sensor else {}
        planned += [_Planned(Compliance, 'compliance', {**judging_own, **named}, sensor),
                    _Planned(Synchronizer, 'synchronizer', {**pairing_own, **named}, sensor)]
    if sensors:
        shared = {name: judging_own[name] for name in _OF_JUDGES if name in judging_own}
        planned.append(_Planned(SensorsWatch, 'sensors_watch', {
            **shared, **own.get('sensors_watch', {}),
            'report_dir': judging_own.get('report_dir')}))
    return planned


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


def _align_logs(sources: Sequence[Node]) -> None:
    """Start all logs at the earliest first stamp of any, so that they play in step."""
    logs = [s for s in sources if getattr(s, 'first_ns', None) is not None]
    for log in logs:
        log.play_from(min(other_log.first_ns for other_log in logs))


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
                 served: Callable[[str], None] = lambda url: None) -> Verdict | SensorsVerdict:
    """
    Run sources, synchronizer and compliance until all sources have finished, or a signal comes.

    With the setting `sensors` each tested sensor has these two nodes in a namespace of its own,
    and a node joins them.

    Without sources the graph listens to topics that others publish, until a signal comes.

    Parameters
    ----------
    sources : sequence of Source
        The nodes that publish headings and motion; a sensor without one is heard on its topic.
    settings : mapping
        Settings of the analysis, by dotted name.
    output : str, optional
        Bag to record.
    report_dir : str, optional
        Folder for the reports.
    own : mapping of str to mapping, optional
        Further parameters of synchronizer, compliance, sensors_watch and recorder, by node name.
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
    Verdict or SensorsVerdict
        The verdict of the last report; on several sensors with the setting `sensors`.

    Raises
    ------
    SettingsError, DriverError, BagError, OSError
        If something the user gave is wrong; the message is one line.

    """
    whole = Settings.from_mapping({k: v for k, v in settings.items() if v is not None})
    sensors = read_sensors(whole.sensors)
    heard, further = count_subscribers(sensors, output is not None), further_subscribers(whole)
    remaps = remap_rules(sensors, namespace, whole.motion)
    own = own or {}
    judging_own = {**own.get('compliance', {}), 'report_dir': report_dir}
    if output is not None:
        judging_own['bag'] = os.path.abspath(output)
    check_namespace(namespace)
    first = _plan_judging(whole, own, judging_own, output is not None)
    n_judging = len(first)
    if page is not None:
        first.append(_Planned(Dashboard, 'dashboard', page))
    if show is not None:
        first.append(_Planned(Watcher, 'watcher', {}))
    moved = count_motion_subscribers(sensors, output is not None)
    then = [_Planned(s.make, s.name, {
        'subscribers': moved if s.make is MotionDriver else heard + further.get(
            s.settings.get('topic', ''), 0), **s.settings}) for s in sources]
    if output is not None:
        then.insert(0, _Planned(Recorder, 'recorder',
                                {**own.get('recorder', {}), 'output': output}))
    with (_context(private) as context, Stop() as stop,
          spin_nodes(context) as (judging, _), spin_nodes(context) as (executor, nodes)):
        def start(plan: Sequence[_Planned]) -> None:
            for planned in plan:
                with say_security_errors():
                    nodes.append(planned.make(
                        context=context, cli_args=planned.arguments(namespace, remaps),
                        parameter_overrides=make_overrides({**settings, **planned.parameters})))
                (judging if planned.make in _JUDGES else executor).add_node(nodes[-1])
        start(first)
        deciding, pages = nodes[:n_judging], nodes[n_judging:]
        judges = [node for node in deciding if isinstance(node, _JUDGES)]
        pairing = [node for node in deciding if node not in judges]
        compliances = [node for node in judges if isinstance(node, Compliance)]
        for page_node in pages:
            if isinstance(page_node, Dashboard):
                served(page_node.page.url)
        look = _Look(nodes[-1], show)
        # Beside another graph no bag is begun.
        while not (stop.requested or all(node.sole.clear for node in deciding)):
            judging.spin_once(0.01)
            executor.spin_once(0.01)
            look.pass_on('starting: looking for other graphs')
        start(then)
        recorders = nodes[len(first):len(nodes) - len(sources)]
        running = nodes[len(nodes) - len(sources):]
        for recorder in recorders:
            recorder.state_sources({source.name: source.settings for source in sources})
        alarm_lines: SimpleQueue[str] = SimpleQueue()
        for node in nodes if tell is not None else ():
            if hasattr(node, 'alarms'):
                node.alarms.panel.tell = alarm_lines.put
        _align_logs(running)
        settle_memory()
        with _spin_in_thread(judging) as judged:
            while not (stop.requested or judged.done()
                       or (running and all(s.done for s in running))):
                executor.spin_once(0.2)
                progress(sum(node.n_pairs for node in compliances))
                look.pass_on()
                # The judge has its own thread; only this one writes.
                while tell is not None and not alarm_lines.empty():
                    tell(alarm_lines.get())
        look.pass_on('ending: taking the last pairs, closing the bag', at_once=True)
        for node in judges:
            judging.remove_node(node)
            executor.add_node(node)
        # End the sources first, then the synchronizers, then those that judge, then those that
        # show and record what these say last.
        end(executor, [*running, *pairing, *judges, *recorders, *pages])
        # The last pairs come while the nodes end.
        progress(sum(node.n_pairs for node in compliances))
        return judges[-1].verdict
