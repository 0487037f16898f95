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

"""Connections to the page are bounded, and those that wait give way: also under attack."""

from __future__ import annotations

import asyncio
from contextlib import closing, ExitStack
from importlib.util import find_spec
import json
import os
from pathlib import Path
import socket
import subprocess
import sys
import time
from urllib.parse import urlsplit

from deadlines import DEADLINE_S
import pytest

from heading_intercompare.web.connections import Connections, network_of
from heading_intercompare.web.metrics import DoorCounts

ROOT = Path(__file__).resolve().parents[2]
#: Of the descriptors of the attacked process the page takes half.
DESCRIPTORS = 256
ATTACKER, OFFICER = '127.0.0.7', '127.0.0.8'


@pytest.fixture
def door():
    """Return a function that listens with bounds and connects from an address."""
    with ExitStack() as stack:
        def open_door(most=32, by_address=8):
            connections = Connections(most, by_address)
            listener = socket.socket()
            listener.bind(('127.0.0.1', 0))
            listener = stack.enter_context(closing(connections.listen(listener)))
            listener.listen(64)

            def connect(host='127.0.0.1'):
                client = stack.enter_context(closing(socket.socket()))
                client.bind((host, 0))
                client.connect(listener.getsockname())
                client.settimeout(DEADLINE_S)
                accepted = stack.enter_context(closing(listener.accept()[0]))
                return client, accepted
            return connections, connect
        yield open_door


def is_ended(client):
    """Tell whether the other end has ended a connection."""
    client.settimeout(0.05)
    try:
        return client.recv(1) == b''
    except TimeoutError:
        return False


@pytest.mark.parametrize('host, other, is_same', [
    ('10.0.0.1', '10.0.0.1', True), ('10.0.0.1', '10.0.0.2', False),
    ('::ffff:10.0.0.1', '10.0.0.1', True), ('2001:db8::1', '2001:db8::2:3', True),
    ('2001:db8::1', '2001:db8:0:1::1', False), ('fe80::1%eth0', 'fe80::2', True),
    ('gyro', 'gyro', True)])
def test_a_computer_is_its_address_or_its_network_of_ipv6(host, other, is_same):
    assert (network_of(host) == network_of(other)) is is_same


def test_the_longest_waiting_connection_of_an_address_gives_way(door):
    connections, connect = door(by_address=3)
    officer = connect(OFFICER)[0]
    clients = [connect(ATTACKER)[0] for _ in range(5)]
    assert [is_ended(client) for client in clients] == [True, True, False, False, False]
    assert not is_ended(officer) and connections.count() == DoorCounts(6, ended=2)


def test_a_connection_that_is_served_stays_and_a_new_one_is_refused(door):
    connections, connect = door(by_address=2)
    for _ in range(2):
        connect()[1].served = True
    with pytest.raises(BlockingIOError):
        connect()
    assert connections.count() == DoorCounts(2, refused=1)
    connect(OFFICER)


def test_all_addresses_together_leave_descriptors_for_others(door):
    """What gives way keeps its descriptor until it is closed; those too are within the bound."""
    connections, connect = door(most=12)
    for number in range(20):
        try:
            connect(f'127.0.1.{number}')
        except BlockingIOError:
            pass
    assert connections.count() == DoorCounts(12, 8, connections.ended)


def test_a_closed_connection_makes_room(door):
    connections, connect = door(by_address=1)
    for _ in range(30):
        connect()[1].close()
    assert connections.count() == DoorCounts()


def serve(connection, kind, app, messages=(), during=lambda: None):
    """Serve a request of a connection by an application; call something meanwhile."""
    async def receive():
        return messages.pop(0)

    async def send(message):
        during()

    async def run():
        await connection.connections.wrap(app)(
            {'type': kind, 'client': connection.peer}, receive, send)
    asyncio.run(run())


@pytest.mark.parametrize('wait_s, expected', [(9.0, False), (11.0, True)])
@pytest.mark.parametrize('kind', [None, 'http', 'websocket'])
def test_headers_must_end_in_ten_seconds(door, kind, wait_s, expected):
    """Also those of the next request: a slow one after a quick one was never ended."""
    async def app(scope, receive, send):
        pass
    connections, connect = door()
    client, accepted = connect()
    if kind:
        serve(accepted, kind, app)
    connections.sweep(time.monotonic() + wait_s)
    assert is_ended(client) is expected


