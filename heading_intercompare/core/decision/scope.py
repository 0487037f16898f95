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


"""What a certificate covers besides slow errors: fast ones, headings, latitude, mean, risk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.records import Integers, Reals
from heading_intercompare.core.settings import Settings

__all__ = ['Scope']

_SECTOR_DEG = 10
_ARCS = 3
_USUAL_RISK = 0.05


@dataclass(frozen=True, slots=True)
class Scope:
    """The scope of a certificate; keys of the JSON."""

    shortest_s: float | None = figure('errors that change faster fall between the pairs',
                                      'two usual steps', default=None)
    headings_deg: tuple[int, ...] = figure(
        'starts of the sectors of ten degrees in which the ship headed, by the RS', default=())
    latitude_deg: tuple[float, float] | None = figure('latitudes of the trial as stated',
                                                      'null if not stated', default=None)
    mean_is_judged: bool = figure(
        'the mean difference has a norm', '`norms.total_error_max_deg` is set', default=False)
    alpha_consumer: float = figure('risk of a certificate for a TS at its norm',
                                   default=_USUAL_RISK)

    @classmethod
    def of(cls, stamp_ns: Integers, heading_deg: Reals, settings: Settings) -> 'Scope':
        """Return the scope of a run with these pairs and headings of the RS."""
        step_s = float(np.median(np.diff(stamp_ns))) / 1e9 if len(stamp_ns) > 1 else None
        sectors = np.unique(np.floor_divide(np.mod(heading_deg, 360.0), _SECTOR_DEG).astype(int))
        trial, stated = settings.trial, settings.norms.latitude_deg
        low = trial.latitude_min_deg if trial.latitude_min_deg is not None else stated
        high = trial.latitude_max_deg if trial.latitude_max_deg is not None else stated
        ends = [end for end in (low, high) if end is not None]
        return cls(None if step_s is None else 2.0 * step_s,
                   tuple(int(sector) % 36 * _SECTOR_DEG for sector in sectors),
                   (ends[0], ends[-1]) if ends else None,
                   settings.norms.total_error_max_deg is not None, settings.risk.alpha_consumer)

    @classmethod
    def join(cls, scopes: Sequence['Scope']) -> 'Scope | None':
        """Return the scope of several runs together; None for none."""
        if not scopes:
            return None
        steps = [scope.shortest_s for scope in scopes if scope.shortest_s is not None]
        first = scopes[0]
        return cls(max(steps, default=None),
                   tuple(sorted({at for scope in scopes for at in scope.headings_deg})),
                   first.latitude_deg, first.mean_is_judged, first.alpha_consumer)

    @property
    def words(self) -> str:
        """Return headings, latitude, mean and risk in words."""
        parts = [_headings_words(self.headings_deg)] if self.headings_deg else []
        if self.latitude_deg is None:
            parts.append('latitude not stated')
        else:
            low, high = self.latitude_deg
            parts.append(f'latitude {low:g}' + (f' to {high:g}' if high != low else '') + ' deg')
        if not self.mean_is_judged:
            parts.append('the mean is not judged, for no norm is set for it')
        if self.alpha_consumer != _USUAL_RISK:
            parts.append(f"consumer's risk {self.alpha_consumer:g}")
        return '; '.join(parts)


def _headings_words(starts: Sequence[int]) -> str:
    """Return the sectors as arcs."""
    if len(starts) == 360 // _SECTOR_DEG:
        return 'all headings'
    held = set(starts)
    begins = [at for at in starts if (at - _SECTOR_DEG) % 360 not in held]
    if len(begins) > _ARCS:
        return f'headings in {_SECTOR_DEG * len(starts)} deg of 360'
    arcs = []
    for begin in begins:
        end = begin + _SECTOR_DEG
        while end % 360 in held:
            end += _SECTOR_DEG
        arcs.append(f'{begin:03d}-{(end - 1) % 360 + 1:03d}')
    return f'headings {", ".join(arcs)} deg'
