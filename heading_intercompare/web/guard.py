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

"""The door of the page: it refuses requests of other sites and hosts, and for unknown paths."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, MutableMapping
from functools import partial
import ipaddress
import re
import secrets
import socket
from typing import Any, Sequence
from urllib.parse import urlsplit

from heading_intercompare.core.declared_settings import SettingsError

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Any]]
Send = Callable[[Scope], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

_NAME = re.compile('[a-z0-9_]([a-z0-9_.-]*[a-z0-9_])?')

#: NiceGUI writes the page into inline styles.
_POLICY = ("default-src 'none'; script-src 'self'%s; style-src 'self' 'unsafe-inline'; "
           "img-src 'self' data:; font-src 'self'; connect-src 'self'; base-uri 'none'; "
           "form-action 'none'; frame-ancestors 'none'")

HEADERS = ((b'x-frame-options', b'DENY'), (b'x-content-type-options', b'nosniff'),
           (b'referrer-policy', b'same-origin'),
           (b'cross-origin-opener-policy', b'same-origin'),
           (b'cross-origin-resource-policy', b'same-origin'))
"""What every answer tells the browser, beside the policy for its content."""

_NOT_FOUND = 404, 'not found'
_NO_METHOD = 405, 'this method is not allowed'
_BUSY = 503, 'too many pages are open; try once more in a minute'
_FOREIGN = 403, 'refused: not from this page'
_HOST = 403, ('refused: the page is not known under this name; use its address, or state the name '
              'in dashboard.names')


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
    address = read_address(host)
    return address is not None and address.is_loopback


def read_address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return an address without zone, and as IPv4 if it is one in IPv6; None for a name."""
    try:
        address = ipaddress.ip_address(text.partition('%')[0])
    except ValueError:
        return None
    return getattr(address, 'ipv4_mapped', None) or address


def list_names(host: str, names: str | None) -> frozenset[str]:
    """
    Return the names under which the page may be reached, beside the addresses of its computer.

    Parameters
    ----------
    host
        The address or name that the page is bound to.
    names
        Names that the user states, with commas between them.

    Raises
    ------
    SettingsError
        If one is no name of a computer.

    """
    stated = [name.strip().lower() for name in (names or '').split(',') if name.strip()]
    for name in stated:
        if not _NAME.fullmatch(name):
            raise SettingsError(f'names = {names!r}: {name!r} must be the name or address of a '
                                'computer, without scheme and port, e.g. ship.example.com')
    own = socket.gethostname().lower()
    usual = (host.lower(), own, f'{own}.local', socket.getfqdn().lower())
    return frozenset((*stated, *(name for name in usual if not is_loopback(name))))


class Guard:
    """
    An ASGI application around that of the page.

    Parameters
    ----------
    app : callable
        The application of the page.
    names
        Names under which the page may be reached; see `list_names`. A request must name one of
        them, or the address at which it came in. So no site whose name resolves to this computer
        can speak for it.
    paths
        All paths that there are.
    written
        Those of them that take other methods than GET and HEAD.
    has_room
        Tells whether one more page may be built for an address.

    Notes
    -----
    A page of another site may open a WebSocket to this one. So a WebSocket, and every method but
    GET and HEAD, must bring an Origin that is this page. GET never acts.

    """

    def __init__(self, app: App, names: Collection[str], paths: re.Pattern[str],
                 written: re.Pattern[str], has_room: Callable[[str], bool]) -> None:
        self._app, self._names, self._paths, self._written = app, names, paths, written
        self._has_room = has_room

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        if scope['type'] == 'lifespan':
            await self._app(scope, receive, send)
            return
        refusal = self._refuse(scope)
        if refusal is None and scope['type'] == 'http' and scope['path'] == '/':
            plain = [header for header in scope['headers'] if header[0] != b'accept-encoding']
            await self._app({**scope, 'headers': plain}, receive, _mark_scripts(send))
        elif refusal is None:
            await self._app(scope, receive, partial(_add_headers, send))
        elif scope['type'] == 'websocket':
            await receive()
            await send({'type': 'websocket.close', 'code': 1008})
        else:
            await answer(partial(_add_headers, send), *refusal)

    def _refuse(self, scope: Scope) -> tuple[int, str] | None:
        """Return the status and the words by which a request is refused; None for a good one."""
        hosts, origins = ([value.decode('latin-1') for name, value in scope['headers']
                           if name.lower() == wanted] for wanted in (b'host', b'origin'))
        if len(hosts) != 1 or not self._is_here(_host_name(hosts[0]), scope.get('server')):
            return _HOST
        reads = scope['type'] == 'http' and scope['method'] in ('GET', 'HEAD')
        if (origins or not reads) and [_netloc(origin) for origin in origins] != hosts:
            return _FOREIGN
        if not self._paths.fullmatch(scope['path']):
            return _NOT_FOUND
        if not reads and not self._written.fullmatch(scope['path']):
            return _NO_METHOD
        is_page = scope['path'] == '/'
        return _BUSY if is_page and not self._has_room((scope.get('client') or ('',))[0]) else None

    def _is_here(self, host: str, server: Sequence[Any] | None) -> bool:
        """Tell whether a host is this computer, given the address at which the request came."""
        here = str(server[0]) if server else ''
        address = read_address(host)
        return (host in self._names or is_loopback(host) and is_loopback(here)
                or address is not None and address == read_address(here))


def _host_name(host: str) -> str:
    """Return the name in a Host header in small letters; '' if there is none."""
    try:
        return urlsplit(f'//{host}').hostname or ''
    except ValueError:
        return ''


def _netloc(origin: str) -> str:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return ''


async def _add_headers(send: Send, message: Scope, scripts: str = '') -> None:
    """Send a message, with the policy for the content if it begins an answer."""
    if message['type'] == 'http.response.start':
        headers = (*HEADERS, (b'content-security-policy', (_POLICY % scripts).encode()))
        names = {name for name, _ in headers}
        message = {**message, 'headers': [
            *((name, value) for name, value in message.get('headers', ())
              if name.lower() not in names), *headers]}
    await send(message)


def _mark_scripts(send: Send) -> Send:
    """Return what sends the page: its scripts, and no others, have the mark of the answer."""
    mark, start, body = secrets.token_urlsafe(16), dict[str, Any](), bytearray()
    # NiceGUI writes the page into inline scripts, and Vue compiles its templates by eval.
    scripts = f" 'nonce-{mark}' 'unsafe-eval'"

    async def send_marked(message: Scope) -> None:
        if message['type'] == 'http.response.start':
            start.update(message)
            return
        body.extend(message.get('body', b''))
        if message.get('more_body'):
            return
        marked = body.replace(b'<script', f'<script nonce="{mark}"'.encode())
        headers = [(name, value) for name, value in start.get('headers', ())
                   if name.lower() != b'content-length']
        headers.append((b'content-length', str(len(marked)).encode()))
        await _add_headers(send, {**start, 'headers': headers}, scripts)
        await send({'type': 'http.response.body', 'body': bytes(marked)})
    return send_marked


async def answer(send: Send, status: int, words: str) -> None:
    """Send an answer of one line."""
    body = f'{words}\n'.encode()
    await send({'type': 'http.response.start', 'status': status, 'headers': [
        (b'content-type', b'text/plain; charset=utf-8'),
        (b'content-length', str(len(body)).encode())]})
    await send({'type': 'http.response.body', 'body': body})
