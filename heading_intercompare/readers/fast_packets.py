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

"""Messages of NMEA 2000 that take several frames, joined: the fast packets."""

from __future__ import annotations

__all__ = ['FastPackets', 'FRAME_BYTES']

FRAME_BYTES = 8
"""The most bytes of a frame."""

#: 6 bytes in the first frame, 7 in each of 31 others.
_MOST_BYTES = 223


class FastPackets:
    """
    Joins the frames of fast packets, by source, message and sequence.

    Attributes
    ----------
    broken : int
        Packets of which a frame is missing, without those that are still expected.

    Notes
    -----
    The first byte of a frame has the number of the packet (3 bits) and that of the frame (5 bits).
    The second byte of frame 0 is the length of the packet. The bus keeps the order of the frames
    of a source, so a frame out of order means a loss.

    Examples
    --------
    >>> packets = FastPackets()
    >>> packets.add(129029, '5', bytes.fromhex('40 08 01 02 03 04 05 06')) is None
    True
    >>> packets.add(129029, '5', bytes.fromhex('41 07 08 ff ff ff ff ff')).hex()
    '0102030405060708'

    """

    def __init__(self) -> None:
        self.broken = 0
        #: The length, the bytes so far and the frame expected; None while the rest is ignored.
        self._begun: dict[tuple[int, int | str, int], tuple[int, bytearray, int] | None] = {}

    def add(self, pgn: int, source: int | str, frame: bytes) -> bytes | None:
        """Take a frame, and return the bytes of the packet that it completes, or None."""
        if len(frame) < 2:
            self.broken += 1
            return None
        key, number = (pgn, source, frame[0] >> 5), frame[0] & 31
        begun = self._begun.get(key)
        if number == 0:
            self.broken += begun is not None
            begun = (frame[1], bytearray(frame[2:FRAME_BYTES]), 1)
        elif begun is not None and number == begun[2]:
            begun[1].extend(frame[1:FRAME_BYTES])
            begun = (begun[0], begun[1], number + 1)
        else:
            self.broken += begun is not None or key not in self._begun
            self._begun[key] = None
            return None
        length, data, _ = begun
        if length > _MOST_BYTES:
            self.broken += 1
            self._begun[key] = None
            return None
        if len(data) < length:
            self._begun[key] = begun
            return None
        self._begun.pop(key, None)
        return bytes(data[:length])

    def flush(self) -> int:
        """Forget the packets that were begun, and return how many are broken in all."""
        self.broken += sum(packet is not None for packet in self._begun.values())
        self._begun.clear()
        return self.broken
