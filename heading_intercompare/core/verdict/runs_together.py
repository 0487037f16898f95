#!/usr/bin/env python3
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
"""How the runs of a trial lie to each other: which repeat readings, and how far apart they are."""

from __future__ import annotations

from functools import lru_cache
import math
from typing import Sequence, TYPE_CHECKING

from heading_intercompare.core.conditions.shared_readings import find_shared, Shared
from heading_intercompare.core.validity.condition import VOID

if TYPE_CHECKING:
    from .judge import RunResult
    from .recorded import JudgedPiece
    from .verdict_document import RunVerdict


def find_repeated_runs(results: Sequence[RunResult]) -> dict[int, tuple[int, Shared | None]]:
    """
    Return the runs that hold readings of an earlier one; void runs are not compared.

    Parameters
    ----------
    results
        Runs of one input or of several, numbered from 1.

    Returns
    -------
    dict of int to (int, Shared or None)
        By the number of a run, that of the earliest run whose readings it holds, and what they
        share; None if all figures are equal. The other runs share nothing with each other.

    """
    return dict(_find_repeats(tuple(
        (result.fingerprint, result.verdict.validity_effect == VOID, _figures(result))
        for result in results)))


@lru_cache(maxsize=8)
def _find_repeats(runs: tuple[tuple[str | None, bool, tuple[object, ...]], ...],
                  ) -> dict[int, tuple[int, Shared | None]]:
    """Compare each run, its fingerprint, whether it is void, and its figures, with all before."""
    repeats: dict[int, tuple[int, Shared | None]] = {}
    for number, (fingerprint, is_void, figures) in enumerate(runs, 1):
        for earlier, (earlier_fingerprint, *rest) in enumerate(runs[:number - 1], 1):
            if earlier in repeats or is_void or rest[0]:
                continue
            shared = None
            if fingerprint is not None and earlier_fingerprint is not None:
                shared = find_shared(fingerprint, earlier_fingerprint)
            if shared is not None or figures == rest[1]:
                repeats[number] = earlier, shared
                break
    return repeats


def shortest_apart_s(runs: Sequence[RunVerdict | JudgedPiece]) -> float:
    """Return the shortest time from the end of a run to the start of the next, seconds."""
    spans = sorted((run.start_ns, run.end_ns) for run in runs)
    return min((after[0] - before[1] for before, after in zip(spans, spans[1:])),
               default=math.inf) / 1e9


def _figures(result: RunResult) -> tuple[object, ...]:
    run = result.verdict
    return run.start_ns, run.end_ns, run.n, run.mean_deg, run.variance_deg2
