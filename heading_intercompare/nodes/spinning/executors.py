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
What turns the nodes of a process: a quick executor, or that of rclpy.

The executors of rclpy build a wait set and a task for each callback, which costs 0.5
to 1 ms of CPU for a timer. The quick one keeps its wait set, and calls timers and guard conditions
itself. What is rare (services, single messages, QoS events) it looks for 10 times a second, and
leaves to rclpy. `benchmarks/live.py` measures what that saves.

It stands on private parts of rclpy, which another version may not have. The executor of rclpy does
not, and the nodes do the same with it; the environment chooses.
"""

from __future__ import annotations

from contextlib import ExitStack
import os
import time
from typing import Any, Callable

from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.nodes.spinning.batches import Arrivals, Unwatched

#: Names the executor of a process.
EXECUTOR = 'HEADING_INTERCOMPARE_EXECUTOR'

# How often to look for what is rare; a service answers this much later.
_RARE_S = 0.1


class StockExecutor(SingleThreadedExecutor):
    """
    The SingleThreadedExecutor of rclpy, which says at each turn that it turns.

    Attributes
    ----------
    eager : bool
        Leave nothing that has come: a node ends. rclpy never does, so here it changes nothing.
    beat : callable or None
        Called at each turn: it shows that no callback hangs.

    """

    eager = False
    beat: Callable[[], None] | None = None

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait until something is due, and do it."""
        if not self.context.ok():
            raise ExternalShutdownException()
        if self.beat is not None:
            self.beat()
        self.turn(timeout_sec)

    def turn(self, timeout_sec: float | None) -> None:
        """Do what `spin_once` says, without the beat."""
        super().spin_once(timeout_sec)


