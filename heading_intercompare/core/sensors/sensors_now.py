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

"""All pairs of sensors in the rolling window, and the vote on them: what is now, not a verdict."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any, Iterable, Mapping, Sequence

from heading_intercompare.core.alarms.alarm import Rule, Sign

from .vote import find_wrong, Vote

_CLEAR_S = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PairNow:
    """
    The differences of two sensors in the rolling window. A missing figure is None.

    Attributes
    ----------
    first, second
        Names of the sensors; the difference is first - second.
    n
        Number of differences.
    newest_ns
        Stamp of the newest one.
    mean_deg, std_deg
        Their mean and standard deviation, degrees.
    lower_bound_deg2, limit_deg2
        Lower bound of their variance, and the largest one that the norms of both explain, square
        degrees.
    gross
        Whether the mean is larger than any installation explains.

    """

    first: str
    second: str
    n: int = 0
    newest_ns: int | None = None
    mean_deg: float | None = None
    std_deg: float | None = None
    lower_bound_deg2: float | None = None
    limit_deg2: float | None = None
    gross: bool = False

    @property
    def names(self) -> tuple[str, str]:
        """Return the names of both sensors."""
        return self.first, self.second

    @property
    def differs(self) -> bool | None:
        """Whether they differ by more than the norms of both explain; None if nobody knows."""
        if self.gross:
            return True
        if self.lower_bound_deg2 is None or self.limit_deg2 is None:
            return None
        return self.lower_bound_deg2 > self.limit_deg2

    @property
    def share(self) -> float | None:
        """Return the standard deviation as a share of what the norms of both explain."""
        if self.std_deg is None or not self.limit_deg2:
            return None
        return self.std_deg / math.sqrt(self.limit_deg2)


def describe_now(names: tuple[str, str], figures: Mapping[str, Any],
                 mean_max_deg: float) -> PairNow:
    """
    Return what the rolling window says of a pair.

    Parameters
    ----------
    names
        Of its sensors.
    figures
        Those of `Compliance.rolling_figures`, as numbers or as the texts of a message.
    mean_max_deg
        Largest mean difference that an installation explains, degrees.

    Examples
    --------
    >>> describe_now(('a', 'b'), {'n': '200', 'lower_bound_deg2': '0.2',
    ...                           'rejection_limit_deg2': '0.1'}, 15.0).differs
    True

    """
    newest_ns = figures.get('newest_ns')
    mean_deg = _real(figures.get('mean_deg'))
    return PairNow(
        first=names[0], second=names[1], n=int(figures.get('n', 0)),
        newest_ns=None if newest_ns is None else int(newest_ns), mean_deg=mean_deg,
        std_deg=_real(figures.get('std_deg')),
        lower_bound_deg2=_real(figures.get('lower_bound_deg2')),
        limit_deg2=_real(figures.get('rejection_limit_deg2')),
        gross=mean_deg is not None and abs(mean_deg) > mean_max_deg)


def _real(value: Any) -> float | None:
    """Return a figure; None if it is missing or no number."""
    if value is None or math.isnan(number := float(value)):
        return None
    return number


def vote_now(names: Sequence[str], pairs: Iterable[PairNow]) -> Vote:
    """
    Return the vote on the rolling window.

    Notes
    -----
    Each pair differs at the producer's risk. Somebody who looks at it every second for a year
    takes more than that risk, so it raises an alarm and judges nothing.

    """
    return find_wrong(names, {pair.names: pair.differs for pair in pairs})


def name_alarm(name: str) -> str:
    """Return the name of the alarm that the vote names a sensor."""
    return f'{name}_wrong'


def vote_rules(names: Iterable[str]) -> tuple[Rule, ...]:
    """Return an alarm for each sensor: the vote names it."""
    return tuple(Rule(name_alarm(name), clear_s=_CLEAR_S) for name in names)


def vote_signs(names: Iterable[str], vote: Vote, pairs: Sequence[PairNow]) -> dict[str, Sign]:
    """Return what a vote says of each sensor; nothing of one whose pairs nobody knows."""
    return {name_alarm(name): _see(name, vote, pairs) for name in names}


def _see(name: str, vote: Vote, pairs: Sequence[PairNow]) -> Sign:
    own_pairs = [pair for pair in pairs if name in pair.names]
    if name in vote.wrong:
        largest = max((pair.share for pair in own_pairs if pair.share is not None), default=None)
        return Sign(True, vote.words, {} if largest is None else {'largest_share': largest})
    if name in vote.suspected or all(pair.differs is None for pair in own_pairs):
        return Sign(None)
    return Sign(False)
