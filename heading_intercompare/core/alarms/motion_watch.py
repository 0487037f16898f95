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

"""Whether a heading contradicts the motion of the ship now: the check of the verdict, live."""

from __future__ import annotations

from heading_intercompare.core.motion.motion_check import check_motion
from heading_intercompare.core.motion.motion_record import MotionRecord
from heading_intercompare.core.motion.motion_words import describe_motion, explain_motion
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Motion, Pairs
from heading_intercompare.core.settings import Settings

from .alarm import Rule, Sign
from .pair_window import PairWindow

MOTION_RULES = (Rule('motion', clear_s=0.0),)
"""The alarm of a comparison with the motion of the ship."""

WINDOW_S = 240.0
"""The newest pairs and motion of this length are compared, seconds."""

_EVERY_NS = 10 * 10 ** 9
_WINDOW_NS = round(WINDOW_S * 1e9)
#: Headings two times a second show the turns of a ship.
_STEP_NS = 5 * 10 ** 8
_MOST = 1024


class MotionWatch:
    """
    Compares the newest pairs with the motion of the ship.

    Notes
    -----
    The check and its bounds are those of the verdict, over the last four minutes. The alarm is
    raised once a heading has pointed too far off the course for half of that time, or plainly
    does not turn with the ship. It clears when the headings agree with the
    motion again. A ship that lies still or turns all the time neither raises nor clears it.

    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._window = PairWindow(WINDOW_S, _MOST)
        self._record = MotionRecord()
        self._segment = self._taken_ns = 0
        self._due_ns: int | None = None

    def update(self, pairs: Pairs) -> None:
        """Take pairs in the order of their segments and stamps."""
        for part in pairs.in_segments():
            if int(part.segment[0]) != self._segment:
                # Stamps are repeated: motion of the same stamps belongs to the time before.
                self._segment, self._taken_ns, self._due_ns = int(part.segment[0]), 0, None
                self._window.clear()
                self._record = MotionRecord()
            self._update(part)

    def _update(self, pairs: Pairs) -> None:
        # The first pair of each half second.
        slot = pairs.stamp_ns // _STEP_NS
        keep = slot > self._taken_ns
        keep[1:] &= slot[1:] != slot[:-1]
        pairs = pairs[keep]
        if not len(pairs):
            return
        self._taken_ns = int(pairs.stamp_ns[-1]) // _STEP_NS
        self._window.update(pairs, subtract(pairs, self._settings.installation_offset_deg,
                                            self._settings.wrap_center_deg))

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship in any order."""
        self._record.take(motion)
        oldest_ns, newest_ns = self._record.oldest_ns, self._record.newest_ns
        if oldest_ns is not None and newest_ns is not None and (
                oldest_ns < newest_ns - 4 * _WINDOW_NS):
            # Pairs may come later than the motion.
            self._record = self._record.after(newest_ns - 2 * _WINDOW_NS)

    def look(self) -> dict[str, Sign]:
        """Return the sign at the newest pair, every ten seconds of stamp time; otherwise none."""
        window, record = self._window, self._record
        if not len(window) or not len(record):
            return {}
        newest_ns = int(window.stamp_ns[-1])
        if self._due_ns is not None and newest_ns < self._due_ns:
            return {}
        self._due_ns = newest_ns + _EVERY_NS
        check = check_motion(record.by_thing(), window.stamp_ns, window.rs_deg + window.x_deg,
                             window.rs_deg, self._settings.motion)
        if check.kind == 'agrees':
            return {'motion': Sign(False)}
        if check.kind != 'contradicts':
            return {'motion': Sign(None)}
        return {'motion': Sign(True, describe_motion(check), {
            'sensor': check.whose, 'evidence': explain_motion(check)})}
