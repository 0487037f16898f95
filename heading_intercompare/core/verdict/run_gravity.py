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

"""How grave the outcomes of runs are: what sorts the worst first, and how many comply."""

from __future__ import annotations

import math
from typing import Sequence

from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.validity.condition import DOUBTFUL, HOLDS, NOT_TESTABLE, VOID

from .verdict_document import RunVerdict

#: From the worst to the best.
OUTCOMES = tuple(reversed(Outcome))
_EFFECTS = (VOID, DOUBTFUL, NOT_TESTABLE, HOLDS)


def gravity_of(run: RunVerdict) -> tuple[float, float, float]:
    """Return what sorts the worst run first; a doubt makes no rejection worse."""
    rejected = run.outcome is Outcome.NON_COMPLIANT
    return (OUTCOMES.index(run.outcome),
            0 if rejected else _EFFECTS.index(run.validity_effect),
            -(share_of_norm(run) or 0.0))


def share_of_norm(run: RunVerdict) -> float | None:
    """Return the scatter of the differences in terms of its norm, the root of GK (5)."""
    limit_deg2 = run.guarded.rejection_limit_deg2
    if run.std_deg is None or not limit_deg2 > 0.0:
        return None
    return run.std_deg / math.sqrt(limit_deg2)


def count_compliant(runs: Sequence[RunVerdict]) -> str:
    """Return how many runs comply, in words: '49 of 50 runs comply, 2 of them in doubt'."""
    compliant = [run for run in runs if run.outcome is Outcome.COMPLIANT]
    n_doubtful = sum(run.validity_effect == DOUBTFUL for run in compliant)
    doubt = f', {n_doubtful} of them in doubt' if n_doubtful else ''
    return f'{len(compliant)} of {len(runs)} runs comply{doubt}'


def list_doubts(run: RunVerdict) -> list[str]:
    """Return what speaks against a run, the gravest first."""
    return [finding.words for effect in (VOID, DOUBTFUL) for finding in run.validity
            if finding.effect == effect]
