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

"""The line to the bridge: datagrams, or a TCP or serial line with both directions."""

from __future__ import annotations

import socket
import time
from typing import Callable, Iterable, Protocol

from heading_intercompare.drivers.framing import Framer
from heading_intercompare.drivers.settings import Address, DriverSettings
from heading_intercompare.drivers.sources import LineSource, open_source, Source

from .alert_list import Message
from .alert_sentences import frame, tag
from .alert_settings import AlertSettings

_START_450 = b'UdPbC\0'
_MOST_LINES, _MOST_GROUPS = 1000, 99


class AlertLine:
    """
    Sends messages of alerts, and takes the sentences that come back.

    Parameters
    ----------
    settings
        Destination, source of commands, and form.
    now_ns
        Clock for the time of receipt, nanoseconds UTC.

    Raises
    ------
    SettingsError
        If no destination is set.
    OSError
        If an address cannot be used or a device cannot be opened.
    DriverError
        If pyserial is missing.

    """

    def __init__(self, settings: AlertSettings,
                 now_ns: Callable[[], int] = time.time_ns) -> None:
        address = settings.address
        self._line: _Sender
        self._source: Source | None = None
        if address.scheme == 'udp':
            if settings.commands is not None:
                self._source = open_source(DriverSettings(source=settings.commands), now_ns)
            self._line = _Datagrams(address)
        else:
            source = open_source(DriverSettings(source=settings.destination), now_ns)
            assert isinstance(source, LineSource)
            self._line = self._source = source
        self._framer = Framer(datagrams=address.scheme == 'udp')
        self._is_450 = settings.form == '61162-450' and address.scheme == 'udp'
        self._system = settings.system
        self._n_lines = self._n_groups = 0

    def send(self, messages: Iterable[Message]) -> None:
        """Send messages, a sentence at a time; OSError if that fails."""
        for message in messages:
            for data in self._wrap(message) if self._is_450 else map(frame, message):
                self._line.send(data)

    def read(self) -> list[bytes]:
        """Return the sentences that have come since the last call, without start and checksum."""
        if self._source is None:
            return []
        return [text for received in self._source.read(0.0)
                for _, _, text, has_checksum, _ in self._framer.feed(
                    received.data, received.stamp_ns) if has_checksum]

    @property
    def status(self) -> str:
        """Return where commands come from, or how the line is."""
        return 'no commands are taken' if self._source is None else self._source.status

    def close(self) -> None:
        """Close what is open."""
        for end in (self._line, self._source):
            if end is not None:
                end.close()

    def _wrap(self, message: Message) -> list[bytes]:
        """Return the datagrams of a message in the form of IEC 61162-450."""
        datagrams = []
        if len(message) > 1:
            self._n_groups = self._n_groups % _MOST_GROUPS + 1
        for number, body in enumerate(message, 1):
            parts = [f's:{self._system}', f'n:{self._n_lines}']
            if len(message) > 1:
                parts.insert(0, f'g:{number}-{len(message)}-{self._n_groups}')
            self._n_lines = (self._n_lines + 1) % _MOST_LINES
            datagrams.append(_START_450 + tag(parts) + frame(body))
        return datagrams


class _Sender(Protocol):
    """What sends bytes."""

    def send(self, data: bytes) -> None:
        """Send bytes; OSError if that fails."""

    def close(self) -> None:
        """Close it."""


class _Datagrams:
    """Sends datagrams to a host, a broadcast address or a multicast group."""

    def __init__(self, address: Address) -> None:
        self._place = (address.host, address.port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        if address.host.endswith('.255'):
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        if address.multicast and address.interface:
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF,
                                    socket.inet_aton(address.interface))

    def send(self, data: bytes) -> None:
        """Send a datagram; OSError if the network is not there."""
        self._socket.sendto(data, self._place)

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
