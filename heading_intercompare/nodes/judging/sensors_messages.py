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

"""The comparison of several sensors as diagnostic messages: each one now, all pairs, the vote."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

from heading_intercompare.core.sensors.sensors_now import PairNow
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.sensors.vote import Vote
from heading_intercompare.messages.status_messages import (
    encode_statuses,
    ERROR,
    OK,
    Status,
    WARN,
)
from heading_intercompare.messages.verdict_messages import verdict_level

FIGURES_TOPIC = 'sensors/figures'
VOTE_TOPIC = 'sensors/vote'
SENSORS_VERDICT_TOPIC = 'sensors/verdict'


def encode_sensors_figures(sensors: Mapping[str, Mapping[str, Any]], pairs: Sequence[PairNow],
                           ns: int, owner: str = '') -> bytes:
    """
    Return the figures of sensors and pairs in the rolling window as a message of `STATUS_TYPE`.

    Parameters
    ----------
    sensors
        The figures of each sensor, by name.
    pairs
        Each becomes a status ``first - second``.
    ns
        The newest stamp, nanoseconds.
    owner
        The node that says so.

    """
    sensor_statuses = [Status(name, OK, 'figures, not a verdict', figures)
                       for name, figures in sensors.items()]
    both = [Status(f'{pair.first} - {pair.second}', OK, 'figures, not a verdict', {
        'n': pair.n, 'newest_ns': pair.newest_ns, 'mean_deg': pair.mean_deg,
        'std_deg': pair.std_deg, 'lower_bound_deg2': pair.lower_bound_deg2,
        'limit_deg2': pair.limit_deg2, 'share': pair.share, 'differs': pair.differs})
        for pair in pairs]
    return encode_statuses(ns, [*sensor_statuses, *both], owner)


def encode_vote(now: Vote, judged: Vote | None, ns: int, owner: str = '') -> bytes:
    """
    Return the votes on the rolling window and on the judged runs as a message of `STATUS_TYPE`.

    The statuses are ``now``, which is no verdict, and ``judged``, if a run was.
    """
    return encode_statuses(ns, [
        _say_vote('now', now), *([] if judged is None else [_say_vote('judged', judged)])], owner)


def _say_vote(name: str, vote: Vote) -> Status:
    level = ERROR if vote.wrong else WARN if vote.suspected else OK
    return Status(name, level, vote.words, {
        'wrong': ' '.join(vote.wrong), 'suspected': ' '.join(vote.suspected),
        'one_source': ' '.join('/'.join(group) for group in vote.one_source)})


def encode_sensors_verdict(verdict: SensorsVerdict, ns: int, owner: str = '') -> bytes:
    """Return a verdict: its headline, the outcome of each tested sensor, and the vote."""
    whole = Status('verdict', verdict_level(verdict.outcome, verdict.validity_effect),
                   verdict.headline, {'outcome': verdict.outcome,
                                      'validity': verdict.validity_effect,
                                      'pairs': len(verdict.pairs)})
    sensor_statuses = [Status(sensor.name, OK if sensor.outcome is None else verdict_level(
        sensor.outcome, sensor.validity_effect), sensor.headline, {
            'outcome': sensor.outcome, 'validity': sensor.validity_effect,
            'sigma_max_deg': sensor.sigma_max_deg,
            'std_deg': None if sensor.variance is None else sensor.variance.std_deg})
                       for sensor in verdict.sensors]
    return encode_statuses(ns, [whole, *sensor_statuses, _say_vote('vote', verdict.vote)],
                           owner)
