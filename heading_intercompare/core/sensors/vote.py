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

__all__ = ['find_wrong', 'Vote']

Names = tuple[str, ...]

_FEWEST_VOTERS = 3


@dataclass(frozen=True, slots=True)
class Vote:
    """
    The result of a vote; keys of the JSON.

    Attributes
    ----------
    wrong : tuple of str
        The sensors that differ from all others, while the others do not differ from each other.
        Empty if there is none, or if these pairs cannot tell.
    suspected : tuple of str
        The sensors whose fault would explain every pair that differs, though not all their pairs
        differ. Empty if some are `wrong`, or if several explanations are equally likely.
    one_source : tuple of tuple of str
        Groups of sensors that show one source. A group has one voice.
    words : str
        The result in a sentence.

    """

    wrong: Names
    suspected: Names
    one_source: tuple[Names, ...]
    words: str


def find_wrong(names: Sequence[str], differs: Mapping[tuple[str, str], bool | None],
               one_source: Iterable[tuple[str, str]] = (), beyond: Iterable[str] = ()) -> Vote:
    """
    Find the sensors whose fault explains the pairs that differ.

    Parameters
    ----------
    names : sequence of str
        The sensors.
    differs : mapping of (str, str) to bool or None
        For each pair whether it differs; None if it was not testable.
    one_source : iterable of (str, str)
        Pairs that show one source.
    beyond : iterable of str
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
    between = {frozenset((i, j)): _judge(groups[i], groups[j], differs)
               for i, j in combinations(range(len(groups)), 2)}
    differing = [pair for pair, found in between.items() if found]
    if not differing:
        tested = [pair for pair, found in between.items() if found is not None]
        words = ('no pair was testable' if not tested else
                 'no two sensors differ by more than their norms explain' +
                 ('' if len(tested) == len(between) else
                  f'; {len(tested)} of {len(between)} pairs were testable'))
        return Vote((), (), joined, words + _say_joined(joined))
    pairs = '; '.join(' and '.join(_name(groups[at]) for at in sorted(pair)) + ' differ'
                      for pair in differing)
    if len(groups) < _FEWEST_VOTERS:
        return Vote((), (), joined, f'{pairs}; two sensors cannot tell which of them is '
                    f'wrong{_say_joined(joined)}')
    sets = _explain(len(groups), differing)
    if len(sets) > 1:
        large = {*beyond}
        likely = [some for some in sets if all(large & {*groups[at]} for at in some)]
        if len(likely) == 1:
            members = tuple(name for at in sorted(likely[0]) for name in groups[at])
            return Vote((), members, joined, f'{_list(members)} is suspected: {pairs}; other '
                        'sensors could explain that, too, but its share of the variances of all '
                        f'pairs is beyond its norm{_say_joined(joined)}')
    if len(sets) != 1:
        why = ('no majority of the sensors agrees' if not sets else
               'more than one sensor could explain that')
        return Vote((), (), joined, f'{pairs}; {why}{_say_joined(joined)}')
    found = sets[0]
    names_found = tuple(name for at in sorted(found) for name in groups[at])
    rest = [at for at in range(len(groups)) if at not in found]
    proven = all(between[frozenset((at, other))] for at in found for other in rest)
    agree = all(between[frozenset(pair)] is False for pair in combinations(rest, 2))
    others = _list([_name(groups[at]) for at in rest])
    verb = 'differs' if len(names_found) == 1 else 'differ'
    if proven and agree:
        return Vote(names_found, (), joined, f'{_list(names_found)} {verb} from {others}, which '
                    f'do not differ from each other{_say_joined(joined)}')
    kept = [at for at in found for other in rest if not between[frozenset((at, other))]]
    why = 'not all its pairs differ' if kept else 'not every pair was testable'
    return Vote((), names_found, joined, f'{_list(names_found)} is suspected: {pairs}; it is part '
                f'of each pair that differs, but {why}{_say_joined(joined)}')


def _join(names: Sequence[str], one_source: Iterable[tuple[str, str]]) -> list[Names]:
    """Return the sensors in groups of one source each, in the order of the names."""
    of = {name: {name} for name in names}
    for first, second in one_source:
        together = of[first] | of[second]
        for name in together:
            of[name] = together
    return list(dict.fromkeys(tuple(name for name in names if name in of[each])
                              for each in names))


def _judge(first: Names, second: Names,
           differs: Mapping[tuple[str, str], bool | None]) -> bool | None:
    """Tell whether two groups differ: if any of their pairs does; None if none was testable."""
    found = [each for a in first for b in second
             if (each := differs.get((a, b), differs.get((b, a)))) is not None]
    return any(found) if found else None


def _explain(n: int, differing: Sequence[frozenset[int]]) -> list[tuple[int, ...]]:
    """Return the smallest sets of fewer than half that are part of every differing pair."""
    for size in range(1, (n - 1) // 2 + 1):
        found = [some for some in combinations(range(n), size)
                 if all(pair & {*some} for pair in differing)]
        if found:
            return found
    return []


def _name(group: Names) -> str:
    return '/'.join(group)


def _list(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f'{", ".join(names[:-1])} and {names[-1]}'


def _say_joined(joined: Sequence[Names]) -> str:
    return ''.join(f'; {_list(group)} show one source and have one voice' for group in joined)
