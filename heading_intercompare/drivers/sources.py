# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Sources of bytes: file, UDP, TCP, serial line. They use no threads; nothing runs between reads.

Every source has `read(timeout_s) -> list of (received_ns, bytes)`, `exhausted`, `status` (words
for a diagnostic) and `close()`.
"""

from __future__ import annotations

import errno
import os
import select
import socket
import time
from typing import Any, Callable, Protocol

from .playback import FileSource
from .settings import Address, DriverError, DriverSettings

__all__ = ['FileSource', 'LineSource', 'open_source', 'Source', 'TcpLine', 'UdpSource']

_MAX_READ = 1000
_LINE_END = b'\r\n'


class Source(Protocol):
    """A source of bytes, as `open_source` returns it."""

    exhausted: bool
    status: str

    def read(self, timeout_s: float) -> list[tuple[int | None, bytes]]:
        """Return the bytes received; wait at most `timeout_s` for some. May return nothing."""

    def close(self) -> None:
        """Release the file, socket or device."""


class UdpSource:
    """
    Listens for datagrams; joins the group if the host is a multicast address.

    Several processes can listen to one multicast group or broadcast address (`….255`).

    Raises
    ------
    OSError
        If it cannot listen on the address, or cannot join the group.

    """

    def __init__(self, settings: DriverSettings, now_ns: Callable[[], int] = time.time_ns) -> None:
        self._now_ns = now_ns
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.exhausted = False
        self.status = f'listening on {settings.source}'
        try:
            self._listen(settings.address)
        except OSError as error:
            self._socket.close()
            raise OSError(error.errno, error.strerror or str(error), settings.source) from None

    def _listen(self, address: Address) -> None:
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        if address.multicast or address.host.endswith('.255'):
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind((address.host, address.port))
        if address.multicast:
            member = (socket.inet_aton(address.host)
                      + socket.inet_aton(address.interface or '0.0.0.0'))
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)

    def read(self, timeout_s: float) -> list[tuple[int | None, bytes]]:
        """Return the datagrams received, at most 1000."""
        datagrams: list[tuple[int | None, bytes]] = []
        if select.select([self._socket], [], [], timeout_s)[0]:
            while len(datagrams) < _MAX_READ:
                try:
                    data = self._socket.recv(65536)
                except BlockingIOError:
                    break
                datagrams.append((self._now_ns(), data))
        return datagrams

    def close(self) -> None:
        """Leave the group and close the socket."""
        self._socket.close()


class TcpLine:
    """A connection to a TCP server that does not block while connecting."""

    def __init__(self, address: Address) -> None:
        self._address, self._attempts = address, 0
        self._socket: socket.socket | None = None

    def connect(self, timeout_s: float) -> bool:
        """Return whether the server has answered by now; OSError if it refuses."""
        if self._socket is None:
            self._begin()
        _, writable, failed = select.select([], [self._socket], [self._socket], timeout_s)
        if not (writable or failed):
            return False
        code = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if code:
            raise OSError(code, os.strerror(code))
        return True

    def _begin(self) -> None:
        """Start to connect; each attempt uses the next address of the host name."""
        found = socket.getaddrinfo(self._address.host, self._address.port,
                                   type=socket.SOCK_STREAM)
        family, kind, protocol, _, place = found[self._attempts % len(found)]
        self._attempts += 1
        self._socket = socket.socket(family, kind, protocol)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in (('TCP_KEEPIDLE', 10), ('TCP_KEEPINTVL', 5), ('TCP_KEEPCNT', 3)):
            if hasattr(socket, name):
                self._socket.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
        code = self._socket.connect_ex(place)
        if code not in (0, errno.EINPROGRESS, errno.EWOULDBLOCK):
            raise OSError(code, os.strerror(code))

    def receive(self, timeout_s: float) -> bytes:
        """Return the bytes received, maybe none; OSError if the connection is broken."""
        if not select.select([self._socket], [], [], timeout_s)[0]:
            return b''
        data = self._socket.recv(65536)
        if not data:
            raise ConnectionError('the server closed the connection')
        return data

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
        self._serial, self._address, self._port = serial, address, None

    def connect(self, timeout_s: float) -> bool:
        """Open the device; OSError if that fails."""
        self._port = self._serial.Serial(self._address.path, self._address.baud,
                                         timeout=timeout_s, exclusive=True)
        return True

    def receive(self, timeout_s: float) -> bytes:
        """Return the bytes received, maybe none; OSError if the device is gone."""
        if self._port.timeout != timeout_s:
            self._port.timeout = timeout_s
        data = self._port.read(1)
        return data + self._port.read(self._port.in_waiting) if data else data

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
        self.exhausted = False
        self.status = f'connecting to {self._source}'

    def read(self, timeout_s: float) -> list[tuple[int | None, bytes]]:
        """Return the bytes received; nothing while the line is down."""
        pause = self._retry_at - self._clock()
        if not self._up and pause > 0.0:
            self._wait(min(pause, timeout_s))
            return []
        try:
            if not self._up:
                self.connect(timeout_s)
                return []
            data = self._line.receive(timeout_s)
        except OSError as error:
            return self._drop(str(error))
        return [(self._now_ns(), data)] if data else []

    def connect(self, timeout_s: float) -> None:
        """Try to connect; OSError if that fails."""
        self._up = self._line.connect(timeout_s)
        if self._up:
            self.status = f'connected to {self._source}'

    def close(self) -> None:
        """Close the line."""
        self._line.close()
        self._up = False

    def _drop(self, why: str) -> list[tuple[int | None, bytes]]:
        was_up = self._up
        self.close()
        self._retry_at = self._clock() + self._reconnect_s
        self.status = f'{self._source}: {why}'
        return [(self._now_ns(), _LINE_END)] if was_up else []


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
    settings : DriverSettings
        Settings with `source` set.
    now_ns : callable
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
