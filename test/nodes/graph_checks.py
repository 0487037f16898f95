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

"""Logs to play, the verdict on a bag, and whether two verdicts are the same."""

from __future__ import annotations

import json
import math

from checksums import with_checksum
from nodes.ros_nodes import NORMS

from heading_intercompare.app.config import load_config
from heading_intercompare.app.recorded_looks import find_looks
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.motion_topics import read_bag_motion
from heading_intercompare.core.pipeline import Intercomparison
from heading_intercompare.core.settings import MotionRule, Settings

#: What a verdict says of where its data came from, and of who acted while they came.
SOURCES = {'source', 'inputs', 'recordings', 'operator_actions'}


def log(path, n, first_s, heading_deg):
    """Write a log of n HDT sentences, 5 per second."""
    lines = []
    for i in range(n):
        body = f'HEHDT,{heading_deg + 0.02 * (i * 7 % 11):.2f},T'
        minutes, seconds = divmod(first_s + i / 5, 60)
        lines.append(f'2014-08-01T00:{minutes:02.0f}:{seconds:09.6f}Z {with_checksum(body)}\n')
    path.write_text(''.join(lines))
    return f'file:{path}'


def count_recorded(bag, topic='/ts/heading') -> int:
    """Return how many messages of a topic are in a bag that may be open."""
    try:
        info = BagReader(bag).topics.get(topic)
    except (OSError, ValueError):
        return 0
    return info.count if info else 0


def settings_for_bags(rule, *paths):
    """Return settings with the looks by which bags were judged live, as `analyze` takes them."""
    looks = find_looks(load_config(None), (), [str(path) for path in paths])
    return Settings.from_mapping({**looks, **rule})


def offline(path, **settings):
    """Return the verdict on a bag."""
    comparison = Intercomparison(settings_for_bags({**NORMS, **settings}, path))
    conventions = {'ts/heading': 'enu', 'rs/heading': 'enu'}
    comparison.take_motion(read_bag_motion(BagReader(path), MotionRule()).rows)
    for chunk in BagReader(path).headings(conventions):
        comparison.update(ts=chunk['ts/heading'], rs=chunk['rs/heading'])
    comparison.finish()
    return json.loads(json.dumps(comparison.verdict().to_dict()))


def assert_same(a, b, path=''):
    """Equal words and integers, reals to 1e-12 relative or 1e-14; but not where data came from."""
    if isinstance(a, dict):
        assert a.keys() - SOURCES == b.keys() - SOURCES, path
        for key in a.keys() - SOURCES:
            assert_same(a[key], b[key], f'{path}.{key}')
    elif isinstance(a, list):
        assert len(a) == len(b), path
        for at, (x, y) in enumerate(zip(a, b)):
            assert_same(x, y, f'{path}[{at}]')
    elif isinstance(a, float) and isinstance(b, float):
        assert math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-14), f'{path}: {a!r} {b!r}'
    else:
        assert a == b, path
