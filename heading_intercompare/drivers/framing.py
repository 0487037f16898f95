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
Bytes to sentences, with their checksums verified.

A sentence starts at `$` or `!` wherever that stands. So anything may come before it: log stamps,
TAG blocks, the header `UdPbC` of IEC 61162-450, garbage, the rest of a damaged sentence. It ends
with its checksum or with the line. The sentences do not depend on how the bytes were split on
their way.

A line without `$` and `!` may hold a log of a receiver: from `#` or `%` to its checksum of 32
bits.
"""

from __future__ import annotations

from binascii import crc_hqx
from collections import Counter
from functools import reduce
from operator import xor
import re
from typing import NamedTuple, Optional, Tuple
import zlib

import numpy as np

#: Most bytes of a sentence; a longer one is `too_long`.
MAX_SENTENCE = 1024
#: Bytes before a sentence that are searched for a stamp and TAG blocks.
KEPT_PREFIX = 256
#: Most bytes kept of a line that does not end; beyond that it is shortened.
MAX_OPEN = 16_384

_PIECE = re.compile(
    rb'([^\r\n$!]*)'                                       # the prefix of the sentence
    rb'(?:([$!])([^\r\n$!*]*)'                             # its start, its text
    rb'(?:\*([0-9A-Fa-f]{2})([^\r\n$!]*[\r\n]+)?'          # its checksum, the rest of the line
    rb'|(\*?[^\r\n$!]*[\r\n]+)?)'                          # or none: the end of the line, or cut
    rb'|[\r\n]+)')
#: A log of a receiver: its text with the sign before it, its checksum.
_LOG = re.compile(rb'([#%][A-Z][A-Z0-9]*A,[^;*#%]*;[^*]*)\*([0-9A-Fa-f]{8})(?![0-9A-Fa-f])')
#: A checksum of another length: of 32 or 16 bits, or without its leading zero; what follows it.
_ODD_CHECKSUM = re.compile(
    rb'([0-9A-Fa-f]{8}|[0-9A-Fa-f]{4}|[0-9A-Fa-f])(?![0-9A-Fa-f])(.*)', re.DOTALL)
_HEX = {f'{a}{b}'.encode(): int(a + b, 16)
        for a in '0123456789abcdefABCDEF' for b in '0123456789abcdefABCDEF'}


class Received(NamedTuple):
    """
    Bytes as a source returns them.

    Attributes
    ----------
    data
        A datagram, a line of a log, or a piece of a stream.
    stamp_ns
        Time of receipt, nanoseconds UTC; None for a line of a log without a stamp.
    late_s
        Longest time for which the bytes may have waited to be read, seconds. Datagrams are
        stamped by the kernel and do not wait.
    file
        The file of a log that begins with this line.
    sender
        Address of the host that sent a datagram.

    """

    data: bytes
    stamp_ns: int | None
    late_s: float = 0.0
    file: str | None = None
    sender: str = ''


#: One sentence: time of receipt [ns], the bytes before it, its text, whether it had a checksum,
#: the bytes between its checksum and the end of the line.
Frame = Tuple[Optional[int], bytes, bytes, bool, bytes]


#: Of fewer texts, as in a datagram, the checksums are faster without numpy.
_FEW_TEXTS = 8


def _checksums(texts: list[bytes]) -> list[int]:
    """Return the exclusive or of the bytes of each text."""
    if len(texts) < _FEW_TEXTS:
        return [reduce(xor, text, 0) for text in texts]
    joined = np.frombuffer(b'\0'.join(texts) + b'\0', np.uint8)
    starts = np.zeros(len(texts), np.intp)
    np.cumsum([len(text) + 1 for text in texts[:-1]], out=starts[1:])
    sums: list[int] = np.bitwise_xor.reduceat(joined, starts).tolist()
    return sums


def _long_checksum(text: bytes) -> int:
    """Return the checksum of 32 bits that NovAtel and Unicore use: neither end is inverted."""
    return zlib.crc32(text, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _suffix_of_odd(text: bytes, computed: int, tail: bytes) -> bytes | None:
    """Return what follows the checksum of another length in a tail; None unless it agrees."""
    match = _ODD_CHECKSUM.match(tail)
    if match is None:
        return None
    # That of 16 bits is the CRC of XMODEM, as VectorNav writes it.
    expected = (computed if len(match[1]) == 1 else
                crc_hqx(text, 0) if len(match[1]) == 4 else _long_checksum(text))
    return match[2].strip() if int(match[1], 16) == expected else None


def _find_log(line: bytes) -> re.Match[bytes] | None:
    """Return the log of a receiver in a line without `$` and `!`; None without one."""
    return _LOG.search(line) if b';' in line else None


class Framer:
    """
    Cuts the bytes from a source into sentences.

    Parameters
    ----------
    datagrams
        Each `feed` is a complete datagram: its end ends a line. Otherwise the bytes are a stream,
        and a sentence may span many feeds.
    with_lines
        A line without a sentence is returned too, as a frame without text: in a log it may be a
        stamp.

    Attributes
    ----------
    counts
        Lines and pieces that gave no sentence, by reason. `no_sentence`: a line without `$` or
        `!` (blank lines do not count). `cut`: a sentence without a checksum, cut off by another
        one or by the end of the stream. `bad_checksum`: the checksum is wrong, or neither
        two hex digits, nor one without its zero, nor four or eight of a CRC. `too_long`: more
        than 1024 bytes.

    """

    def __init__(self, datagrams: bool = False, with_lines: bool = False) -> None:
        self._datagrams, self._with_lines = datagrams, with_lines
        self._open = b''
        self._open_ns: list[int | None] = []
        self._line_ns: int | None = None
        self._prefix = b''
        self.counts: Counter[str] = Counter()

    def feed(self, data: bytes, received_ns: int | None) -> list[Frame]:
        """
        Take bytes and return the sentences of the lines that they complete.

        Parameters
        ----------
        data
            The bytes received, split anywhere.
        received_ns
            When they were received. A sentence gets the time of its first byte.

        """
        if self._datagrams:
            self._line_ns = received_ns
            return self._frames(data + b'\n', [], received_ns)
        frames = []
        if not self._open:
            self._line_ns = received_ns
        end = max(data.rfind(b'\n'), data.rfind(b'\r')) + 1
        if end:
            text, starts_ns = self._open + data[:end], self._open_ns
            self._open, self._open_ns = b'', []
            frames = self._frames(text, starts_ns, received_ns)
        rest = data[end:]
        if rest:
            if not self._open:
                self._line_ns = received_ns
            self._open += rest
            self._open_ns += [received_ns] * (rest.count(b'$') + rest.count(b'!'))
            if len(self._open) > MAX_OPEN:
                frames += self._shorten()
        return frames

    def flush(self) -> list[Frame]:
        """Return the last sentences at the end of the stream; one without checksum is cut."""
        text, starts_ns = self._open, self._open_ns
        self._open, self._open_ns = b'', []
        if starts_ns:
            return self._frames(text + b'$', starts_ns, None, ends=False)
        return self._lone_line(text, self._line_ns) if text else []

    def _lone_line(self, line: bytes, received_ns: int | None) -> list[Frame]:
        """Return the frame of a line without `$` and `!`: of a log of a receiver, or no text."""
        log = _find_log(line)
        if log is None:
            self.counts['no_sentence'] += 1
            return [(None, line, b'', False, b'')] if self._with_lines else []
        if len(log[1]) > MAX_SENTENCE:
            self.counts['too_long'] += 1
        elif int(log[2], 16) != _long_checksum(log[1][1:]):
            self.counts['bad_checksum'] += 1
        else:
            return [(received_ns, line[:log.start()], log[1], True, line[log.end():].strip())]
        return []

    def _shorten(self) -> list[Frame]:
        """Shorten a line that does not end; return the sentences that another one in it ends."""
        start = max(self._open.rfind(b'$'), self._open.rfind(b'!'))
        if start < 0:
            self._open = self._open[-KEPT_PREFIX:]
            return []
        last = self._open[start:]
        frames = self._frames(self._open[:start] + b'$', self._open_ns[:-1], None, ends=False)
        head, tail = last[:MAX_SENTENCE + 4], last[MAX_SENTENCE + 4:]
        if len(tail) > KEPT_PREFIX:
            tail = b' ' + tail[-KEPT_PREFIX:]
        self._open = self._prefix[-KEPT_PREFIX:] + head + tail
        self._open_ns = self._open_ns[-1:]
        return frames

    def _frames(self, text: bytes, starts_ns: list[int | None], received_ns: int | None,
                ends: bool = True) -> list[Frame]:
        """
        Return the sentences of a text that ends a line or, if not `ends`, ends at a new start.

        The first starts were received at `starts_ns`, the other starts at `received_ns`. A
        sentence directly after another one in its line gets the same prefix.
        """
        pieces = _PIECE.findall(text)
        if not ends:
            pieces.append(pieces.pop()[:1] + (b'', b'', b'', b'', b''))
        frames: list[Frame] = []
        n, before = 0, b''
        for (prefix, start, body, checksum, after, rest), computed in zip(
                pieces, _checksums([piece[2] for piece in pieces])):
            prefix = prefix or before
            before = prefix if start and not (after or rest) else b''
            if not start:
                if prefix and ends:
                    frames += self._lone_line(prefix, received_ns if n else self._line_ns)
                self._line_ns = received_ns
                continue
            came_ns = starts_ns[n] if n < len(starts_ns) else received_ns
            n += 1
            if checksum and _HEX[checksum] == computed and len(body) <= MAX_SENTENCE:
                frames.append((came_ns, prefix, body, True, after.strip()))
                continue
            tail = b'*' + checksum + after if checksum else rest
            suffix = self._examine(body, computed, tail)
            if suffix is not None:
                frames.append((came_ns, prefix, body, tail[:1] == b'*', suffix))
        self._prefix = prefix
        return frames

    def _examine(self, text: bytes, computed: int, tail: bytes) -> bytes | None:
        """Return what follows a text with no checksum of two digits that agrees, or count it."""
        if len(text) > MAX_SENTENCE:
            self.counts['too_long'] += 1
        elif tail[:1] == b'*':
            suffix = _suffix_of_odd(text, computed, tail[1:])
            if suffix is not None:
                return suffix
            self.counts['bad_checksum'] += 1
        elif tail:
            return b''
        else:
            self.counts['cut'] += 1
        return None


def split(line: bytes) -> tuple[bytes, bytes, bytes] | None:
    """
    Return the prefix and the text of the first sentence of a line, and what follows its checksum.

    None if there is none.
    """
    match = _PIECE.match(line if line.endswith((b'\n', b'\r')) else line + b'\n')
    if match and match[2]:
        return match[1], match[3], (match[5] or b'').strip()
    log = _find_log(line)
    return log and (line[:log.start()], log[1], line[log.end():].strip())
