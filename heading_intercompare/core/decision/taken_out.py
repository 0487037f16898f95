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

"""The differences that are left out of runs, beside the outcome with nothing left out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

from heading_intercompare.core.json_keys import leave_out_none
from heading_intercompare.core.outcome import Outcome

__all__ = ['AsRecorded', 'Stretch', 'sum_stretches', 'TakenOut']


@dataclass(frozen=True, slots=True)
class Stretch:
    """
    What is left out for one reason; keys of the JSON.

    Attributes
    ----------
    start_ns, end_ns : int
        Its ends; the end does not belong to it.
    reason : str
    n : int
        Differences that it took out.

    """

    start_ns: int
    end_ns: int
    reason: str
    n: int


@dataclass(frozen=True, slots=True)
class AsRecorded:
    """
    The judgement with nothing taken out; keys of the JSON.

    Attributes
    ----------
    outcome : Outcome
    validity_effect : {'holds'}
        Nothing but the variance decides on a record as recorded.
    headline : str
        The outcome in words.
    n : int
        Differences analysed.
    variance_deg2 : float or None
        Of one run; None for several.

    """

    outcome: Outcome
    validity_effect: str
    headline: str
    n: int
    variance_deg2: float | None


@dataclass(frozen=True, slots=True)
class TakenOut:
    """
    What is left out of a run, or of all runs; keys of the JSON.

    Attributes
    ----------
    n : int
        Differences taken out that would have been analysed.
    share : float
        Their share of those.
    stretches : sequence of Stretch
        Each with its reason.
    as_recorded : AsRecorded or None
        The judgement with nothing left out; None for a single run, or if it is unknown.

    """

    n: int
    share: float
    stretches: Sequence[Stretch]
    as_recorded: AsRecorded | None = leave_out_none()


def sum_stretches(parts: Iterable[Sequence[Stretch]]) -> tuple[Stretch, ...]:
    """Return the stretches of several runs, each once, with the sum of its differences."""
    sums: dict[tuple[int, int, str], int] = {}
    for part in parts:
        for stretch in part:
            key = stretch.start_ns, stretch.end_ns, stretch.reason
            sums[key] = sums.get(key, 0) + stretch.n
    return tuple(Stretch(*key, n) for key, n in sorted(sums.items()))
