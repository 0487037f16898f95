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

"""The figure of a plan: the chance of an outcome by the length of the run."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from heading_intercompare.core.decision.trial_plan import Chance, OUTCOMES

from .drawing import Drawing, LIMIT, MEAN, SERIES, SIGMA, START

_LOOKS = (SERIES, LIMIT, MEAN)
_MARKERS = ('o', 's', '^')

Line = Sequence[tuple[float, float, tuple[float, float]]]
"""Length of a run in hours, chance and its interval; rising."""


def list_lines(chances: Sequence[Chance]) -> dict[str, Line]:
    """Return the chances of single runs: of each outcome, or of compliance by level."""
    runs = [chance for chance in chances if chance.runs == 1]
    levels = [*dict.fromkeys(chance.level for chance in runs)]
    if levels == [None]:
        return {outcome.words: [(chance.duration_s / 3600.0, chance.shares[at],
                                 chance.intervals[at]) for chance in runs]
                for at, outcome in enumerate(OUTCOMES)}
    return {f'compliant, TS at {level:g} of its norm': [
        (chance.duration_s / 3600.0, chance.compliant, chance.intervals[0])
        for chance in runs if chance.level == level] for level in levels}


def draw_chances(lines: Mapping[str, Line], title: str, *, least_s: float,
                 probability: float) -> Drawing:
    """
    Return the figure of chances with their 95 % intervals.

    Parameters
    ----------
    lines
        At most three; see `list_lines`.
    title
        Says of which trial, and of how many.
    least_s
        Least length of a run that may comply, seconds.
    probability
        Probability of certifying that is aimed at.

    """
    def fill(axes: Any) -> None:
        """Draw a line for each outcome or level; the lengths side by side, so bars stay apart."""
        longest_h = max(hours for line in lines.values() for hours, _, _ in line)
        for at, (label, line) in enumerate(lines.items()):
            hours, chance, interval = (np.array(column) for column in zip(*line))
            axes.errorbar(hours + (at - 1) * 0.006 * longest_h, 100.0 * chance,
                          np.abs(100.0 * (interval.T - chance)), marker=_MARKERS[at],
                          markersize=3.5, capsize=2.0, elinewidth=0.7, label=label, **_LOOKS[at])
        axes.axhline(100.0 * probability, **SIGMA, zorder=1, label='probability to certify with')
        if least_s <= 3600.0 * longest_h:
            axes.axvline(least_s / 3600.0, **START, label='shortest run that may comply')
        axes.set_xlim(0.0, 1.04 * longest_h)
        axes.set_ylim(-4.0, 104.0)

    return Drawing(name='chances', title=title, caption='The bars are 95 % intervals.',
                   x_label='length of the run [h]', y_label='chance [%]', fill=fill)
