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

from heading_intercompare.core.declared_figures import figure
from heading_intercompare.core.outcome import Outcome


@dataclass(frozen=True, slots=True)
class Stretch:
    """What is left out for one reason; keys of the JSON."""

    start_ns: int = figure('start of the stretch')
    end_ns: int = figure('end of the stretch', 'not included')
    reason: str = figure(
        'why it is left out', 'the reason of the person, or `outside the marks`, `not in the '
        'table of runs`, `settling`, `shorter than runs.min_duration_s`')
    n: int = figure('differences that it takes out')


@dataclass(frozen=True, slots=True)
class AsRecorded:
    """The judgement with nothing taken out; keys of the JSON."""

    outcome: Outcome = figure('outcome with nothing left out')
    validity_effect: str = figure('`holds`: nothing but the variance decides')
    headline: str = figure('outcome in words')
    n: int = figure('differences analysed')
    variance_deg2: float | None = figure('variance of one run', 'null for several')


@dataclass(frozen=True, slots=True)
class TakenOut:
    """What is left out of a run, or of all runs; keys of the JSON."""

    n: int = figure('pairs left out', 'of a run, those taken out by hand')
    share: float = figure('their share', 'of all pairs; of a run, of those to be analysed')
    stretches: Sequence[Stretch] = figure('stretches left out, each with its reason')
    as_recorded: AsRecorded | None = figure('decision on the variance with nothing left out',
                                            absent='of a run, and where it is unknown')


def sum_stretches(parts: Iterable[Sequence[Stretch]]) -> tuple[Stretch, ...]:
    """Return the stretches of several runs, each once, with the sum of its differences."""
    sums: dict[tuple[int, int, str], int] = {}
    for part in parts:
        for stretch in part:
            key = stretch.start_ns, stretch.end_ns, stretch.reason
            sums[key] = sums.get(key, 0) + stretch.n
    return tuple(Stretch(*key, n) for key, n in sorted(sums.items()))
