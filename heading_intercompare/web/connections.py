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

"""The connections to the page: bounded, so that recorder and journal keep their descriptors."""

from __future__ import annotations

import asyncio
from contextlib import suppress
import ipaddress
import math
import resource
import socket
import time
from typing import Any, Sequence

from .guard import App, read_address, Receive, Scope, Send
from .metrics import DoorCounts

MOST = 512
"""Connections in all, at most half of the descriptors of the process."""

#: Connections that the kernel holds until they are taken, which may be all at once.
_BACKLOG = 64
#: From the start of a connection, and from the end of an answer, to the end of the next headers.
_HEADERS_S = 10.0
#: From there to the end of the answer; the server of the page answers each poll within 6 s.
_ANSWER_S = 60.0
#: How long the other end of a WebSocket may take nothing of what is sent.
_TAKEN_S = 20.0
_MOST_BODY = 1_000_000
_SWEEP_S = 1.0


def raise_descriptors() -> int:
    """Raise the descriptors that the process may have as far as it may; return their number."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        soft = hard
    return MOST * 2 if soft == resource.RLIM_INFINITY else soft


class _Connection(socket.socket):
    """A connection, with the time by which its next step is due."""

    connections: Connections
    peer: tuple[str, int]
    network: object
    served = False
    due_s = math.inf

    def end(self) -> None:
        """End it; the event loop notices, and closes it."""
        self.due_s = math.inf
        with suppress(OSError):
            self.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Give its descriptor back."""
        super().close()
        self.connections.forget(self)


class _Listener(socket.socket):
    """A listening socket that takes no more connections than may be open."""

    connections: Connections

    def accept(self) -> tuple[socket.socket, Any]:
        """Return a connection and the address of its other end."""
        accepted, address = super().accept()
        connection = _Connection(self.family, self.type, self.proto, fileno=accepted.detach())
        connection.connections = self.connections
        if not self.connections.admit(connection, address):
            connection.close()
            # The event loop asks later for the next one.
            raise BlockingIOError
        return connection, address


def network_of(host: str) -> object:
    """Return what stands for a computer: its address, or the network of one in IPv6."""
    address = read_address(host)
    if isinstance(address, ipaddress.IPv6Address):
        return ipaddress.ip_network((address, 64), strict=False)
    return address or host


class Connections:
    """
    The open connections, and an ASGI application that knows which of them wait.

    Where there are too many, one that waits gives way to a new one, the longest waiting first. A
    client that never ends its headers can so keep nobody out.

    Parameters
    ----------
    most
        Connections in all.
    most_by_address
        Those of one address, or of one network of IPv6 (/64).

    Attributes
    ----------
    refused : int
        Connections that were refused.
    ended : int
        Connections that gave way, or that did not go on in time.
    backlog : int
        Connections that the kernel may hold until they are taken.

    """

    def __init__(self, most: int, most_by_address: int) -> None:
        self._most, self._most_by_address = most, most_by_address
        self._open: dict[tuple[str, int], _Connection] = {}
        self._app: App | None = None
        self.backlog = min(_BACKLOG, most // 4)
        self.refused = self.ended = 0

    def count(self) -> DoorCounts:
        """Return how many are open, and how many were refused and ended."""
        return DoorCounts(len(self._open), self.refused, self.ended)

    def listen(self, listener: socket.socket) -> socket.socket:
        """Return a bound socket as one that takes no more than these connections."""
        bounded = _Listener(listener.family, listener.type, listener.proto,
                            fileno=listener.detach())
        bounded.connections = self
        return bounded

    def admit(self, connection: _Connection, address: Sequence[Any]) -> bool:
        """Tell whether there is room for a connection, and make some if one waits."""
        connection.peer, connection.network = (address[0], address[1]), network_of(address[0])
        going_on = [other for other in self._open.values()
                    if other.served or other.due_s < math.inf]
        same = [other for other in going_on if other.network == connection.network]
        if (len(self._open) >= self._most
                or len(same) >= self._most_by_address and not self._make_room(same)
                or len(going_on) >= self._most - self.backlog and not self._make_room(going_on)):
            self.refused += 1
            return False
        connection.due_s = time.monotonic() + _HEADERS_S
        self._open[connection.peer] = connection
        return True

    def _make_room(self, connections: Sequence[_Connection]) -> bool:
        """End the connection that waits longest; tell whether there is one."""
        waiting = [connection for connection in connections if not connection.served]
        if not waiting:
            return False
        self.ended += 1
        min(waiting, key=lambda connection: connection.due_s).end()
        return True

    def forget(self, connection: _Connection) -> None:
        """Leave out a connection that was closed."""
        if self._open.get(connection.peer) is connection:
            del self._open[connection.peer]

    def sweep(self, now_s: float) -> None:
        """End the connections whose next step was due by a time of the monotonic clock."""
        for connection in list(self._open.values()):
            if connection.due_s <= now_s:
                self.ended += 1
                connection.end()

    def wrap(self, app: App) -> App:
        """Return an application around another one, which says what each connection does."""
        self._app = app
        return self._serve

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        assert self._app is not None
        if scope['type'] == 'lifespan':
            sweeper = asyncio.ensure_future(self._keep_sweeping())
            await self._app(scope, receive, send)
            sweeper.cancel()
            return
        peer = scope.get('client')
        connection = self._open.get((peer[0], peer[1])) if peer else None
        if connection is None:
            return
        connection.served = True
        try:
            if scope['type'] == 'websocket':
                await self._serve_socket(connection, scope, receive, send)
            else:
                connection.due_s = time.monotonic() + _ANSWER_S
                await self._app(scope, _bound_body(receive), send)
        finally:
            connection.served, connection.due_s = False, time.monotonic() + _HEADERS_S

    async def _serve_socket(self, connection: _Connection, scope: Scope, receive: Receive,
                            send: Send) -> None:
        """Serve a WebSocket, which may idle but must take what is sent."""
        async def send_in_time(message: Scope) -> None:
            connection.due_s = time.monotonic() + _TAKEN_S
            await send(message)
            connection.due_s = math.inf
        connection.due_s = math.inf
        assert self._app is not None
        await self._app(scope, receive, send_in_time)

    async def _keep_sweeping(self) -> None:
        while True:
            await asyncio.sleep(_SWEEP_S)
            self.sweep(time.monotonic())


def _bound_body(receive: Receive) -> Receive:
    """Return what receives a body of bounded length; a longer one counts as cut off."""
    n_bytes = 0

    async def receive_bounded() -> Any:
        nonlocal n_bytes
        message = await receive()
        n_bytes += len(message.get('body', b''))
        return {'type': 'http.disconnect'} if n_bytes > _MOST_BODY else message
    return receive_bounded
