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

"""UDP over the loopback of this machine: stamps of the kernel, drops, senders, multicast."""

from __future__ import annotations

from contextlib import closing
import socket
import time

from drivers.receiving import DEADLINE_S, free_port, HDT, joined, read_until
import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers import sources
from heading_intercompare.drivers.nmea import NmeaDecoder
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.drivers.sources import open_source, UdpSource

GROUP = '239.192.0.3'
# A busy kernel delivers a datagram some time after it was sent.
DELIVERY_NS = 250_000_000


@pytest.fixture
def listen():
    """Return a function that opens a source on a free port, and a socket that sends to it."""
    opened = []

    def open_(options='', now_ns=time.time_ns):
        port = free_port(socket.SOCK_DGRAM)
        source = open_source(DriverSettings(source=f'udp://127.0.0.1:{port}{options}'), now_ns)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sender.connect(('127.0.0.1', port))
        opened.extend((source, sender))
        return source, sender

    yield open_
    for each in opened:
        each.close()


def pass_time(span_ns: int) -> int:
    """Return the time once a span of it has passed."""
    end_ns = time.time_ns() + span_ns
    while time.time_ns() < end_ns:
        pass
    return time.time_ns()


def await_stamps(source, sender):
    """Wait until the kernel stamps: it begins a moment after the first socket asked for stamps."""
    end, reading_ns, stamp_ns = time.monotonic() + DEADLINE_S, 0, 1
    while stamp_ns >= reading_ns:
        assert time.monotonic() < end, 'the kernel does not stamp'
        sender.send(b'first\r\n')
        reading_ns = pass_time(5_000_000)
        stamp_ns = read_until(source, lambda got: got)[0].stamp_ns


def test_a_datagram_has_the_stamp_of_the_kernel_however_late_it_is_read(listen):
    """Each is stamped when it comes, and read at least half a second later."""
    source, sender = listen(now_ns=lambda: 0)
    await_stamps(source, sender)
    spans = []
    for line in HDT:
        before_ns = time.time_ns()
        sender.send(line)
        spans.append((before_ns, time.time_ns() + DELIVERY_NS))
    pass_time(2 * DELIVERY_NS)
    received = read_until(source, lambda got: len(got) == 3)
    for came, line, (before_ns, after_ns) in zip(received, HDT, spans):
        assert came.data == line and before_ns <= came.stamp_ns <= after_ns
        assert came.late_s == 0.0
    decoder = NmeaDecoder(DriverSettings(source='udp://:1', sentence='HDT'))
    assert [decoder.feed(*came).heading_deg.tolist() for came in received] == [[1.], [2.], [3.]]


def test_without_stamps_of_the_kernel_the_clock_of_the_program_stamps(listen, monkeypatch):
    monkeypatch.setattr(sources, '_SO_TIMESTAMPNS', 10_000)
    source, sender = listen(now_ns=lambda: 7)
    sender.send(HDT[0])
    assert read_until(source, len)[0].stamp_ns == 7


def test_datagrams_that_the_kernel_drops_are_counted_to_the_last(listen):
    """More than any buffer takes; the last ones are dropped, and no datagram follows them."""
    source, sender = listen()
    source._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 14)
    for _ in range(3000):
        sender.send(HDT[0])
    taken = 0
    while datagrams := source.read(0.0):
        taken += len(datagrams)
    assert 0 < taken < 3000 and source.counts == {'kernel_dropped': 3000 - taken}


def test_datagrams_of_other_senders_are_counted_and_left_out(listen):
    source, sender = listen('?from=127.0.0.2')
    sender.send(HDT[0])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.2', 0))
        other.sendto(HDT[1], sender.getpeername())
        assert joined(read_until(source, len)) == HDT[1]
    assert source.counts == {'other_sender': 1}
    assert source.status.endswith('heard from 127.0.0.2')


def test_the_status_names_the_hosts_that_send(listen):
    source, sender = listen()
    assert 'heard from' not in source.status
    for host in ('127.0.0.1', '127.0.0.2', '127.0.0.3', '127.0.0.4'):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
            one.bind((host, 0))
            one.sendto(HDT[0], sender.getpeername())
    read_until(source, lambda got: len(got) == 4)
    assert source.status.endswith('and 1 more')


def test_a_sender_that_is_no_address_is_refused():
    with pytest.raises(SettingsError, match='from must be the IPv4 address of the sender'):
        DriverSettings(source='udp://:10110?from=gyro')


def test_a_port_that_is_taken_is_an_error_that_names_the_source():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(('127.0.0.1', 0))
        source = f'udp://127.0.0.1:{other.getsockname()[1]}'
        with pytest.raises(OSError, match='in use') as caught:
            open_source(DriverSettings(source=source))
        assert caught.value.filename == source


def open_multicast(port: int) -> UdpSource:
    try:
        return open_source(DriverSettings(
            source=f'udp://{GROUP}:{port}?interface=127.0.0.1'))
    except OSError as error:
        pytest.skip(f'the kernel refuses to join a multicast group: {error}')


def test_every_listener_of_a_multicast_group_hears_it():
    port = free_port(socket.SOCK_DGRAM)
    with closing(open_multicast(port)) as one, closing(open_multicast(port)) as two, \
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
