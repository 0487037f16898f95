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

"""UDP, TCP and a serial line, over the loopback of this machine and a pseudo-terminal."""

from __future__ import annotations

from contextlib import closing
from functools import partial
import os
import socket
import sys
import time

from drivers.receiving import DEADLINE_S, free_port, HDT, joined, read_until
import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.drivers.sources import LineSource, open_source, TcpLine


def counting():
    """Return a clock that counts its readings, so that stamps can be told apart."""
    readings = iter(range(1, 10**6))
    return lambda: next(readings)


def has_come(n, received) -> bool:
    return len(joined(received)) >= n


def test_no_source_and_a_wrong_one_are_refused():
    with pytest.raises(SettingsError, match='source is required'):
        open_source(DriverSettings())


def test_a_tcp_client_reads_and_connects_again_when_the_line_breaks():
    with socket.create_server(('127.0.0.1', 0)) as server:
        settings = DriverSettings(source=f'tcp://127.0.0.1:{server.getsockname()[1]}',
                                  sentence='HDT', reconnect_s=0.1)
        decoder = NmeaDecoder(settings)
        headings = []
        with closing(open_source(settings, counting())) as source:
            for broken in (b'$HEHDT,9', b''):
                read_until(source, lambda _: source.status.startswith('connected'))
                peer = server.accept()[0]
                received = []
                with peer:
                    for part in (HDT[0], HDT[1] + broken):
                        peer.sendall(part)
                        received += read_until(source, partial(has_come, len(part)))
                received += read_until(source, lambda _: 'closed' in source.status)
                assert joined(received) == HDT[0] + HDT[1] + broken + b'\r\n'
                headings += [h for came in received
                             for h in decoder.feed(*came).heading_deg.tolist()]
        assert headings == [1.0, 2.0, 1.0, 2.0]
        assert decoder.counts == {'no_checksum': 1}


def test_a_server_that_is_not_there_is_a_status_and_tried_again_only_in_time():
    port, now = free_port(socket.SOCK_STREAM), [0.0]
    settings = DriverSettings(source=f'tcp://127.0.0.1:{port}', reconnect_s=5.0)
    waits = []
    source = LineSource(settings, TcpLine(settings.address), clock=lambda: now[0],
                        wait=waits.append)
    with closing(source):
        read_until(source, lambda _: 'refused' in source.status)
        assert source.read(1.0) == [] and waits == [1.0]
        now[0] = 4.5
        assert source.read(1.0) == [] and waits == [1.0, 0.5]
        with socket.create_server(('127.0.0.1', port)):
            now[0] = 5.0
            read_until(source, lambda _: source.status.startswith('connected'))


@pytest.fixture
def pty():
    """Return both ends of a pseudo-terminal: what is written to, the name of the device."""
    pytest.importorskip('serial', reason='pyserial is not installed')
    if sys.platform == 'win32':
        pytest.skip('no pseudo-terminals here')
    master, slave = os.openpty()
    ends = {'master': master, 'slave': slave}
    yield ends, os.ttyname(slave)
    for end in ends.values():
        os.close(end)


def test_a_serial_line_gives_sentences_byte_by_byte(pty):
    ends, device = pty
    settings = DriverSettings(source=f'serial:{device}?baud=9600', sentence='HDT')
    decoder = NmeaDecoder(settings)
    with closing(open_source(settings, counting())) as source:
        assert source.read(0.0) == []
        os.write(ends['master'], b'1.0,T*2E\r\n' + HDT[1][:9])
        received = read_until(source, lambda got: joined(got).endswith(HDT[1][:9]))
        os.write(ends['master'], HDT[1][9:] + HDT[2])
        received += read_until(source, lambda got: joined(got).endswith(HDT[2]))
        headings = [h for came in received for h in decoder.feed(*came).heading_deg.tolist()]
        assert headings == [2.0, 3.0] and decoder.counts == {'no_sentence': 1}


def test_a_serial_line_that_is_unplugged_is_a_status(pty):
    ends, device = pty
    settings = DriverSettings(source=f'serial:{device}', reconnect_s=0.1)
    with closing(open_source(settings)) as source:
        assert source.status.startswith('connected')
        os.close(ends.pop('slave'))
        os.close(ends.pop('master'))
        assert read_until(source, len)[0].data == b'\r\n'
        assert not source.status.startswith('connected')
        assert source.read(0.2) == [] and not source.exhausted


def test_a_device_that_does_not_exist_is_an_error_that_names_it():
    pytest.importorskip('serial', reason='pyserial is not installed')
    with pytest.raises(OSError, match='/dev/no-such-device'):
        open_source(DriverSettings(source='serial:/dev/no-such-device'))


def test_without_pyserial_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, 'serial', None)
    with pytest.raises(DriverError, match='needs pyserial: install python3-serial'):
        open_source(DriverSettings(source='serial:/dev/ttyS0'))


def test_bytes_that_waited_in_the_kernel_say_how_long():
    """The server sends while nobody reads: the bound is the time since the line was empty."""
    now = [0.0]
    with socket.create_server(('127.0.0.1', 0)) as server:
        settings = DriverSettings(source=f'tcp://127.0.0.1:{server.getsockname()[1]}')
        source = LineSource(settings, TcpLine(settings.address), clock=lambda: now[0])
        with closing(source):
            read_until(source, lambda _: source.status.startswith('connected'))
            with server.accept()[0] as peer:
                assert source.read(0.0) == []
                now[0] = 5.0
                peer.sendall(HDT[0])
                (came,) = read_until(source, len)
                assert came.late_s in (0.0, 5.0)
                peer.sendall(HDT[1])
                deadline = time.monotonic() + DEADLINE_S
                while not source._line.is_ready():
                    assert time.monotonic() < deadline
                now[0] = 8.0
                assert source.read(0.0)[0].late_s == 3.0
