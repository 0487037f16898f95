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

"""The door of the page: requests of other sites are refused."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
import ipaddress
from typing import Any
from urllib.parse import urlsplit

_Scope = MutableMapping[str, Any]
_Receive = Callable[[], Awaitable[Any]]
_Send = Callable[[_Scope], Awaitable[None]]
_App = Callable[[_Scope, _Receive, _Send], Awaitable[None]]


def is_loopback(host: str) -> bool:
    """
    Tell whether an address reaches this computer only.

    Examples
    --------
    >>> [is_loopback(host) for host in ('127.0.0.1', 'localhost', '::1', '0.0.0.0', 'ship')]
    [True, True, True, False, False]

    """
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Guard:
    """
    An ASGI application around that of the page.

    Parameters
    ----------
    app : callable
        The application of the page.
    loopback
        The page is bound to loopback: then a request must name this computer, so that no site
        that resolves to it can speak for it.

    Notes
    -----
    A page of another site may open a WebSocket to this one. So a WebSocket, and every method but
    GET and HEAD, must bring an Origin that is this page. GET never acts.

    """

    def __init__(self, app: _App, loopback: bool) -> None:
        self._app, self._loopback = app, loopback

    async def __call__(self, scope: _Scope, receive: _Receive, send: _Send) -> None:
        """Pass a request on, or refuse it with 403."""
        if scope['type'] == 'lifespan' or self._accepts(scope):
            await self._app(scope, receive, send)
        elif scope['type'] == 'websocket':
            await receive()
            await send({'type': 'websocket.close', 'code': 1008})
        else:
            await send({'type': 'http.response.start', 'status': 403,
                        'headers': [(b'content-type', b'text/plain')]})
            await send({'type': 'http.response.body', 'body': b'refused: not from this page\n'})

    def _accepts(self, scope: _Scope) -> bool:
        headers = {name.lower(): value.decode('latin-1') for name, value in scope['headers']}
        host, origin = headers.get(b'host', ''), headers.get(b'origin')
        if self._loopback and not is_loopback(urlsplit(f'//{host}').hostname or ''):
            return False
        if origin is None:
            return scope['type'] == 'http' and scope['method'] in ('GET', 'HEAD')
        return bool(urlsplit(origin).netloc == host)
