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

"""Requests of other sites are refused."""

from __future__ import annotations

import asyncio

import pytest

from heading_intercompare.web.guard import Guard

HERE = 'http://127.0.0.1:8080'


def ask(kind='http', method='GET', host='127.0.0.1:8080', origin=None, loopback=True):
    """Return whether a request got through, and what was sent instead."""
    passed, sent = [], []

    async def app(scope, receive, send):
        passed.append(scope)

    async def receive():
        return {'type': 'websocket.connect'}

    async def send(message):
        sent.append(message)
    headers = [(b'Host', host.encode())] + ([] if origin is None else
                                            [(b'Origin', origin.encode())])
    scope = {'type': kind, 'method': method, 'headers': headers}
    asyncio.run(Guard(app, loopback)(scope, receive, send))
    return bool(passed), sent


@pytest.mark.parametrize('given', [
    {}, {'method': 'HEAD'}, {'host': 'localhost:8080'}, {'host': '[::1]:8080'},
    {'origin': HERE}, {'method': 'POST', 'origin': HERE}, {'kind': 'websocket', 'origin': HERE},
    {'kind': 'websocket', 'host': 'ship:80', 'origin': 'http://ship:80', 'loopback': False},
    {'kind': 'lifespan', 'host': 'evil'}])
def test_what_comes_from_the_page_gets_through(given):
    assert ask(**given) == (True, [])


@pytest.mark.parametrize('given', [
    {'origin': 'http://evil.example'}, {'method': 'POST'}, {'method': 'POST', 'origin': 'null'},
    {'method': 'DELETE'}, {'host': 'evil.example:8080'},
    {'host': 'evil.example', 'origin': 'http://evil.example', 'method': 'POST'},
    {'kind': 'websocket'}, {'kind': 'websocket', 'origin': 'http://evil.example'},
    {'kind': 'websocket', 'origin': 'http://127.0.0.1:9999'},
    {'kind': 'websocket', 'origin': 'http://evil', 'host': 'ship', 'loopback': False}])
def test_what_comes_from_elsewhere_is_refused(given):
    """Another site, another port, a name that resolves to this computer, or no Origin at all."""
    passed, sent = ask(**given)
    assert not passed
    assert sent[0].get('status', sent[0].get('code')) in (403, 1008)
