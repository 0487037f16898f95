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

"""
Sources of bytes: file, UDP, TCP, serial line. They use no threads; nothing runs between reads.

This module has datagrams (UDP) and the lines that may break (TCP, serial), and opens any source.

The kernel stamps a datagram when it arrives, so the stamp is right however late the program reads
it. The kernel also counts the datagrams that it drops because the program reads too slowly.
"""

from __future__ import annotations

from collections import Counter
import errno
import os
import select
import socket
import struct
import time
from typing import Any, Callable, Mapping, Protocol

from .framing import Received
from .playback import FileSource
from .settings import Address, DriverError, DriverSettings

_MAX_READ = 1000
#: How long a line may take to accept what is sent.
_SEND_S = 1.0
#: Constants of Linux that the module `socket` does not have.
_SO_TIMESTAMPNS, _SO_RCVBUFFORCE, _SO_MEMINFO = 35, 33, 55
_TIMESPEC = struct.Struct('@ll')
#: Counters of SO_MEMINFO; the last one counts the drops.
_MEMINFO = struct.Struct('@9I')
_BUFFER_BYTES = 1 << 23
_SECOND_NS = 1_000_000_000
#: Senders named in the status.
_NAMED = 3
#: Senders counted each by itself; addresses can be forged without end.
_MOST_SENDERS, _OTHERS = 1000, 'others'
#: Longest datagram; ten times what an Ethernet frame holds.
_MOST_BYTES = 16_384
_LINE_END = b'\r\n'


class Source(Protocol):
    """
    A source of bytes, as `open_source` returns it.

    Attributes
    ----------
    exhausted
        Nothing more will come.
    status
        Words for a diagnostic.
    counts
        What came and was not returned, by reason.

    """

    @property
    def exhausted(self) -> bool:
        """Whether nothing more will come."""

    @property
    def status(self) -> str:
        """Words for a diagnostic."""

    @property
    def counts(self) -> Mapping[str, int]:
        """Return what came and was not returned, by reason."""

    def read(self, timeout_s: float) -> list[Received]:
        """Return the bytes received; wait at most `timeout_s` for some. May return nothing."""

    def close(self) -> None:
        """Release the file, socket or device."""


class UdpSource:
    """
    Listens for datagrams; joins the group if the host is a multicast address.

    Several processes can listen to one multicast group or broadcast address (`….255`).

    Parameters
    ----------
    settings
        With a source `udp://HOST:PORT`. With the option `from` only datagrams of that sender are
        taken.
    now_ns
        Clock that stamps a datagram where the kernel does not, nanoseconds UTC.

    Attributes
    ----------
    counts
        Datagrams that were not returned: `kernel_dropped`, because the program did not read in
        time, `other_sender`, and `oversized`: longer than 16 384 bytes.

    Raises
    ------
    OSError
        If it cannot listen on the address, or cannot join the group.

    """

    def __init__(self, settings: DriverSettings, now_ns: Callable[[], int] = time.time_ns) -> None:
        self._now_ns, self._address = now_ns, settings.address
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._listening = f'listening on {settings.source}'
        self._senders: Counter[str] = Counter()
        self.exhausted = False
        self.counts: Counter[str] = Counter()
        try:
            self._listen(self._address)
        except OSError as error:
            self._socket.close()
            raise OSError(error.errno, error.strerror or str(error), settings.source) from None

    def _listen(self, address: Address) -> None:
        self._socket.setblocking(False)
        for option in (socket.SO_RCVBUF, _SO_RCVBUFFORCE):
            # The second goes beyond the limit of the system, and needs the rights of root.
            _try_option(self._socket, option, _BUFFER_BYTES)
        _try_option(self._socket, _SO_TIMESTAMPNS, 1)
        if address.multicast or address.host.endswith('.255'):
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind((address.host, address.port))
        if address.multicast:
            member = (socket.inet_aton(address.host)
                      + socket.inet_aton(address.interface or '0.0.0.0'))
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)

    @property
    def status(self) -> str:
        """Return the address listened on, and whose datagrams were taken."""
        if not self._senders:
            return self._listening
        names = [host for host, _ in self._senders.most_common(_NAMED)]
        more = len(self._senders) - len(names)
        return (f'{self._listening}; heard from {", ".join(names)}'
                + (f' and {more} more' if more else ''))

    def read(self, timeout_s: float) -> list[Received]:
        """Return the datagrams received, at most 1000."""
        datagrams: list[Received] = []
        if select.select([self._socket], [], [], timeout_s)[0]:
            while len(datagrams) < _MAX_READ:
                try:
                    data, ancillary, flags, (host, _) = self._socket.recvmsg(
                        _MOST_BYTES, socket.CMSG_SPACE(_TIMESPEC.size))
                except BlockingIOError:
                    break
                if self._address.sender and host != self._address.sender:
                    self.counts['other_sender'] += 1
                    continue
                if flags & socket.MSG_TRUNC:
                    self.counts['oversized'] += 1
                    continue
                is_listed = host in self._senders or len(self._senders) < _MOST_SENDERS
                self._senders[host if is_listed else _OTHERS] += 1
                datagrams.append(Received(data, self._stamp_ns(ancillary), sender=host))
        self._count_drops()
        return datagrams

    def close(self) -> None:
        """Leave the group and close the socket."""
        self._socket.close()

    def _stamp_ns(self, ancillary: list[tuple[int, int, bytes]]) -> int:
        """Return the kernel's stamp of a datagram, or the time now where there is none."""
        for level, kind, data in ancillary:
            if (level, kind) == (socket.SOL_SOCKET, _SO_TIMESTAMPNS):
                sec, nanosec = _TIMESPEC.unpack(data[:_TIMESPEC.size])
                return int(sec * _SECOND_NS + nanosec)
        return self._now_ns()

    def _count_drops(self) -> None:
        try:
            memory = self._socket.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size)
        except OSError:
            return
        if dropped := _MEMINFO.unpack(memory)[-1]:
            self.counts['kernel_dropped'] = dropped


