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

"""The verdict as set beside the verdict as recorded: what runs leave out, and what it changes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

from heading_intercompare.core.decision.campaign import (
    conclude_every_run,
    conclude_sensor,
    judge_together,
)
from heading_intercompare.core.decision.coverage import settling_time_s
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.guarded import decide, Evidence, gather_evidence
from heading_intercompare.core.decision.sequential import risk_at_the_end
from heading_intercompare.core.decision.taken_out import (
    AsRecorded,
    Stretch,
    sum_stretches,
    TakenOut,
)
from heading_intercompare.core.diagnostics.run_columns import SETTLED_SHARE
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.runs.record_pieces import RecordPiece
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.warm_up import fit_warm_up

from .headline import OUTCOME_WORDS
from .runs_together import shortest_apart_s


@dataclass(frozen=True, slots=True)
class JudgedPiece:
    """
    A record from one silence to the next, judged as if nothing were left out of it.

    Attributes
    ----------
    start_ns, end_ns
        Stamps of its first and last pair.
    n
        Its finite differences.
    evidence
        Of those after a warm-up that they show.

    """

    start_ns: int
    end_ns: int
    n: int
    evidence: Evidence
    limits: Limits


def judge_piece(piece: RecordPiece, settings: Settings) -> JudgedPiece:
    """
    Gather what decides on a piece of a record as recorded.

    A warm-up that the data show is left out: then its reason is in the data. So is a stated
    stabilisation period, as far as the class of the sensor has time to settle.
    """
    limits, cells, span_s = piece.limits(settings.norms, settings.model), piece.cells, piece.span_s
    stamps, means = cells.profile()
    warm_up = fit_warm_up(stamps, means, SETTLED_SHARE * limits.sigma_max_deg)
    stated = settings.runs.stabilization_s
    settled_s = min(stated, settling_time_s(settings.risk)) if isinstance(stated, float) else 0.0
    if warm_up is not None and warm_up.explains(stamps, means, limits.sigma_max_deg):
        settled_s = max(settled_s, warm_up.stabilization_s)
    if settled_s > 0.0:
        cells = cells.after(piece.start_ns + round(settled_s * 1e9))
        span_s = max(0.0, span_s - settled_s)
    values = cells.values()
    evidence = gather_evidence(
        cells, n_plus=0, n_plus_plus=0, span_s=span_s,
        mean_deg=None if values is None else values.mean_deg,
        offset_u_deg=settings.installation_offset_u_deg)
    return JudgedPiece(piece.start_ns, piece.end_ns, piece.cells.n, evidence, limits)


def find_left_out(pieces: Iterable[JudgedPiece], stretches: Iterable[Sequence[Stretch]],
                  settings: Settings) -> TakenOut | None:
    """
    Account for what the runs leave out, and decide on the record as recorded.

    Parameters
    ----------
    pieces
        Pieces of all inputs; equal pieces count once.
    stretches
        What is left out, with reasons.
    settings
        Uses risks, variant and the rule of the campaign.

    Returns
    -------
    TakenOut or None
        None if nothing is left out; without `as_recorded` if no piece is known.

    """
    rows = [row for row in sum_stretches(stretches) if row.n]
    n = sum(row.n for row in rows)
    if not n:
        return None
    distinct = list({(p.start_ns, p.end_ns, p.n): p for p in pieces}.values())
    total = sum(p.n for p in distinct)
    share = min(1.0, n / total) if total else 1.0
    if not distinct:
        return TakenOut(n, share, tuple(rows), None)
    outcome = _decide(distinct, settings)
    return TakenOut(n, share, tuple(rows), AsRecorded(
        outcome, 'holds', OUTCOME_WORDS[outcome.value], total, None))


def _decide(pieces: Sequence[JudgedPiece], settings: Settings) -> Outcome:
    """Return the outcome of all pieces, by the rule of the campaign."""
    risk = risk_at_the_end(settings)
    evidence, limits = [p.evidence for p in pieces], [p.limits for p in pieces]
    if settings.campaign.rule == 'sensor':
        shared = judge_together(evidence, limits, risk, settings.variant,
                                shortest_apart_s(pieces))
        return conclude_sensor(shared, limits, True, risk)[0]
    outcomes = [decide(p.evidence, p.limits, risk_at_the_end(settings, p.evidence.span_s)).outcome
                for p in pieces]
    return conclude_every_run(outcomes, outcomes)[0]
