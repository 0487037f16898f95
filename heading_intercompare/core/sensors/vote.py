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

"""
Which of several sensors is wrong: the one whose pairs all differ while the others agree.

A pair differs if its variance is beyond what the norms of both explain, at a stated risk. No
distance to a mean of all sensors is used: one bad sensor would shift it, and two of one source
would outvote a sound one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Iterable, Mapping, Sequence

from heading_intercompare.core.declared_figures import figure

Names = tuple[str, ...]

_FEWEST_VOTERS = 3


@dataclass(frozen=True, slots=True)
class Vote:
    """The result of a vote; keys of the JSON."""

    wrong: Names = figure('sensors that differ from all others, while the others agree',
                          'empty if there is none, or if these pairs cannot tell')
    suspected: Names = figure('sensors whose fault would explain every pair that differs',
                              'empty if some are wrong, or if it is not the only explanation')
    one_source: tuple[Names, ...] = figure('groups that show one source', 'a group has one voice')
    words: str = figure('result in a sentence')


def find_wrong(names: Sequence[str], differs: Mapping[tuple[str, str], bool | None],
               one_source: Iterable[tuple[str, str]] = (), beyond: Iterable[str] = ()) -> Vote:
    """
    Find the sensors whose fault explains the pairs that differ.

    Parameters
    ----------
    names
        The sensors.
    differs
        For each pair whether it differs; None if it was not testable.
    one_source
        Pairs that show one source.
    beyond
        Sensors whose share of the variances of all pairs is beyond their norm. That rests on
        uncorrelated errors, so it may make a sensor suspected where several sets of sensors would
        explain the pairs that differ, but never wrong.

    Returns
    -------
    Vote

    Notes
    -----
    The fewest sensors that are part of every differing pair explain them all. They are named if
    no other set of as few does, and if they are fewer than half: a majority must be sound.

    Examples
    --------
    >>> find_wrong('abc', {('a', 'b'): True, ('a', 'c'): True, ('b', 'c'): False}).wrong
    ('a',)
    >>> find_wrong('ab', {('a', 'b'): True}).words
    'a and b differ; two sensors cannot tell which of them is wrong'

    """
    groups = _join(names, one_source)
    joined = tuple(group for group in groups if len(group) > 1)
    wrong, suspected, words = _Ballot(groups, {
        frozenset((i, j)): _judge(groups[i], groups[j], differs)
        for i, j in combinations(range(len(groups)), 2)}).count({*beyond})
    return Vote(wrong, suspected, joined, words + ''.join(
        f'; {_list(group)} show one source and have one voice' for group in joined))


@dataclass(frozen=True, slots=True)
class _Ballot:
    """Groups of sensors with one voice each, and whether each pair of groups differs."""

    groups: Sequence[Names]
    differs: Mapping[frozenset[int], bool | None]

    def count(self, beyond: set[str]) -> tuple[Names, Names, str]:
        """Return the sensors that are wrong, those that are suspected, and why."""
        differing = [pair for pair, differs in self.differs.items() if differs]
        if not differing:
            return (), (), self._say_that_none_differs()
        pairs = '; '.join(' and '.join(_name(self.groups[at]) for at in sorted(pair)) + ' differ'
                          for pair in differing)
        if len(self.groups) < _FEWEST_VOTERS:
            return (), (), f'{pairs}; two sensors cannot tell which of them is wrong'
        culprits = _explain(len(self.groups), differing)
        if len(culprits) == 1:
            return self._accuse(culprits[0], pairs)
        likely = [at_all for at_all in culprits
                  if all(beyond & {*self.groups[at]} for at in at_all)]
        if len(likely) == 1:
            members = self._members(likely[0])
            return (), members, (
                f'{_list(members)} is suspected: {pairs}; other sensors could explain that, too, '
                'but its share of the variances of all pairs is beyond its norm')
        why = ('no majority of the sensors agrees' if not culprits else
               'more than one sensor could explain that')
        return (), (), f'{pairs}; {why}'

    def _say_that_none_differs(self) -> str:
        n_tested = sum(differs is not None for differs in self.differs.values())
        if not n_tested:
            return 'no pair was testable'
        words = 'no two sensors differ by more than their norms explain'
        if n_tested < len(self.differs):
            words += f'; {n_tested} of {len(self.differs)} pairs were testable'
        return words

    def _accuse(self, culprits: Sequence[int], pairs: str) -> tuple[Names, Names, str]:
        """Return whether the only sensors that explain all pairs are proven wrong."""
        members = self._members(culprits)
        rest = [at for at in range(len(self.groups)) if at not in culprits]
        against = [self.differs[frozenset((at, sound))] for at in culprits for sound in rest]
        agree = all(self.differs[frozenset(pair)] is False for pair in combinations(rest, 2))
        if all(against) and agree:
            verb = 'differs' if len(members) == 1 else 'differ'
            others = _list([_name(self.groups[at]) for at in rest])
            return members, (), (f'{_list(members)} {verb} from {others}, which do not differ '
                                 'from each other')
        why = 'every pair was testable' if all(against) else 'all its pairs differ'
        return (), members, (f'{_list(members)} is suspected: {pairs}; it is part of each pair '
                             f'that differs, but not {why}')

    def _members(self, at_all: Iterable[int]) -> Names:
        return tuple(name for at in sorted(at_all) for name in self.groups[at])


def _join(names: Sequence[str], one_source: Iterable[tuple[str, str]]) -> list[Names]:
    """Return the sensors in groups of one source each, in the order of the names."""
    of = {name: {name} for name in names}
    for first, second in one_source:
        together = of[first] | of[second]
        for name in together:
            of[name] = together
    return list(dict.fromkeys(tuple(name for name in names if name in of[sensor])
                              for sensor in names))


def _judge(first: Names, second: Names,
           differs: Mapping[tuple[str, str], bool | None]) -> bool | None:
    """Tell whether two groups differ: if any of their pairs does; None if no pair was testable."""
    differences = [difference for a in first for b in second
                   if (difference := differs.get((a, b), differs.get((b, a)))) is not None]
    return any(differences) if differences else None


def _explain(n: int, differing: Sequence[frozenset[int]]) -> list[tuple[int, ...]]:
    """Return the smallest sets of fewer than half that are part of every differing pair."""
    for size in range(1, (n - 1) // 2 + 1):
        culprits = [sensors for sensors in combinations(range(n), size)
                    if all(pair & {*sensors} for pair in differing)]
        if culprits:
            return culprits
    return []


def _name(group: Names) -> str:
    return '/'.join(group)


def _list(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f'{", ".join(names[:-1])} and {names[-1]}'
