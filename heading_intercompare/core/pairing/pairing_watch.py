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

"""How well two live streams pair at the moment, and why not if they do not."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.settings import Pairing
from heading_intercompare.core.statistics.recent_count import RecentCount

from .ledger import Ledger, LedgerKey

_WINDOW_S, _FEW = 60.0, 0.1
# Pairs in time come within max_wait_s; the first second of a stream is held.
_SETTLING_S = 2.0


@dataclass(frozen=True, slots=True)
class PairingState:
    """
    The pairing of the last minute.

    Attributes
    ----------
    paired_share
        Pairs per reading of the sensor with fewer readings, at most 1; None unless both sensors
        reported.
    offset_s
        Newest stamp of the TS - newest stamp of the RS, seconds; None unless both have reported.
    trouble
        What is wrong, in words; '' if nothing is.

    """

    paired_share: float | None
    offset_s: float | None
    trouble: str


class PairingWatch:
    """
    Watches the ledger of a live pairing.

    Parameters
    ----------
    rule
        Uses `max_wait_s`: where stamps lie further apart, pairs come late or never.

    """

    def __init__(self, rule: Pairing) -> None:
        self._max_wait_s = rule.max_wait_s
        self._received = RecentCount(_WINDOW_S), RecentCount(_WINDOW_S)
        self._paired = RecentCount(_WINDOW_S)
        self._begun_s: float | None = None

    def look(self, ledger: Ledger, ts_ns: int | None, rs_ns: int | None,
             now_s: float) -> PairingState:
        """
        Return the state at a time.

        Parameters
        ----------
        ledger
            The ledger as it is now.
        ts_ns, rs_ns
            Stamps of the last readings of both sensors; None before the first.
        now_s
            A steady clock, seconds; increases from call to call.

        """
        total = ledger.total
        if self._begun_s is None:
            self._begun_s = now_s
        come = [count.take(total.reported(stream), now_s)
                for stream, count in zip(('ts', 'rs'), self._received)]
        paired = self._paired.take(total.counts.get(LedgerKey.PAIRED, 0), now_s)
        if ts_ns is None or rs_ns is None:
            return PairingState(None, None, '')
        offset_s = (ts_ns - rs_ns) / 1e9
        if not min(come):
            return PairingState(None, offset_s, '')
        share = min(1.0, paired / min(come))
        far = abs(offset_s) > self._max_wait_s
        # Readings wait for a choice of the method, or for stamps that confirm theirs.
        waiting = any(2 * total.counts.get(LedgerKey.of_pending(stream), 0) >= n
                      for stream, n in zip(('ts', 'rs'), come))
        settled = now_s - self._begun_s >= min(_WINDOW_S, self._max_wait_s + _SETTLING_S)
        if share >= _FEW or not settled or waiting and not far:
            return PairingState(share, offset_s, '')
        size = f'{abs(offset_s):.1f}' if abs(offset_s) >= 1.0 else f'{abs(offset_s):.2g}'
        apart = f'the stamps of TS and RS lie {size} s apart'
        if far and not paired:
            return PairingState(share, offset_s, f'{apart}: nothing can be paired')
        return PairingState(share, offset_s, f'only {100.0 * share:.0f} % of the readings of the '
                            f'last minute are paired; {apart}')
