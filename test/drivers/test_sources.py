# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""UDP, TCP and a serial line, over the loopback of this machine and a pseudo-terminal."""

from __future__ import annotations

from contextlib import closing
import os
import socket
import sys
import time

import pytest

from heading_intercompare.core.settings import SettingsError
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverError, DriverSettings
from heading_intercompare.drivers.sources import LineSource, open_source, TcpLine, UdpSource

HDT = [b'$HEHDT,1.0,T*2E\r\n', b'$HEHDT,2.0,T*2D\r\n', b'$HEHDT,3.0,T*2C\r\n']
GROUP = '239.192.0.3'
DEADLINE_S = 10.0


def counting():
    """Return a clock that counts its readings, so that stamps can be told apart."""
    readings = iter(range(1, 10**6))
    return lambda: next(readings)


def read_until(source, done):
    """Read until `done(bytes received)`, at most ten seconds."""
    received, end = [], time.monotonic() + DEADLINE_S
    while not done(received):
        assert time.monotonic() < end, f'only {received} came; {source.status}'
        received += source.read(0.5)
    return received


def joined(received) -> bytes:
    return b''.join(data for _, data in received)


def free_port(kind: int) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(('127.0.0.1', 0))
        return probe.getsockname()[1]


def test_no_source_and_a_wrong_one_are_refused():
    with pytest.raises(SettingsError, match='source is required'):
        open_source(DriverSettings())


def test_datagrams_come_one_by_one_with_their_time_of_receipt():
    port = free_port(socket.SOCK_DGRAM)
    settings = DriverSettings(source=f'udp://127.0.0.1:{port}', sentence='HDT')
    with closing(open_source(settings, counting())) as source, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        assert source.read(0.0) == []
        for line in HDT:
            sender.sendto(line, ('127.0.0.1', port))
        received = read_until(source, lambda got: len(got) == 3)
        assert received == list(zip([1, 2, 3], HDT))
        decoder = NmeaDecoder(settings)
        headings = [decoder.feed(data, ns) for ns, data in received]
        assert [h.heading_deg.tolist() for h in headings] == [[1.0], [2.0], [3.0]]
        assert not source.exhausted


def test_a_port_that_is_taken_is_an_error_that_names_the_source():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.1', 0))
        source = f'udp://127.0.0.1:{other.getsockname()[1]}'
        with pytest.raises(OSError, match='in use') as caught:
            open_source(DriverSettings(source=source))
        assert caught.value.filename == source


def multicast(port: int) -> UdpSource:
    try:
        return open_source(DriverSettings(
            source=f'udp://{GROUP}:{port}?interface=127.0.0.1'))
    except OSError as error:
        pytest.skip(f'the kernel refuses to join a multicast group: {error}')


def test_every_listener_of_a_multicast_group_hears_it():
    port = free_port(socket.SOCK_DGRAM)
    with closing(multicast(port)) as one, closing(multicast(port)) as two, \
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF,
                          socket.inet_aton('127.0.0.1'))
        data = b'UdPbC\0\\s:GY0001*56\\' + HDT[0]
        try:
            sender.sendto(data, (GROUP, port))
        except OSError as error:
            pytest.skip(f'the kernel refuses to send to a multicast group: {error}')
        for source in (one, two):
            assert joined(read_until(source, len)) == data


def test_an_interface_that_does_not_exist_is_an_error_that_names_the_source():
    source = f'udp://{GROUP}:60003?interface=192.0.2.1'
    with pytest.raises(OSError) as caught:
        open_source(DriverSettings(source=source))
    assert caught.value.filename == source


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
                with peer:
                    peer.sendall(HDT[0] + HDT[1] + broken)
                received = read_until(source, lambda _: 'closed' in source.status)
                assert joined(received) == HDT[0] + HDT[1] + broken + b'\r\n'
                headings += [h for ns, data in received
                             for h in decoder.feed(data, ns).heading_deg.tolist()]
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
        headings = [h for ns, data in received
                    for h in decoder.feed(data, ns).heading_deg.tolist()]
        assert headings == [2.0, 3.0] and decoder.counts == {'no_sentence': 1}


def test_a_serial_line_that_is_unplugged_is_a_status(pty):
    ends, device = pty
    settings = DriverSettings(source=f'serial:{device}', reconnect_s=0.1)
    with closing(open_source(settings)) as source:
        assert source.status.startswith('connected')
        os.close(ends.pop('slave'))
        os.close(ends.pop('master'))
        assert read_until(source, len)[0][1] == b'\r\n'
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