@pytest.mark.parametrize('kind, is_sending, wait_s, expected', [
    ('http', False, 59.0, False), ('http', False, 61.0, True), ('websocket', False, 1e9, False),
    ('websocket', True, 19.0, False), ('websocket', True, 21.0, True)])
def test_an_answer_and_a_message_must_be_taken(door, kind, is_sending, wait_s, expected):
    """A browser that reads nothing would let the messages to it pile up."""
    async def app(scope, receive, send):
        if is_sending:
            await send({})
        else:
            sweep()

    def sweep():
        connections.sweep(time.monotonic() + wait_s)
    connections, connect = door()
    client, accepted = connect()
    serve(accepted, kind, app, during=sweep)
    assert is_ended(client) is expected


def test_a_body_is_bounded():
    """The server of the WebSocket gathers a body before it looks at its length."""
    received = []

    async def app(scope, receive, send):
        while (message := await receive())['type'] == 'http.request':
            received.append(len(message['body']))
    connections = Connections(8, 8)
    with closing(socket.socket()) as listener:
        listener.bind(('127.0.0.1', 0))
        bounded = connections.listen(listener)
        bounded.listen()
        with closing(bounded), closing(socket.create_connection(bounded.getsockname())):
            with closing(bounded.accept()[0]) as accepted:
                serve(accepted, 'http', app, [
                    {'type': 'http.request', 'body': bytes(300_000), 'more_body': True}
                    for _ in range(9)])
    assert sum(received) == 900_000


class Page:
    """The page as a process of its own with few descriptors."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, str(ROOT / 'test' / 'web' / 'page_process.py'), str(DESCRIPTORS)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            env={**os.environ, 'PYTHONPATH': str(ROOT)})
        self.address = urlsplit(self._process.stdout.readline().strip())

    def ask(self):
        """Return how many files the process can open, up to 100, and its memory."""
        self._process.stdin.write('\n')
        self._process.stdin.flush()
        return json.loads(self._process.stdout.readline())

    def connect(self, host):
        """Return a connection from an address."""
        return socket.create_connection((self.address.hostname, self.address.port),
                                        DEADLINE_S, (host, 0))

    def get(self, path, host=OFFICER):
        """Return the first line of an answer."""
        with self.connect(host) as client:
            client.sendall(f'GET {path} HTTP/1.1\r\nHost: {self.address.netloc}\r\n'
                           'Connection: close\r\n\r\n'.encode())
            with client.makefile('rb') as answer:
                return answer.readline().decode().strip()

    def close(self):
        """End it."""
        self._process.communicate(timeout=DEADLINE_S)


@pytest.fixture(scope='module')
def page():
    if find_spec('nicegui') is None:
        pytest.skip('NiceGUI is not installed')
    with closing(Page()) as process:
        yield process


@pytest.mark.process
@pytest.mark.parametrize('spread', [1, 200])
def test_slow_connections_leave_files_to_the_recorder_and_the_page_to_others(page, spread):
    """More connections than descriptors kept bag and journal from being written."""
    with ExitStack() as stack:
        for number in range(2 * DESCRIPTORS):
            try:
                client = stack.enter_context(page.connect(f'127.0.3.{number % spread + 1}'))
                client.send(b'GET / HTTP/1.1\r\nHost: x')
            except OSError:
                pass
        assert page.ask()['files'] == 100
        assert page.get('/metrics') == 'HTTP/1.1 200 OK'
        assert page.ask()['files'] == 100


@pytest.mark.process
@pytest.mark.parametrize('head', [b'', b'GET /metrics HTTP/1.1\r\nHost: x\r\nX: '])
def test_endless_headers_are_refused(page, head):
    before = page.ask()['memory_mb']
    with page.connect(ATTACKER) as client, pytest.raises(OSError):
        client.sendall(head)
        for _ in range(1000):
            client.sendall(bytes(b'x' * 100_000))
    assert page.ask()['memory_mb'] < before + 20.0


@pytest.mark.process
def test_pages_that_no_browser_opens_are_bounded_by_address(page):
    """Each was held for a minute, and built by whoever asked."""
    answers = [page.get('/', ATTACKER).split()[1] for _ in range(20)]
    assert answers[:16] == ['200'] * 16 and '503' in answers
    assert page.get('/') == 'HTTP/1.1 200 OK'
