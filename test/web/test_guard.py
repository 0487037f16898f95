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

"""Requests of other sites, to other hosts and for unknown paths are refused."""

from __future__ import annotations

import asyncio
import re

import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.web.guard import Guard, HEADERS, list_names

HERE = 'http://127.0.0.1:8080'
BUSY = '127.0.0.9'
SHIP = {'server': ('192.168.1.10', 8080)}


def ask(kind='http', method='GET', host='127.0.0.1:8080', origin=None, path='/',
        server=('127.0.0.1', 8080), more=(), client=('127.0.0.2', 40000)):
    """Return whether a request got through, and what was sent instead."""
    passed, sent = [], []

    async def app(scope, receive, send):
        passed.append(scope)
        if scope['type'] == 'http':
            await send({'type': 'http.response.start', 'status': 200, 'headers': [
                (b'Referrer-Policy', b'unsafe-url'), (b'content-type', b'text/html'),
                (b'Content-Length', b'16')]})
            for body in (b'<script>', b'</script'):
                await send({'type': 'http.response.body', 'body': body,
                            'more_body': body == b'<script>'})

    async def receive():
        return {'type': 'websocket.connect'}

    async def send(message):
        sent.append(message)
    headers = [(b'Host', host.encode()), *more] + (
        [] if origin is None else [(b'Origin', origin.encode())])
    scope = {'type': kind, 'method': method, 'headers': headers, 'path': path, 'server': server,
             'client': client}
    guard = Guard(app, list_names('0.0.0.0', 'ship, Bridge.example.com'),
                  re.compile('/|/socket'), re.compile('/socket'), lambda host: host != BUSY)
    asyncio.run(guard(scope, receive, send))
    return bool(passed), sent


@pytest.fixture(autouse=True)
def computer(monkeypatch):
    monkeypatch.setattr('socket.gethostname', lambda: 'gyro7')
    monkeypatch.setattr('socket.getfqdn', lambda: 'gyro7.ship')


@pytest.mark.parametrize('given', [
    {}, {'method': 'HEAD'}, {'host': 'localhost:8080'}, {'host': '[::1]:8080'},
    {'origin': HERE}, {'method': 'POST', 'origin': HERE, 'path': '/socket'},
    {'kind': 'websocket', 'origin': HERE, 'path': '/socket'},
    {'kind': 'websocket', 'host': 'ship:80', 'origin': 'http://ship:80', 'path': '/socket',
     **SHIP},
    {'host': 'bridge.example.com', 'origin': 'https://bridge.example.com'},
    {'host': 'gyro7', **SHIP}, {'host': 'gyro7.local', **SHIP}, {'host': 'gyro7.ship', **SHIP},
    {'host': '192.168.1.10:8080', **SHIP}, {'host': '192.168.1.10', **SHIP},
    {'host': '192.168.1.10', 'server': ('::ffff:192.168.1.10', 8080)},
    {'host': '[fe80::1]', 'server': ('fe80::1%eth0', 8080)},
    {'host': 'localhost', 'server': ('::ffff:127.0.0.1', 8080)},
    {'kind': 'lifespan', 'host': 'evil'}])
def test_what_comes_from_the_page_gets_through(given):
    passed, sent = ask(**given)
    assert passed and [message['status'] for message in sent if 'status' in message] == (
        [] if given.get('kind') else [200])


@pytest.mark.parametrize('given', [
    {'origin': 'http://evil.example'}, {'method': 'POST'}, {'method': 'POST', 'origin': 'null'},
    {'method': 'DELETE'}, {'host': 'evil.example:8080'},
    {'host': 'evil.example', 'origin': 'http://evil.example', 'method': 'POST'},
    {'kind': 'websocket'}, {'kind': 'websocket', 'origin': 'http://evil.example'},
    {'kind': 'websocket', 'origin': 'http://127.0.0.1:9999'},
    {'kind': 'websocket', 'origin': 'http://evil', 'host': 'ship', **SHIP},
    {'origin': 'http://[evil', 'host': '[evil'}, {'origin': 'http://[evil'},
    {'more': [(b'origin', HERE.encode())], 'origin': HERE}])
def test_what_comes_from_elsewhere_is_refused(given):
    """Another site, another port, a name that resolves to this computer, or no Origin at all."""
    passed, sent = ask(**given)
    assert not passed
    assert sent[0].get('status', sent[0].get('code')) in (403, 1008)


@pytest.mark.parametrize('given', [
    {'host': 'evil.example'}, {'host': 'evil.example', 'origin': 'http://evil.example'},
    {'host': '203.0.113.9'}, {'host': 'localhost'}, {'host': '127.0.0.1'}, {'host': ''},
    {'host': 'ship.evil.example'}, {'host': '192.168.1.10@evil.example'}, {'server': None},
    {'host': '192.168.1.10', 'more': [(b'host', b'evil.example')]}])
def test_another_host_is_refused_on_every_address(given):
    """A name of another site that resolves to this computer (DNS rebinding)."""
    passed, sent = ask(**{**SHIP, **given})
    assert not passed and sent[0]['status'] == 403
    assert b'dashboard.names' in sent[1]['body']


@pytest.mark.parametrize('given, status', [
    ({'path': '/admin'}, 404), ({'path': '//'}, 404), ({'path': '/\n'}, 404), ({'path': ''}, 404),
    ({'path': '/admin', 'method': 'POST', 'origin': HERE}, 404),
    ({'client': (BUSY, 40000)}, 503),
    ({'method': 'POST', 'origin': HERE}, 405), ({'method': 'OPTIONS', 'origin': HERE}, 405)])
def test_unknown_paths_methods_and_more_pages_are_refused(given, status):
    passed, sent = ask(**given)
    assert not passed and sent[0]['status'] == status


@pytest.mark.parametrize('given', [{}, {'path': '/admin'}, {'host': 'evil.example'}])
def test_every_answer_tells_the_browser_what_the_page_may_do(given):
    headers = ask(**given)[1][0]['headers']
    assert [header for header in headers if header in HEADERS] == [*HEADERS]
    assert len({name.lower() for name, _ in headers}) == len(headers)
    policy = dict(headers)[b'content-security-policy'].decode()
    assert "script-src 'self'" in policy and "frame-ancestors 'none'" in policy
    assert "script-src 'self' 'unsafe-inline'" not in policy


def test_the_scripts_of_each_page_have_a_mark_of_their_own():
    """A script that somebody smuggled into a message or note has none, and does not run."""
    pages = [ask()[1] for _ in range(2)]
    marks = [re.search("'nonce-([^']{20,})'", str(page[0]['headers'])).group(1) for page in pages]
    assert marks[0] != marks[1]
    for page, mark in zip(pages, marks):
        body = f'<script nonce="{mark}"></script'.encode()
        assert page[1:] == [{'type': 'http.response.body', 'body': body}]
        assert dict(page[0]['headers'])[b'content-length'] == str(len(body)).encode()


@pytest.mark.parametrize('names', ['https://ship', 'ship:8080', 'a b', 'ship, *', '-ship'])
def test_a_wrong_name_is_refused_in_one_line(names):
    with pytest.raises(SettingsError, match='^names = .*: must be|must be the name') as refused:
        list_names('0.0.0.0', names)
    assert '\n' not in str(refused.value)
