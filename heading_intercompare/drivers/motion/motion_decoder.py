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

"""The motion of the ship in a live stream of sentences, or in a log that is played."""

from __future__ import annotations

from collections import Counter

from heading_intercompare.core.records import Motion
from heading_intercompare.drivers.log_lines.log_order import open_log
from heading_intercompare.drivers.settings import DriverSettings

from .motion_lines import find_best, MotionColumns, MotionLine, MotionLines
from .motion_log import read_log_motion

__all__ = ['MotionDecoder']

#: Rows held until a sentence is chosen; a flood does not wait for the end of `learn_s`.
_MOST_HELD = 20_000


class MotionDecoder:
    r"""
    Turns the bytes of a source into the motion of the ship.

    Parameters
    ----------
    settings : DriverSettings
        As for `NmeaDecoder`; `sentence`, `talker` and `instrument` choose headings only.

    Attributes
    ----------
    chosen : dict of str to str
        The sentence used for each thing, such as 'INVTG' for 'course'.

    Notes
    -----
    Of each thing one kind of sentence is taken, from the talker heard first: that which
    `read_log_motion` takes of a log. A log that is played is searched beforehand. On a live line
    the decoder listens for `learn_s` of receipt time after the first sentence that tells the
    thing, holds all rows until then, and returns those of the best kind.

    Examples
    --------
    >>> decoder = MotionDecoder(DriverSettings(learn_s=0.0))
    >>> decoder.feed(b'$HEROT,-30.0,A*35\r\n', 10 ** 18).rate_deg_s.tolist()
    [-0.5]

    """

    def __init__(self, settings: DriverSettings) -> None:
        self._counts: Counter[str] = Counter()
        self._learn_ns = round(settings.learn_s * 1e9)
        self.chosen: dict[str, str] = {}
        files = None
        self._played = settings.source is not None and settings.address.scheme == 'file'
        if self._played:
            files = open_log(settings.address.path, settings)
            self.chosen |= read_log_motion(settings.address.path, settings).sentences
        self._lines = MotionLines(settings, self._counts, files)
        self._held: dict[str, dict[str, MotionColumns]] = {}
        self._since_ns: dict[str, int] = {}
        self._ready_columns: dict[str, MotionColumns] = {}

    @property
    def counts(self) -> dict[str, int]:
        """Sentences of the motion that gave none, by reason; `other` are those not chosen."""
        return dict(sorted(self._counts.items()))

    def feed(self, data: bytes, received_ns: int | None, late_s: float = 0.0,
             file: str | None = None) -> Motion:
        """Take bytes and return the motion that they complete; see `NmeaDecoder.feed`."""
        if file is not None:
            self._lines.begin_file(file)
        for line in self._lines.feed(data, received_ns):
            self._take(line, received_ns)
        for what in [*self._held]:
            if self._has_learnt(what, received_ns):
                self._choose(what)
        return self._drain()

    def flush(self) -> Motion:
        """Return the last rows at the end of the stream."""
        for line in self._lines.flush():
            self._take(line, None)
        for what in [*self._held]:
            self._choose(what)
        return self._drain()

    def _take(self, line: MotionLine, received_ns: int | None) -> None:
        what = line.told.what
        chosen = self.chosen.get(what)
        if chosen == line.name:
            self._ready_columns.setdefault(what, MotionColumns()).add(line.stamp_ns, line.told)
        elif chosen is not None or self._played:
            self._counts['other'] += 1
        else:
            self._held.setdefault(what, {}).setdefault(line.name, MotionColumns()).add(
                line.stamp_ns, line.told)
            if received_ns is not None:
                self._since_ns.setdefault(what, received_ns)

    def _has_learnt(self, what: str, now_ns: int | None) -> bool:
        since_ns = self._since_ns.get(what)
        if sum(map(len, self._held[what].values())) > _MOST_HELD:
            return True
        if now_ns is None or since_ns is None:
            return False
        self._since_ns[what] = min(since_ns, now_ns)
        return now_ns - since_ns >= self._learn_ns

    def _choose(self, what: str) -> None:
        """Choose the best of the sentences that tell one thing, and count the other sentences."""
        held = self._held.pop(what)
        best = find_best(held)
        self._counts['other'] += sum(len(rows) for name, rows in held.items() if name != best)
        self.chosen[what], self._ready_columns[what] = best, held[best]

    def _drain(self) -> Motion:
        columns, self._ready_columns = self._ready_columns, {}
        if not columns:
            return Motion.empty()
        return Motion.concatenate([rows.to_motion(what) for what, rows in columns.items()])
