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
A UDP socket whose datagrams carry the kernel's time of receipt.

The kernel stamps a datagram when it arrives, so the stamp is right however late the program reads
it. The kernel also counts the datagrams that it drops because the program reads too slowly.
"""

from __future__ import annotations

from collections import Counter
import select
import socket
import struct
import time
from typing import Callable

from .framing import Received
from .settings import Address, DriverSettings

_MAX_READ = 1000
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
                datagrams.append(Received(data, self._stamp_ns(ancillary)))
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
