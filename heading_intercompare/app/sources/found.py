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

"""What the judging of one source found."""

from __future__ import annotations

from dataclasses import dataclass, field

from heading_intercompare.bags.csv.motion_text import text_of_motion
from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.core.pairing.ledger import Ledger
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.judge import RunResult
from heading_intercompare.core.verdict.verdict_document import Input

__all__ = ['Found', 'make_account']


@dataclass(frozen=True, slots=True)
class Found:
    """
    The runs of one source, and the account of its readings.

    Attributes
    ----------
    results, earlier : list of RunResult
        The runs of the verdict, and those that are too old for it (`runs.keep`).
    ledger : Ledger
    described : Input
        Its entry in the verdict.
    notes : tuple of str
        What the user should know about it, beside the problems in `described`.
    marks : tuple of (str, int)
        Marks of runs, 'start' or 'stop' and the stamp.
    table : tuple of (int, int), or None
        Start and stop of the runs, if a table gave them.
    account : PairsAccount or None
        The account that came with it, if it is a csv of pairs.
    motion : Motion
        The motion of the ship.
    remarks : tuple of str
        What the user should know, and what is no problem.

    """

    results: list[RunResult]
    earlier: list[RunResult]
    ledger: Ledger
    described: Input
    notes: tuple[str, ...] = ()
    marks: tuple[tuple[str, int], ...] = ()
    table: tuple[tuple[int, int], ...] | None = None
    account: PairsAccount | None = None
    motion: Motion = field(default_factory=Motion.empty)
    remarks: tuple[str, ...] = ()


def make_account(found: Found, settings: Settings, *others: Input) -> PairsAccount:
    """Return the account to lay beside the pairs of a source; `others` also gave readings."""
    if found.account is not None:
        # Pairs that were read from a csv are still those of its recording.
        return found.account
    ledger = found.ledger
    steps = tuple(one for some in ledger.set_backs.values() for one in some)
    return PairsAccount((found.described, *others), settings.to_mapping(), found.marks,
                        found.table, ledger.newest_ns, ledger.segments, steps,
                        motion=text_of_motion(found.motion))
