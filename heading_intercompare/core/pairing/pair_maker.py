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

"""The pairs of two sensors: all that are made, and those that are judged."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.records import Pairs

from .pair_sampling import PairSampler
from .pairer import Pairer


@dataclass(slots=True)
class PairMaker:
    """
    Makes the pairs of two sensors.

    Attributes
    ----------
    pairer
        Pairs the readings.
    sampler
        Chooses the pairs to judge; None: all are judged.
    newest_ns
        Stamp of the newest pair; None before the first.

    """

    pairer: Pairer
    sampler: PairSampler | None = None
    newest_ns: int | None = None

    def choose(self, pairs: Pairs, end: bool = False) -> Pairs:
        """Return the pairs to judge, of those that the pairer returned; `end`: no more follow."""
        if len(pairs):
            self.newest_ns = int(pairs.stamp_ns[-1])
        return pairs if self.sampler is None else self.sampler.update(pairs, end)

    def go_on_from(self, before: PairMaker) -> None:
        """Go on where another maker was."""
        self.pairer, self.sampler, self.newest_ns = (
            before.pairer, before.sampler, before.newest_ns)
