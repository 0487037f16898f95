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
A node as a process: one line for a user's mistake, a clean end on a signal.

The signal handlers of rclpy would end the context before the last verdict could be published. So
they are not installed, and a flag ends the loop instead.

Fast DDS may never return from taking down a participant whose peers were killed, or when it takes
down several at once on a busy computer. It holds the interpreter lock meanwhile, so neither a
thread of Python nor a signal handler can end the process. A timer of the C library can.
"""

from __future__ import annotations

from contextlib import contextmanager
import ctypes
from functools import partial
import gc
import math
from operator import methodcaller
import os
from pathlib import Path
import signal
import sys
import time
from typing import Any, Callable, Iterator, Sequence

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.settings import DriverError
from heading_intercompare.nodes.launching.systemd_link import SystemdLink
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.spinning.executors import make_executor, StockExecutor

_CLOCK_MONOTONIC, _SIGEV_THREAD = 1, 2


class _Event(ctypes.Structure):
    """`struct sigevent` of Linux: what a timer does, 64 bytes."""

    _fields_ = (('value', ctypes.c_uint64), ('signal', ctypes.c_int), ('notify', ctypes.c_int),
                ('function', ctypes.c_void_p), ('attributes', ctypes.c_void_p),
                ('rest', ctypes.c_char * 32))


class _Times(ctypes.Structure):
    """`struct itimerspec`: the interval and the first time, each as seconds and nanoseconds."""

    _fields_ = tuple((name, ctypes.c_long)
                     for name in ('every_s', 'every_ns', 'first_s', 'first_ns'))


@contextmanager
def leave_if_hung(seconds: float, code: int) -> Iterator[None]:
    """
    End the process if the block takes longer; only Linux has such timers.

    Parameters
    ----------
    seconds
        The longest time that the block may take, > 0.
    code
        The exit code then.

    Raises
    ------
    OSError
        If the kernel gives no timer.

    """
    if sys.platform != 'linux':
        yield
        return
    libc = ctypes.CDLL(None, use_errno=True)
    # The timer calls `_exit(code)` in a thread of its own.
    event = _Event(value=code, notify=_SIGEV_THREAD,
                   function=ctypes.cast(libc._exit, ctypes.c_void_p))
    timer = ctypes.c_void_p()
    fraction_s, whole_s = math.modf(seconds)
    times = _Times(first_s=int(whole_s), first_ns=round(fraction_s * 1e9))
    if libc.timer_create(_CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) or (
            libc.timer_settime(timer, 0, ctypes.byref(times), None)):
        raise OSError(ctypes.get_errno(), 'no timer')
    try:
        yield
    finally:
        libc.timer_delete(timer)


def _wanted() -> bool:
    return (os.environ.get('ROS_SECURITY_ENABLE') == 'true'
            and os.environ.get('ROS_SECURITY_STRATEGY') == 'Enforce')


def check_security() -> None:
    """Raise SettingsError if security is enforced and there is no keystore."""
    keystore = os.environ.get('ROS_SECURITY_KEYSTORE', '')
    if _wanted() and not (keystore and Path(keystore, 'enclaves').is_dir()):
        raise SettingsError(
            f'ROS_SECURITY_STRATEGY is Enforce, but ROS_SECURITY_KEYSTORE = {keystore!r} is not a '
            'keystore; share/heading_intercompare/security/make_keystore.py makes one')


@contextmanager
def say_security_errors() -> Iterator[None]:
    """Turn what rcl says of missing keys or a middleware without security into SettingsError."""
    try:
        yield
    except RuntimeError as error:
        if not _wanted():
            raise
        words = ' '.join(str(error).split()).partition(', at /')[0]
        raise SettingsError(f'ROS security is enforced: {words}') from error


_MISTAKES = (SettingsError, DriverError, BagError, OSError)
"""The errors that a user can cause; the text of each is one line that says what is wrong."""

# Longest time that a node may take to end; other launch files than ours kill it after 10 s.
_END_S = 9.0

# The middleware may never return from taking down a node. Everything is published and written by
# then.
_HUNG_S = 30.0

# Best-effort messages still under way are lost when the process that sent them ends.
_LINGER_S = 0.5


class Stop:
    """
    Notes SIGINT, SIGTERM and SIGHUP while entered; `requested` says whether one came.

    SIGHUP, which a closed terminal sends, stays ignored if it was, for instance by `nohup`.
    """

    def __init__(self) -> None:
        self.requested = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> 'Stop':
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number == signal.SIGHUP and signal.getsignal(number) == signal.SIG_IGN:
                continue
            self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, *_: object) -> None:
        self.requested = True


@contextmanager
def spin_nodes(context: Context) -> Iterator[tuple[StockExecutor, list[GraphNode]]]:
    """Yield an executor and a list; destroy the nodes in the list at the end, in any case."""
    executor = make_executor(context)
    nodes: list[GraphNode] = []
    try:
        yield executor, nodes
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()


def end(executor: StockExecutor, nodes: Sequence[GraphNode], linger_s: float = 0.0,
        destroy: Callable[[GraphNode], None] = methodcaller('destroy_node')) -> None:
    """End and destroy nodes in the given order; spin each for `linger_s` after its end."""
    executor.eager = True
    for node in nodes:
        # The first to end are missed by the others, as they should be.
        node.health.mute()
    for node in nodes:
        node.end()
        deadline_s = time.monotonic() + _END_S
        while not node.ended and time.monotonic() < deadline_s:
            executor.spin_once(0.05)
        if not node.ended:
            node.get_logger().error(f'ends after {_END_S:g} s all the same, although '
                                    f'{node.give_up()}')
        deadline_s = time.monotonic() + linger_s
        while time.monotonic() < deadline_s:
            executor.spin_once(0.05)
        executor.remove_node(node)
        destroy(node)


def _destroy(node: GraphNode, nodes: Sequence[GraphNode], code: int) -> None:
    """Destroy a node; if that never returns, end with `code`, or with 1 if any has not ended."""
    with leave_if_hung(_HUNG_S, code if all(member.ended for member in nodes) else 1):
        node.destroy_node()


def settle_memory() -> None:
    """Let the garbage collector leave alone what has been loaded: it took tens of milliseconds."""
    gc.freeze()


def error_words(error: Exception) -> str:
    """Return an error in one line."""
    if isinstance(error, OSError) and error.strerror:
        where = '' if error.filename is None else f'{os.fspath(error.filename)}: '
        return f'{where}{error.strerror}'
    return ' '.join(str(error).split())


def run(name: str, make: Callable[..., GraphNode], args: Sequence[str] | None = None, *,
        beside: Callable[..., GraphNode] | None = None, more: bool = False) -> int:
    """
    Run a node until its work is over or a signal comes.

    Parameters
    ----------
    name
        Name of the executable, for messages.
    make
        Makes the node, given `context`.
    args
        Arguments; by default those of the process.
    beside
        Makes a node that runs as long as the first one, given that one and `context`.
    more
        The caller has more to do afterwards.

    Returns
    -------
    int
        0; or 2 after a user's mistake, which is reported in one line on stderr. A process that the
        middleware does not let go ends after 30 s with the same code; or with 1 if not all was
        published, or if there is `more` to do.

    """
    context, code, hung_code = Context(), 1, int(more)
    systemd = SystemdLink()
    try:
        with Stop() as stop:
            check_security()
            try:
                rclpy.init(args=None if args is None else [*args], context=context,
                           signal_handler_options=SignalHandlerOptions.NO)
            except RuntimeError as error:
                raise SettingsError(str(error).partition(', at ')[0]) from error
            with spin_nodes(context) as (executor, nodes):
                with say_security_errors():
                    nodes.append(make(context=context))
                    if beside is not None:
                        nodes.append(beside(nodes[0], context=context))
                for node in nodes:
                    executor.add_node(node)
                settle_memory()
                with systemd.watch(executor):
                    systemd.tell('READY=1')
                    while not (stop.requested or nodes[0].done):
                        executor.spin_once(0.2)
                    systemd.tell('STOPPING=1')
                    longest_s = _HUNG_S + len(nodes) * (_END_S + _LINGER_S)
                    with leave_if_hung(longest_s, 1):
                        end(executor, nodes, _LINGER_S,
                            partial(_destroy, nodes=nodes, code=hung_code))
        code = 0
    except _MISTAKES as error:
        sys.stderr.write(f'{name}: error: {error_words(error)}\n')
        code = 2
    finally:
        with leave_if_hung(_HUNG_S, code or hung_code):
            context.try_shutdown()
    return code
