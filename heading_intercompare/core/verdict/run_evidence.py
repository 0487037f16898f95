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

"""What decides on a run together with other runs, beside the figures of its verdict."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.decision.guarded import Evidence
from heading_intercompare.core.decision.taken_out import Stretch

from .recorded import JudgedPiece


@dataclass(frozen=True, slots=True)
class RunEvidence:
    """
    What decides on a run together with other runs, beside the figures of its verdict.

    Attributes
    ----------
    fingerprint
        By which its readings are known in another run; None if there are too few.
    pieces
        The record of its input around it, as the sensors made it.
    outside
        Pairs of its input that lie in no run, with the first run of the input.

    """

    evidence: Evidence
    fingerprint: str | None
    pieces: tuple[JudgedPiece, ...]
    outside: tuple[Stretch, ...]