class QuickExecutor(StockExecutor):
    """
    A SingleThreadedExecutor for nodes that take their messages in batches.

    While it is `eager`, it looks for what is rare at every turn.

    Notes
    -----
    A callback of a timer or guard condition must not be a coroutine. The executor keeps the
    handles of all entities in use until it looks over its nodes again, so an entity that is
    destroyed in a callback goes at the next turn. It does not end on a signal, which the program
    handles (`process.Stop`).

    """

    def __init__(self, *, context: Context) -> None:
        super().__init__(context=context)
        self._stale = True
        self._held = ExitStack()
        self._timers: list[Any] = []
        self._guards: list[Any] = []
        self._arrivals: dict[Arrivals, list[Any]] = {}
        self._rare: dict[str, list[Any]] = {}
        self._waitables: list[Any] = []
        self._often_set: Any = None
        self._rare_set: Any = None
        self._rare_at_s = 0.0

    def add_node(self, node: Node) -> bool:
        """Spin a node from now on."""
        self._stale = True
        return super().add_node(node)

    def remove_node(self, node: Node) -> None:
        """Spin a node no longer, and let go of it."""
        super().remove_node(node)
        self._let_go()

    def wake(self) -> None:
        """Note that entities came or went, and wake."""
        self._stale = True
        super().wake()

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """End, and let go of all nodes."""
        self._let_go()
        return super().shutdown(timeout_sec)

    def turn(self, timeout_sec: float | None) -> None:
        """Wait until something is due, at most 100 ms, and do it."""
        if self._stale:
            self._look_over()
        now_s = time.monotonic()
        if self.eager or now_s >= self._rare_at_s:
            if self._tasks or self._is_rare_ready():
                # rclpy takes one message per subscription, so look again at once.
                self._serve_rare()
                return
            self._rare_at_s = now_s + _RARE_S
        rest_s = self._rare_at_s - now_s
        self._wait(rest_s if timeout_sec is None else min(rest_s, timeout_sec))

    def _wait(self, seconds: float) -> None:
        """Wait for timers, guard conditions and first messages, and act on them."""
        wait_set = self._often_set
        wait_set.clear_entities()
        for timer in self._timers:
            wait_set.add_timer(timer.handle)
        for guard in self._guards:
            wait_set.add_guard_condition(guard.handle)
        wait_set.add_guard_condition(self._guard.handle)
        for arrivals, handles in self._arrivals.items():
            if not arrivals.gathering:
                for handle in handles:
                    wait_set.add_subscription(handle)
        wait_set.wait(max(0, int(1e9 * seconds)))
        arrived = wait_set.get_ready_entities('subscription')
        for arrivals, handles in self._arrivals.items() if arrived else ():
            if any(handle.pointer in arrived for handle in handles):
                arrivals.beginning_execution(None)
        # A callback may look over the entities, and let go of these.
        ready = wait_set.get_ready_entities('timer')
        timers = [timer for timer in self._timers if timer.handle.pointer in ready]
        triggered = wait_set.get_ready_entities('guard_condition')
        guards = [guard for guard in self._guards if guard.handle.pointer in triggered]
        for timer in timers:
            with timer.handle:
                if not timer.handle.is_timer_ready():
                    continue
                timer.handle.call_timer()
            timer.callback()
        for guard in guards:
            guard.callback()

    def _is_rare_ready(self) -> bool:
        if not (self._waitables or any(self._rare.values())):
            return False
        wait_set = self._rare_set
        wait_set.clear_entities()
        for kind, handles in self._rare.items():
            add = getattr(wait_set, f'add_{kind}')
            for handle in handles:
                add(handle)
        for waitable in self._waitables:
            waitable.add_to_wait_set(wait_set)
        wait_set.wait(0)
        return (any(wait_set.get_ready_entities(kind) for kind in self._rare)
                or any(waitable.is_ready(wait_set) for waitable in self._waitables))

    def _serve_rare(self) -> None:
        """Let rclpy do all that is ready now."""
        try:
            while True:
                task, _, _ = self.wait_for_ready_callbacks(0.0)
                task()
                if task.exception() is not None:
                    raise task.exception()
        except (TimeoutException, ShutdownException):
            pass

    def _let_go(self) -> None:
        """Allow all entities to be destroyed."""
        self._stale = True
        self._timers, self._guards, self._waitables = [], [], []
        self._arrivals, self._rare = {}, {}
        self._often_set = self._rare_set = None
        self._held.close()

    def _hold(self, entity: Any) -> bool:
        """Keep a handle in use; return whether it is still there."""
        try:
            self._held.enter_context(entity)
        except InvalidHandle:
            return False
        return True

    def _look_over(self) -> None:
        """List the entities of all nodes, and make the wait sets."""
        self._let_go()
        self._stale = False
        subscriptions = []
        services, clients = [], []
        for node in self.get_nodes():
            self._timers += [timer for timer in node.timers if self._hold(timer.handle)]
            self._guards += [guard for guard in node.guards if self._hold(guard.handle)]
            self._waitables += [waitable for waitable in node.waitables if self._hold(waitable)]
            services += [service.handle for service in node.services if self._hold(service.handle)]
            clients += [client.handle for client in node.clients if self._hold(client.handle)]
            for subscription in node.subscriptions:
                group = subscription.callback_group
                if isinstance(group, Arrivals):
                    if self._hold(subscription.handle):
                        self._arrivals.setdefault(group, []).append(subscription.handle)
                elif not isinstance(group, Unwatched) and self._hold(subscription.handle):
                    subscriptions.append(subscription.handle)
        self._rare = {'subscription': subscriptions, 'service': services, 'client': clients}
        others = [waitable.get_num_entities() for waitable in self._waitables]
        self._hold(self._context.handle)
        self._often_set = rclpy_implementation.WaitSet(
            sum(map(len, self._arrivals.values())), len(self._guards) + 1, len(self._timers), 0, 0,
            0, self._context.handle)
        self._rare_set = rclpy_implementation.WaitSet(
            len(subscriptions) + sum(n.num_subscriptions for n in others),
            sum(n.num_guard_conditions for n in others), sum(n.num_timers for n in others),
            len(clients) + sum(n.num_clients for n in others),
            len(services) + sum(n.num_services for n in others),
            sum(n.num_events for n in others), self._context.handle)


_KINDS: dict[str, type[StockExecutor]] = {'quick': QuickExecutor, 'rclpy': StockExecutor}


def make_executor(context: Context) -> StockExecutor:
    """Return the executor that the environment names; SettingsError if there is none such."""
    kind = os.environ.get(EXECUTOR, 'quick')
    if kind not in _KINDS:
        raise SettingsError(f'{EXECUTOR} = {kind!r}: must be {" or ".join(_KINDS)}')
    return _KINDS[kind](context=context)
