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

"""The motion of the ship in a recording: positions, velocities and rates of turn by topic."""

from __future__ import annotations

from functools import partial
from typing import Mapping, NamedTuple, Sequence

from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.records import Motion
from heading_intercompare.core.settings import MotionRule
from heading_intercompare.messages.motion.motion_messages import (
    MOTION_TYPES,
    read_motion,
)

from .readable import read_rows, Readable
from .topic_names import find_elsewhere

_WORDS = {'fix': 'positions', 'velocity': 'velocity over ground', 'rate': 'rate of turn'}


class BagMotion(NamedTuple):
    """
    The motion of the ship in a recording.

    Attributes
    ----------
    rows
        Without rows that tell nothing; in the order of the recording, topic by topic.
    topics
        The topics read, by what they tell.
    unreadable
        Messages that could not be read.

    """

    rows: Motion
    topics: dict[str, str]
    unreadable: int


def motion_topics(rule: MotionRule) -> dict[str, str]:
    """Return the topics that settings name, by what they tell: 'fix', 'velocity', 'rate'."""
    return {'fix': rule.fix_topic, 'velocity': rule.velocity_topic, 'rate': rule.rate_topic}


def find_motion_topics(bag: Readable, rule: MotionRule) -> dict[str, list[tuple[str, str]]]:
    """
    Return the topics of a recording with the motion of the ship.

    Parameters
    ----------
    bag
        The recording.
    rule
        Its topics. A topic with the default name may be absent, and then tells nothing.

    Returns
    -------
    dict of str to list of (str, str)
        By the name in the bag, what each topic tells, and its type.

    Raises
    ------
    OSError, BagError
        If the recording cannot be read, lacks a topic of another name than the default, or has
        one of another type; one line that says which types are read.

    """
    topics: dict[str, list[tuple[str, str]]] = {}
    others: list[str] = []
    default = motion_topics(MotionRule())
    for what, topic in motion_topics(rule).items():
        if topic == default[what] and bag.find(topic) is None:
            others += find_elsewhere(bag.topics, topic, bag.namespace)
            continue
        name = bag.resolve(topic)
        kind = bag.topics[name].type_name
        if kind not in MOTION_TYPES[what]:
            raise BagError(f'topic {name} is {kind or "without a schema"}; the {_WORDS[what]} of '
                           f'a ship are {", ".join(MOTION_TYPES[what])}; name another topic with '
                           f'motion.{what}_topic', bag.path)
        topics.setdefault(name, []).append((what, kind))
    if others:
        bag.oddities.append(f'the motion of another graph ({", ".join(others)}) does not count; '
                            'bag_namespace names another')
    return topics


def read_bag_motion(bag: Readable, rule: MotionRule) -> BagMotion:
    """
    Read the motion of the ship from a recording.

    Parameters
    ----------
    bag
        The recording.
    rule
        As for `find_motion_topics`.

    Raises
    ------
    OSError, BagError
        As for `find_motion_topics`.

    """
    topics = find_motion_topics(bag, rule)
    rows, unreadable = _read(bag, topics)
    return BagMotion(rows, {what: name for name, quantities in topics.items()
                            for what, _ in quantities}, unreadable)


def read_fixes(bag: Readable, topic: str) -> tuple[Motion, int]:
    """
    Return the positions of one antenna, and the number of messages that could not be read.

    Parameters
    ----------
    bag
        The recording.
    topic
        A topic of NavSatFix.

    Raises
    ------
    OSError, BagError
        If the recording cannot be read, or lacks the topic, or has it with another type.

    """
    name = bag.resolve(topic)
    kind = bag.topics[name].type_name
    if kind not in MOTION_TYPES['fix']:
        raise BagError(f'topic {name} is {kind or "without a schema"}; the positions of an '
                       f'antenna are {", ".join(MOTION_TYPES["fix"])}', bag.path)
    return _read(bag, {name: [('fix', kind)]})


def _read(bag: Readable, topics: Mapping[str, Sequence[tuple[str, str]]]) -> tuple[Motion, int]:
    """Return the rows of topics, each with quantities and type; count unreadable messages."""
    chunks, unreadable = read_rows(bag, {name: [
        partial(read_motion, kind, what) for what, kind in quantities]
        for name, quantities in topics.items()})
    return Motion.concatenate(chunks), unreadable
