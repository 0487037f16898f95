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

"""The server of the live page: a thread of its own, on loopback unless the user decides."""

from __future__ import annotations

from functools import partial
import re
import socket
import threading
import time
from typing import Any, Sequence

from heading_intercompare.core.declared_settings import SettingsError

from .connections import Connections, MOST, raise_descriptors
from .controls import Controls
from .guard import Guard, is_loopback, list_names
from .metrics import CONTENT_TYPE, metrics_text
from .tokens import make_token, NamedToken

_START_S = 20.0
#: Bytes of a message from a browser: a note, a token, a tap.
_MOST_MESSAGE = 100_000
_SOCKET = '/_nicegui_ws/socket[.]io/?'
#: All that NiceGUI and this module serve; NiceGUI would answer every other path with the page.
_PATHS = ('/|/metrics|/favicon[.]ico|' + _SOCKET + '|/_nicegui/{version}/'
          '(static|libraries|components|resources|dynamic_resources|esm)/.+')


def _bind(host: str, port: int) -> socket.socket:
    """Return a listening socket; SettingsError if the address cannot be used."""
    try:
        family, kind, number, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        listener = socket.socket(family, kind, number)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(address)
        except OSError:
            listener.close()
            raise
    except (OSError, OverflowError) as error:
        why = getattr(error, 'strerror', None) or str(error)
        raise SettingsError(f'the page cannot be served on {host}:{port}: {why}; choose another '
                            'address or port') from error
    return listener


class PageServer:
    """
    Serves the page until it is closed; there can be one per process.

    Parameters
    ----------
    controls
        The graph.
    host
        Address to bind; other than loopback, write actions need a token.
    port
        TCP port; 0: any free one.
    tokens
        The tokens that actions need; without one, one is made if `host` is not loopback.
    names
        Further names under which the page is reached, with commas between them.
    connections_by_address
        Most connections of one address.

    Attributes
    ----------
    url : str
        Address of the page.
    token_made : str or None
        The token that was made here; the user must be told it.

    Raises
    ------
    SettingsError
        If NiceGUI is not installed, or the address cannot be used; one line.

    """

    def __init__(self, controls: Controls, *, host: str = '127.0.0.1', port: int = 8080,
                 tokens: Sequence[NamedToken] = (), names: str | None = None,
                 connections_by_address: int = 64) -> None:
        known_names = list_names(host, names)
        made = () if tokens or is_loopback(host) else (make_token(),)
        self.token_made = made[0].token if made else None
        try:
            from fastapi import FastAPI, Response
            from nicegui import __version__, ui
            import uvicorn

            from .page import build, Drawings, has_room
        except ImportError as error:
            raise SettingsError("the page needs NiceGUI: pip install 'heading_intercompare[web]'"
                                ) from error
        self.connections = Connections(min(MOST, raise_descriptors() // 2),
                                       connections_by_address)
        self._socket = self.connections.listen(_bind(host, port))
        shown = f'[{host}]' if ':' in host else host
        self.url = f'http://{shown}:{self._socket.getsockname()[1]}/'
        app: Any = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
        app.add_api_route('/metrics', lambda: Response(
            metrics_text(*controls.look(), self.connections.count()), media_type=CONTENT_TYPE))
        ui.run_with(app, root=partial(build, controls, [*tokens, *made], Drawings()),
                    title='Heading intercompare', show_welcome_message=False, tailwind=False,
                    reconnect_timeout=5.0)
        guard = Guard(app, known_names, re.compile(_PATHS.format(version=re.escape(__version__))),
                      re.compile(_SOCKET), partial(has_room, connections_by_address))
        # The event loop of Python takes connections from our socket; h11 bounds the headers.
        self._server = uvicorn.Server(uvicorn.Config(
            self.connections.wrap(guard), log_level='error', lifespan='on', server_header=False,
            proxy_headers=False, timeout_graceful_shutdown=1, loop='asyncio', http='h11',
            interface='asgi3', backlog=self.connections.backlog, ws_max_size=_MOST_MESSAGE))
        self._thread = threading.Thread(target=self._serve, name='page', daemon=True)
        self._thread.start()
        deadline_s = time.monotonic() + _START_S
        while not self._server.started and self._thread.is_alive():
            if time.monotonic() > deadline_s:
                break
            self._thread.join(0.02)
        if not self._server.started:
            raise SettingsError(f'the page could not be started on {self.url}')

    def _serve(self) -> None:
        self._server.run(sockets=[self._socket])

    def close(self) -> None:
        """Stop serving."""
        self._server.should_exit = True
        self._thread.join(5.0)
        self._socket.close()
