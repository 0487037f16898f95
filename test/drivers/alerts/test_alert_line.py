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

"""The line to the bridge: datagrams in two forms, TCP and a serial line, and what comes back."""

from __future__ import annotations

import os
import re
import socket
import time

from drivers.receiving import DEADLINE_S, free_port, sentence
import pytest

from heading_intercompare.drivers.alerts.alert_line import AlertLine
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings
from heading_intercompare.drivers.framing import Framer

PAIR = ('IIALF,2,1,0,,B,W,V,,10005,1,1,0,JUMP', 'IIALF,2,2,0,,,,,,10005,1,1,0,x: y')
ACN = 'BMACN,093015.00,,10005,1,A,C'


@pytest.fixture
def listener():
    """Return a socket that hears datagrams, and the address of it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as heard:
        heard.bind(('127.0.0.1', 0))
        heard.settimeout(DEADLINE_S)
        yield heard, f'udp://127.0.0.1:{heard.getsockname()[1]}'


def read(line, n=1):
    """Return the first `n` sentences that come back."""
    texts, end = [], time.monotonic() + DEADLINE_S
    while len(texts) < n:
        assert time.monotonic() < end, line.status
        texts += line.read()
    return texts


def test_a_datagram_is_a_sentence(listener):
    heard, place = listener
    line = AlertLine(AlertSettings(destination=place))
    line.send([PAIR])
    assert [heard.recv(200) for _ in PAIR] == [sentence(body) for body in PAIR]
    assert line.read() == [] and line.status == 'no commands are taken'
    line.close()


def test_a_datagram_of_the_ships_network_has_a_tag_block(listener):
    """IEC 61162-450: UdPbC, who sends, which line, and which of a group of sentences."""
    heard, place = listener
    line = AlertLine(AlertSettings(destination=place, form='61162-450', system='HE0007'))
    line.send([PAIR, ('IIHBT,30.0,A,0',), PAIR])
    datagrams = [heard.recv(200) for _ in range(5)]
    tags = [re.fullmatch(rb'UdPbC\0\\(\S+)\*[0-9A-F]{2}\\(\$.*\r\n)', data)
            for data in datagrams]
    assert [found[1] for found in tags] == [
        b'g:1-2-1,s:HE0007,n:0', b'g:2-2-1,s:HE0007,n:1', b's:HE0007,n:2',
        b'g:1-2-2,s:HE0007,n:3', b'g:2-2-2,s:HE0007,n:4']
    assert tags[0][2] == sentence(PAIR[0])
    framer = Framer(datagrams=True)
    assert [frame[2].decode() for data in datagrams for frame in framer.feed(data, 0)] == [
        *PAIR, 'IIHBT,30.0,A,0', *PAIR]
    line.close()


def test_commands_come_by_udp_damaged_ones_do_not(listener):
    port = free_port(socket.SOCK_DGRAM)
    line = AlertLine(AlertSettings(destination=listener[1], commands=f'udp://127.0.0.1:{port}'))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bridge:
        for data in (sentence(ACN).replace(b',A,', b',S,'), b'$' + ACN.encode() + b'\r\n',
                     b'UdPbC\0\\s:BM0001*0F\\' + sentence(ACN)):
            bridge.sendto(data, ('127.0.0.1', port))
    assert read(line) == [ACN.encode()] and line.read() == []
    line.close()


def test_a_network_that_takes_nothing_is_an_error_and_no_end():
    line = AlertLine(AlertSettings(destination='udp://127.0.0.1:9'))
    line._line._socket.close()
    with pytest.raises(OSError):
        line.send([PAIR])
    line.close()


def test_a_tcp_line_has_both_directions_and_connects_again():
    with socket.create_server(('127.0.0.1', 0)) as server:
        server.settimeout(DEADLINE_S)
        line = AlertLine(AlertSettings(
            destination=f'tcp://127.0.0.1:{server.getsockname()[1]}', form='61162-450'))
        with pytest.raises(ConnectionError):
            line.send([PAIR])
        line.read()
        with server.accept()[0] as bridge:
            bridge.sendall(sentence(ACN))
            assert read(line) == [ACN.encode()]
            line.send([('IIHBT,30.0,A,0',)])
            assert bridge.recv(200) == sentence('IIHBT,30.0,A,0')
            bridge.sendall(sentence(ACN)[:9])
        end = time.monotonic() + DEADLINE_S
        while 'connected' in line.status or 'closed' not in line.status:
            line.read()
            assert time.monotonic() < end
        with pytest.raises(ConnectionError):
            line.send([PAIR])
        while 'connected to' not in line.status:
            line.read()
            assert time.monotonic() < end
        with server.accept()[0] as bridge:
            bridge.sendall(sentence(ACN))
            assert read(line) == [ACN.encode()]
        line.close()


def test_a_serial_line_has_both_directions():
    pytest.importorskip('serial')
    bridge, its = os.openpty()
    line = AlertLine(AlertSettings(destination=f'serial:{os.ttyname(its)}?baud=38400'))
    line.send([('IIHBT,30.0,A,0',)])
    assert os.read(bridge, 200) == sentence('IIHBT,30.0,A,0')
    os.write(bridge, sentence(ACN))
    assert read(line) == [ACN.encode()]
    line.close()
    for end in (bridge, its):
        os.close(end)
