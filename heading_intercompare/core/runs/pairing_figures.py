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

"""The share of one run in the pairing ledger, as the JSON shows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.pairing.ledger import LedgerKey, LedgerSegment, LOSSES, REASONS


@dataclass(frozen=True, slots=True)
class RejectedReadings:
    """Counts of the readings of each sensor rejected before pairing, by reason."""

    ts: Mapping[str, int] = figure('of these rejected, by reason', 'TS readings')
    rs: Mapping[str, int] = figure('of these rejected, by reason', 'RS readings')


_PLACES = {place: place.replace('_', ' ') for place in LOSSES}


@dataclass(frozen=True, slots=True)
class LostReadings:
    """Counts of the readings of each sensor that were sent and never came, by where."""

    ts: Mapping[str, int] = figure('TS readings lost besides', choices=_PLACES)
    rs: Mapping[str, int] = figure('RS readings lost besides', choices=_PLACES)


@dataclass(frozen=True, slots=True)
class PairingFigures:
    """The share of one run in the pairing ledger, and the lags of its pairs."""

    ts_received: int = figure('TS readings received', row='TS received')
    rs_received: int = figure('RS readings received', row='RS received')
    paired: int = figure('pairs')
    ts_paired: int = figure('of these paired as they are', 'TS readings')
    ts_used: int = figure('of these only interpolated between', 'TS readings')
    ts_unpaired: int = figure('of these without a partner', 'TS readings', row='  without partner')
    rs_used: int = figure('of these paired or interpolated between', 'RS readings')
    rs_unused: int = figure('of these not used', 'RS readings')
    rejected: RejectedReadings = figure('rejected readings by sensor and reason',
                                        ', '.join(f'`{reason}`' for reason in REASONS))
    mean_lag_s: float | None = figure('mean lag RS - TS')
    max_lag_s: float | None = figure('largest |lag|')
    rs_variance_factor: float | None = figure('factor of the RS noise variance by interpolation',
                                              'mean sum of the squared weights of the readings; 1 '
                                              'if the RS is not interpolated')
    ts_variance_factor: float | None = figure('factor of the TS noise variance by interpolation',
                                              '1 if the TS is not interpolated')
    lost: LostReadings = figure('readings that were sent and never came, by sensor and by where',
                                '`on_the_way`: gaps in the numbers of the publisher; `at_source`: '
                                'datagrams that the kernel dropped before the driver read them, '
                                'or lines missing by their numbers; '
                                '`before_start`: published before the first reading taken, in the '
                                'first run')
    ts_unbridged: int = figure('of these beside a gap of the RS', 'TS readings')
    rs_unbridged: int = figure('of these beside a gap of the TS', 'RS readings')
    ts_held: int = figure('of these repeating a held value', 'TS readings, E.26')
    rs_held: int = figure('of these repeating a held value', 'RS readings, E.26')

    def find_interpolated(self, method: str) -> str | None:
        """Return the sensor, 'ts' or 'rs', that a method interpolated; None for none or both."""
        factors = self.rs_variance_factor, self.ts_variance_factor
        if method == 'nearest' or factors == (1.0, 1.0):
            return None
        interpolated = {'interpolate': 'rs', 'interpolate_ts': 'ts'}.get(method)
        if method == 'auto' and 1.0 in factors:
            return 'ts' if factors[0] == 1.0 else 'rs'
        return interpolated

    @classmethod
    def of(cls, share: LedgerSegment, mean_lag_s: float | None, max_lag_s: float | None,
           rs_variance_factor: float | None, ts_variance_factor: float | None) -> 'PairingFigures':
        """Build the figures; pending readings count as not yet received."""
        counts = share.counts
        return cls(ts_received=share.received('ts') - counts.get(LedgerKey.TS_PENDING, 0),
                   rs_received=share.received('rs') - counts.get(LedgerKey.RS_PENDING, 0),
                   paired=counts.get(LedgerKey.PAIRED, 0),
                   ts_paired=counts.get(LedgerKey.TS_PAIRED, 0),
                   ts_used=counts.get(LedgerKey.TS_USED, 0),
                   ts_unpaired=counts.get(LedgerKey.TS_UNPAIRED, 0),
                   rs_used=counts.get(LedgerKey.RS_USED, 0),
                   rs_unused=counts.get(LedgerKey.RS_UNUSED, 0),
                   rejected=RejectedReadings(share.rejected('ts'), share.rejected('rs')),
                   mean_lag_s=mean_lag_s, max_lag_s=max_lag_s,
                   rs_variance_factor=rs_variance_factor, ts_variance_factor=ts_variance_factor,
                   lost=LostReadings(share.lost('ts'), share.lost('rs')),
                   ts_unbridged=counts.get(LedgerKey.TS_UNBRIDGED, 0),
                   rs_unbridged=counts.get(LedgerKey.RS_UNBRIDGED, 0),
                   ts_held=counts.get(LedgerKey.TS_HELD, 0),
                   rs_held=counts.get(LedgerKey.RS_HELD, 0))
