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

"""When to make a subscription again that the middleware may have forgotten."""

from __future__ import annotations

#: The state of a subscription is looked at once a second; a node that was stopped looks later.
_STOPPED_S = 3.0
#: No stream that is judged has a longer step; a silence is unusual from three steps on.
_SILENT_S = 5.0
_STEPS = 3.0
#: Arrivals after which the steps of a stream are known.
_KNOWN_FROM = 20
#: What is under way arrives within this; only then is it missing.
_WAIT_S = 2.0
#: A sensor that is switched off, or a network that loses all the time, costs no more than one new
#: subscription in this time.
_LONGEST_S = 300.0


class Renewal:
    """
    Tells when a subscription is to be made again.

    Notes
    -----
    DDS gives up a process that it cannot reach for the lease, 20 s. When that one is back, its
    subscriptions are usually connected again, but sometimes not, or without the messages that were
    published in the meantime. A new subscription is connected for certain. So it is made where
    messages are missing, where a stream has fallen silent, and where this process stood still.

    A new subscription takes all that its publishers keep, which costs time. Where it has not
    brought what was missing, the next one waits twice as long. The clock is the caller's.

    Examples
    --------
    >>> renewal = Renewal()
    >>> [renewal.is_due(float(s), received=10 * s, missing=0) for s in range(4)]
    [False, False, False, False]
    >>> [renewal.is_due(4.0 + s, received=40, missing=84) for s in range(4)]
    [False, False, True, False]

    """

    def __init__(self) -> None:
        self._looked_s: float | None = None
        self._told_s: float | None = None
        self._missing, self._asked_for, self._wait_s = 0, 0, _WAIT_S
        self._due_s: float | None = None
        self._received, self._arrivals, self._newest_s = 0, 0, 0.0
        self._step_s, self._patience_s = 0.0, 0.0

    def is_due(self, now_s: float, received: int, missing: int) -> bool:
        """Tell whether to make it again, given the messages received and missing so far."""
        before_s = now_s if self._looked_s is None else self._looked_s
        self._looked_s = now_s
        if now_s - before_s > _STOPPED_S:
            self._due_s = now_s + _WAIT_S
        elif missing > self._missing and self._due_s is None:
            self._due_s = now_s + self._wait_s
        if missing < self._asked_for:
            # It has brought some of them.
            self._asked_for, self._wait_s = 0, _WAIT_S
        self._missing = missing
        if self._is_silent(now_s, now_s - before_s, received):
            self._due_s = now_s
        if self._due_s is None or now_s < self._due_s:
            return False
        self._due_s = None
        if missing:
            self._wait_s = min(2.0 * self._wait_s, _LONGEST_S)
        self._asked_for = missing
        return True

    def stood_still(self, now_s: float) -> bool:
        """Tell, once, whether this process stood still since it last asked what is due."""
        if self._looked_s in (None, self._told_s) or now_s - self._looked_s <= _STOPPED_S:
            return False
        self._told_s = self._looked_s
        return True

    def _is_silent(self, now_s: float, passed_s: float, received: int) -> bool:
        """Tell whether a stream is silent for unusually long, now and then."""
        if received > self._received or not self._newest_s:
            if self._received:
                step_s = now_s - self._newest_s - passed_s
                self._step_s = max(self._step_s, min(step_s, _LONGEST_S))
                self._arrivals += 1
            self._received, self._newest_s = received, now_s
            self._patience_s = max(_SILENT_S, _STEPS * self._step_s)
        elif self._arrivals >= _KNOWN_FROM and now_s - self._newest_s > self._patience_s:
            self._patience_s = min(2.0 * (now_s - self._newest_s),
                                   now_s - self._newest_s + _LONGEST_S)
            return True
        return False
