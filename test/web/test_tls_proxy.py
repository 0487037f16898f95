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


"""The page behind a proxy that encrypts, as docs/security.md says: TLS before loopback."""

from __future__ import annotations

import asyncio
from concurrent.futures import Future
from contextlib import closing, suppress
import http.client
import shutil
import ssl
import subprocess
import threading
from urllib.parse import urlsplit

from deadlines import DEADLINE_S
import pytest
from web.page_process import serve_page

pytest.importorskip('nicegui')
NAME = 'bridge.example'
UPGRADE = {'Upgrade': 'websocket', 'Connection': 'Upgrade', 'Sec-WebSocket-Version': '13',
           'Sec-WebSocket-Key': 'dGhlIHNhbXBsZSBub25jZQ=='}


@pytest.fixture(scope='module')
def certificate(tmp_path_factory):
    """Return the paths of a certificate that is its own authority, and of its key."""
    if shutil.which('openssl') is None:
        pytest.skip('openssl is not installed')
    folder = tmp_path_factory.mktemp('tls')
    paths = str(folder / 'certificate.pem'), str(folder / 'key.pem')
    subprocess.run(['openssl', 'req', '-x509', '-newkey', 'rsa:2048', '-nodes', '-days', '2',
                    '-subj', f'/CN={NAME}', '-addext', f'subjectAltName=DNS:{NAME}',
                    '-out', paths[0], '-keyout', paths[1]], check=True, capture_output=True)
    return paths


async def pump(reader, writer):
    """Pass bytes on until the sender has ended."""
    with closing(writer), suppress(OSError):
        while data := await reader.read(65536):
            writer.write(data)
            await writer.drain()


class TlsProxy:
    """What nginx or Caddy do for the page: TLS with a certificate, and the Host as it came."""

    def __init__(self, certificate, page_port):
        self._page_port = page_port
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._context.load_cert_chain(*certificate)
        self._port = Future()
        self._thread = threading.Thread(target=asyncio.run, args=(self._run(),))
        self._thread.start()
        self.port = self._port.result(DEADLINE_S)

    async def _run(self):
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        server = await asyncio.start_server(self._serve, '127.0.0.1', 0, ssl=self._context)
        async with server:
            self._port.set_result(server.sockets[0].getsockname()[1])
            await self._ended.wait()

    async def _serve(self, reader, writer):
        to_page = await asyncio.open_connection('127.0.0.1', self._page_port)
        await asyncio.gather(pump(reader, to_page[1]), pump(to_page[0], writer))

    def close(self):
        """End the connections and the thread."""
        self._loop.call_soon_threadsafe(self._ended.set)
        self._thread.join(DEADLINE_S)


class ToProxy(http.client.HTTPSConnection):
    """A browser that has looked up the name of the proxy."""

    def connect(self):
        http.client.HTTPConnection.connect(self)
        self.sock = self._context.wrap_socket(self.sock, server_hostname=NAME)


@pytest.fixture(scope='module')
def ask(certificate):
    """Return a function that asks the page through TLS and returns status and headers."""
    page = serve_page(NAME)
    proxy = TlsProxy(certificate, urlsplit(page.stdout.readline().strip()).port)
    context = ssl.create_default_context(cafile=certificate[0])

    def through(path, **headers):
        connection = ToProxy('127.0.0.1', proxy.port, context=context, timeout=DEADLINE_S)
        connection.request('GET', path, headers={
            'Host': NAME, **{name.replace('_', '-'): text for name, text in headers.items()}})
        with closing(connection), closing(connection.getresponse()) as answer:
            return answer.status, answer.headers
    yield through
    proxy.close()
    page.communicate(timeout=DEADLINE_S)


def test_the_page_is_served_through_tls_under_the_name_of_the_proxy(ask):
    status, headers = ask('/')
    assert status == 200 and "frame-ancestors 'none'" in headers['Content-Security-Policy']


def test_its_websocket_opens_from_the_encrypted_page_and_from_no_other(ask):
    path = '/_nicegui_ws/socket.io/?EIO=4&transport=websocket'
    assert ask(path, Origin=f'https://{NAME}', **UPGRADE)[0] == 101
    assert ask(path, Origin='https://elsewhere.example', **UPGRADE)[0] == 403


def test_a_name_that_was_not_stated_is_refused_through_tls_too(ask):
    assert ask('/', Host='elsewhere.example')[0] == 403