def _try_option(listener: socket.socket, option: int, value: int) -> None:
    """Set an option where the system has it and allows it."""
    try:
        listener.setsockopt(socket.SOL_SOCKET, option, value)
    except OSError:
        pass


class TcpLine:
    """A connection to a TCP server that does not block while connecting."""

    def __init__(self, address: Address) -> None:
        self._address, self._attempts = address, 0
        self._socket: socket.socket | None = None

    def connect(self, timeout_s: float) -> bool:
        """Return whether the server has answered by now; OSError if it refuses."""
        begun = self._begin() if self._socket is None else self._socket
        _, writable, failed = select.select([], [begun], [begun], timeout_s)
        if not (writable or failed):
            return False
        code = begun.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            raise OSError(code, os.strerror(code))
        return True

    def _begin(self) -> socket.socket:
        """Start to connect; each attempt uses the next address of the host name."""
        addresses = socket.getaddrinfo(self._address.host, self._address.port,
                                       type=socket.SOCK_STREAM)
        family, kind, protocol, _, place = addresses[self._attempts % len(addresses)]
        self._attempts += 1
        self._socket = begun = socket.socket(family, kind, protocol)
        begun.setblocking(False)
        begun.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in (('TCP_KEEPIDLE', 10), ('TCP_KEEPINTVL', 5), ('TCP_KEEPCNT', 3)):
            if hasattr(socket, name):
                begun.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        code = begun.connect_ex(place)
        if code not in (0, errno.EINPROGRESS, errno.EWOULDBLOCK):
            raise OSError(code, os.strerror(code))
        return begun

    def is_ready(self) -> bool:
        """Return whether bytes wait to be read, or the connection is broken."""
        assert self._socket is not None
        return bool(select.select([self._socket], [], [], 0.0)[0])

    def receive(self, timeout_s: float) -> bytes:
        """Return the bytes received, maybe none; OSError if the connection is broken."""
        assert self._socket is not None
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return b''
        data = self._socket.recv(65536)
        if not data:
            raise ConnectionError('the server closed the connection')
        return data

    def send(self, data: bytes) -> None:
        """Send bytes; OSError if the connection is broken or takes none for a second."""
        assert self._socket is not None
        self._socket.settimeout(_SEND_S)
        try:
            self._socket.sendall(data)
        finally:
            self._socket.setblocking(False)

    def close(self) -> None:
        """Close the connection, if there is one."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


class _SerialLine:
    """
    A serial device, 8N1.

    Raises
    ------
    DriverError
        If pyserial is not installed.

    """

    def __init__(self, address: Address) -> None:
        try:
            import serial
        except ImportError:
            raise DriverError(f'serial:{address.path} needs pyserial: install python3-serial or '
                              'pip install pyserial') from None
        self._serial, self._address = serial, address
        self._port: Any = None

    def connect(self, timeout_s: float) -> bool:
        """Open the device; OSError if that fails."""
        self._port = self._serial.Serial(self._address.path, self._address.baud,
                                         timeout=timeout_s, write_timeout=_SEND_S,
                                         exclusive=True)
        return True

    def is_ready(self) -> bool:
        """Return whether bytes wait to be read; OSError if the device is gone."""
        return bool(self._port.in_waiting)

    def receive(self, timeout_s: float) -> bytes:
        """Return the bytes received, maybe none; OSError if the device is gone."""
        if self._port.timeout != timeout_s:
            self._port.timeout = timeout_s
        data: bytes = self._port.read(1)
        if data:
            data += self._port.read(self._port.in_waiting)
        return data

    def send(self, data: bytes) -> None:
        """Send bytes; OSError if the device is gone or takes none for a second."""
        self._port.write(data)

    def close(self) -> None:
        """Close the device, if it is open."""
        if self._port is not None:
            self._port.close()
            self._port = None


class LineSource:
    """
    A TCP or serial line that may break; it reconnects every `reconnect_s`.

    When the line breaks, a line end is inserted, so that later bytes do not continue the cut
    sentence.
    """

    def __init__(self, settings: DriverSettings, line: TcpLine | _SerialLine,
                 now_ns: Callable[[], int] = time.time_ns, *,
                 clock: Callable[[], float] = time.monotonic,
                 wait: Callable[[float], Any] = time.sleep) -> None:
        self._source, self._line = settings.source, line
        self._now_ns, self._clock, self._wait = now_ns, clock, wait
        self._reconnect_s, self._retry_at = settings.reconnect_s, clock()
        self._up = False
        #: When the line was last known to hold no unread bytes.
        self._empty_at = clock()
        self.exhausted = False
        self.counts: dict[str, int] = {}
        self.status = f'connecting to {self._source}'

    def read(self, timeout_s: float) -> list[Received]:
        """Return the bytes received, and how long they may have waited; nothing while down."""
        pause = self._retry_at - self._clock()
        if not self._up and pause > 0.0:
            self._wait(min(pause, timeout_s))
            return []
        try:
            if not self._up:
                self.connect(timeout_s)
                return []
            if not self._line.is_ready():
                self._empty_at = self._clock()
            data = self._line.receive(timeout_s)
        except OSError as error:
            return self._drop(str(error))
        now = self._clock()
        late_s, self._empty_at = now - self._empty_at, now
        return [Received(data, self._now_ns(), late_s)] if data else []

    def send(self, data: bytes) -> None:
        """Send bytes; OSError if the line is down, which `read` then connects again."""
        if not self._up:
            raise ConnectionError(None, self.status)
        try:
            self._line.send(data)
        except OSError as error:
            self._drop(str(error))
            raise

    def connect(self, timeout_s: float) -> None:
        """Try to connect; OSError if that fails."""
        self._up = self._line.connect(timeout_s)
        if self._up:
            self._empty_at = self._clock()
            self.status = f'connected to {self._source}'

    def close(self) -> None:
        """Close the line."""
        self._line.close()
        self._up = False

    def _drop(self, why: str) -> list[Received]:
        was_up = self._up
        self.close()
        self._retry_at = self._clock() + self._reconnect_s
        self.status = f'{self._source}: {why}'
        return [Received(_LINE_END, self._now_ns())] if was_up else []


def _open_tcp(settings: DriverSettings, now_ns: Callable[[], int]) -> LineSource:
    return LineSource(settings, TcpLine(settings.address), now_ns)


def _open_serial(settings: DriverSettings, now_ns: Callable[[], int]) -> LineSource:
    """Open the device at once: a wrong name is the user's mistake."""
    source = LineSource(settings, _SerialLine(settings.address), now_ns)
    source.connect(0.0)
    return source


#: Scheme of a source URL -> the function that opens it.
_SOURCES: dict[str, Callable[[DriverSettings, Callable[[], int]], Source]] = {
    'file': FileSource, 'udp': UdpSource, 'tcp': _open_tcp, 'serial': _open_serial}


def open_source(settings: DriverSettings, now_ns: Callable[[], int] = time.time_ns) -> Source:
    """
    Open the source that the settings name.

    Parameters
    ----------
    settings
        Settings with `source` set.
    now_ns
        Clock that stamps the bytes of a live source, nanoseconds UTC.

    Raises
    ------
    SettingsError
        If no source is set, or its URL is wrong.
    OSError
        If the file, port or device cannot be opened. A TCP server need not be up yet: `read`
        connects, and `status` reports the progress.
    DriverError
        If a log is empty or a csv, or pyserial is missing.

    """
    return _SOURCES[settings.address.scheme](settings, now_ns)
