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

"""Bags of one trial: after a crash, a new bag goes on and names the one before it."""

from __future__ import annotations

from datetime import datetime, timezone
import os
from pathlib import Path
from typing import Iterable, Sequence

from .bag_reader import BagReader
from .provenance import read_continues
from .publisher_starts import read_starts
from .readable import Readable


def find_parts(paths: Sequence[str]) -> dict[str, list[str]]:
    """
    Return which inputs go on with the trial of another input.

    Parameters
    ----------
    paths
        The inputs.

    Returns
    -------
    dict of str to list of str
        For the first bag of each trial of several bags, the other bags in their order.

    """
    bags = {Path(os.path.abspath(path)).name: path for path in paths}
    before = {}
    for path in paths:
        name = _read_continues(path) if len(paths) > 1 else None
        if name is not None and bags.get(name, path) != path:
            before[path] = bags[name]
    parts: dict[str, list[str]] = {}
    for path in paths:
        if path not in before:
            chain = [path]
            while after := [successor for successor, earlier in before.items()
                            if earlier == chain[-1] and successor not in chain]:
                chain.append(after[0])
            if len(chain) > 1:
                parts[path] = chain[1:]
    return parts


def is_joined(before: Readable, after: Readable, topics: Iterable[str]) -> bool:
    """
    Tell whether only the recorder was away between two bags of a trial.

    Then a publisher of one of the topics went on, and the second recorder took what it still held.
    """
    return any(_follows(before, after, topic) for topic in topics)


def _follows(before: Readable, after: Readable, topic: str) -> bool:
    starts, next_starts = (read_starts(bag).get(bag.find(topic) or '', [])
                           for bag in (before, after))
    publishers = [start.publisher for start in starts if start.publisher]
    return bool(publishers and next_starts) and publishers[-1] == next_starts[0].publisher


def name_first() -> str:
    """Return the name of a bag that begins now: heading_<UTC>."""
    return f'heading_{datetime.now(timezone.utc):%Y%m%dT%H%M%SZ}'


def name_next(output: str) -> str:
    """Return the name of the next bag of a trial: NAME_2, NAME_3 and so on, if NAME is there."""
    return _list_names(output)[-1]


def find_place(output: str) -> tuple[str, str | None]:
    """
    Return where to record a trial that may have begun, and which bag it goes on with.

    Parameters
    ----------
    output
        The path of the bag to record.

    Returns
    -------
    place : str
        The same name, or the next name that is free.
    continues : str or None
        Name of the newest bag that is there, if its recorder was cut off.

    """
    *bags, place = _list_names(output)
    try:
        cut_off = bool(bags) and BagReader(bags[-1]).incomplete is not None
    except (OSError, ValueError):
        cut_off = False
    return place, Path(bags[-1]).name if cut_off else None


def _list_names(output: str) -> list[str]:
    """Return the names of the bags that are there, and the first that is free."""
    names = [output]
    while os.path.exists(names[-1]):
        names.append(f'{output.rstrip("/")}_{len(names) + 1}')
    return names


def _read_continues(path: str) -> str | None:
    """Return the name of the bag before this one; None if there is none, or no bag."""
    if Path(path).suffix == '.csv':
        return None
    try:
        return read_continues(BagReader(path))
    except (OSError, ValueError):
        return None
