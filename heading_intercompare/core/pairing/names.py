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

"""The names of readings: who published each one, and the number that this publisher gave it."""

from __future__ import annotations

from typing import Iterable, NamedTuple, Sequence


class Span(NamedTuple):
    """
    Numbers that one publisher gave to its messages, without a hole.

    Attributes
    ----------
    publisher
        Its identity in the graph; '' if it is unknown.
    first, last
        The first number and the last one.

    """

    publisher: str
    first: int
    last: int


def count_unknown(spans: Iterable[Span], others: Sequence[Span]) -> int:
    """
    Return how many names in some spans are in none of the others; each name counts once.

    An unknown publisher may be any: a number counts only if nobody among the others gave it.

    Examples
    --------
    >>> count_unknown([Span('a', 1, 20), Span('a', 15, 30)], [Span('a', 5, 28)])
    6
    >>> count_unknown([Span('', 1, 20)], [Span('a', 1, 12), Span('b', 10, 18)])
    2

    """
    by_publisher: dict[str, list[Span]] = {}
    for span in spans:
        by_publisher.setdefault(span.publisher, []).append(span)
    total = 0
    for publisher, sent in by_publisher.items():
        covering = [span for span in others if publisher in ('', span.publisher)
                    or not span.publisher]
        # What a span adds to those that cover it is the size that the union grows by.
        total += _measure([*covering, *sent]) - _measure(covering)
    return total


def _measure(spans: Iterable[Span]) -> int:
    """Return how many numbers lie in at least one span."""
    total = newest = 0
    for span in sorted(spans, key=lambda span: span.first):
        total += max(0, span.last - max(newest, span.first - 1))
        newest = max(newest, span.last)
    return total
