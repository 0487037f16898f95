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

"""What a judgement in progress remembers apart from the pairs of its run, as text and back."""

from __future__ import annotations

from dataclasses import dataclass
import json

from heading_intercompare.core.runs.run_cutter import CutterState

from .segment_runs import SegmentState
from .typed_reader import make_plain, read_plain


@dataclass(frozen=True, slots=True)
class KeptState:
    """
    The state of a `Compliance`, without the pairs of the run in progress.

    Attributes
    ----------
    cutter
        Where runs start and end.
    newest_ns
        Stamp of the newest pair.
    in_run
        A run is in progress; its cut is that of the cutter.
    segments
        The clock segments that the verdict counts, n >= 1, the present one last.
    n_earlier
        Number of runs that were too old for the verdict and handed out.
    outside
        What pairs outside the runs are called.
    first_pair
        Pairs of the present segment before the run in progress.

    """

    cutter: CutterState
    newest_ns: int | None
    in_run: bool
    segments: tuple[SegmentState, ...]
    n_earlier: int
    outside: str
    first_pair: int

    @property
    def n_judged(self) -> int:
        """Return the number of runs judged so far."""
        return self.n_earlier + sum(len(segment.finished) for segment in self.segments)

    def to_text(self) -> str:
        """Return the state as text; `from_text` gives the same state to the bit."""
        return json.dumps(make_plain(self, exact=True))

    @classmethod
    def from_text(cls, text: str) -> 'KeptState':
        """
        Return the state in a text of `to_text`.

        Raises
        ------
        ValueError
            If the text is not a state.

        """
        state = read_plain(cls, json.loads(text), 'state')
        assert isinstance(state, cls)
        return state
