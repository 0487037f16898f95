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

"""What people see of several sensors: a row for each, the vote now, and the last verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Mapping, Sequence

from heading_intercompare.core.sensor_table import find_reference, Sensor
from heading_intercompare.messages.status_messages import Status
from heading_intercompare.web.figures.stream_watch import SensorView

from .bridge_records import LampView, Tone
from .verdict_lamp import make_lamp
from .view_texts import real, shorten

_LONGEST = 400
_NONE_YET = LampView()


@dataclass(frozen=True, slots=True)
class SensorRow:
    """
    One sensor at a moment.

    Attributes
    ----------
    reference
        It is the reference of all others.
    now
        What it reports.
    against
        The other sensor of the figures: the reference, or without one the sensor that it is
        nearest to. '' if there are none.
    mean_deg, std_deg, share
        Mean and standard deviation of its difference from that sensor in the window, degrees, and
        the latter as a share of what the norms of both explain.
    lamp
        Its last outcome.
    named
        The vote on the window names it as wrong.
    difference_deg
        Its newest difference from the reference, wrapped, the installation offset removed,
        degrees; None if there is none or it is stale.
    title
        What people call it.
    state
        What is wrong with it, in a word; '' if nothing is.

    """

    name: str
    reference: bool = False
    now: SensorView = SensorView()
    against: str = ''
    mean_deg: float | None = None
    std_deg: float | None = None
    share: float | None = None
    lamp: LampView = _NONE_YET
    named: bool = False
    difference_deg: float | None = None
    title: str = ''
    state: str = ''


@dataclass(frozen=True, slots=True)
class SensorsView:
    """
    All sensors at a moment.

    Attributes
    ----------
    rows
        In the order of the settings.
    vote
        The vote on the rolling window, in words; '' before the first.
    age_s
        Age of all this, seconds.

    """

    rows: tuple[SensorRow, ...] = ()
    vote: str = ''
    vote_tone: Tone = Tone.NONE
    age_s: float | None = None
    stale: bool = True


class SensorsPanel:
    """
    Takes what is published of all sensors; memory is bounded.

    Parameters
    ----------
    sensors
        Nothing is shown of others.
    stale_s
        Age after which figures are stale, seconds.

    """

    def __init__(self, sensors: tuple[Sensor, ...], stale_s: float) -> None:
        self._sensors, self._stale_s = sensors, stale_s
        reference = find_reference(sensors)
        self._reference = '' if reference is None else reference.name
        self._figures: dict[str, Mapping[str, str]] = {}
        self._vote: Status | None = None
        self._verdict: dict[str, Status] = {}
        self._verdict_ns = 0
        self._came_s: float | None = None

    def take_figures(self, statuses: Sequence[Status], now_s: float) -> None:
        """Take `sensors/figures`."""
        self._figures, self._came_s = {status.name: status.values for status in statuses}, now_s

    def take_vote(self, statuses: Sequence[Status]) -> None:
        """Take `sensors/vote`."""
        self._vote = next((status for status in statuses if status.name == 'now'), None)

    def take_verdict(self, stamp_ns: int, statuses: Sequence[Status]) -> None:
        """Take `sensors/verdict`."""
        self._verdict, self._verdict_ns = {status.name: status for status in statuses}, stamp_ns

    @property
    def lamp(self) -> LampView:
        """Return the last verdict on all sensors."""
        return self._light('verdict', 'of all sensors')

    def _light(self, name: str, what: str = '') -> LampView:
        status = self._verdict.get(name)
        if status is None or 'outcome' not in status.values:
            return _NONE_YET
        return make_lamp(status.values['outcome'], status.values.get('validity', ''),
                         self._verdict_ns, what, status.message)

    def view(self, now_s: float) -> SensorsView:
        """Return what to show at a time of the steady clock, seconds."""
        age_s = None if self._came_s is None else now_s - self._came_s
        stale = age_s is None or age_s > self._stale_s
        vote = self._vote
        named = () if vote is None or stale else vote.values.get('wrong', '').split()
        tone = Tone.NONE if vote is None else (Tone.NONE, Tone.DOUBT, Tone.BAD)[min(vote.level, 2)]
        return SensorsView(
            rows=tuple(self._view_row(sensor, age_s or 0.0, stale, sensor.name in named)
                       for sensor in self._sensors),
            vote='' if vote is None else shorten(vote.message, _LONGEST),
            vote_tone=Tone.DOUBT if stale else tone, age_s=age_s, stale=stale)

    def _view_row(self, sensor: Sensor, age_s: float, stale: bool, named: bool) -> SensorRow:
        values = self._figures.get(sensor.name, {})
        told_s = real(values.get('age_s'))
        silent = stale or values.get('stale', 'true') == 'true'
        now = SensorView(
            heading_deg=None if silent else real(values.get('heading_deg')),
            last_deg=real(values.get('last_deg')),
            age_s=None if told_s is None else told_s + age_s,
            rate_hz=real(values.get('rate_hz')), offset_s=real(values.get('offset_s')),
            stale=silent, flagged=values.get('flagged') == 'true')
        against, mean_deg, std_deg, share = self._find_pair(sensor.name)
        return SensorRow(
            name=sensor.name, reference=sensor.is_reference, now=now, against=against,
            mean_deg=mean_deg, std_deg=std_deg, share=share, lamp=self._light(sensor.name),
            named=named)

    def _find_pair(self, name: str) -> tuple[str, float | None, float | None, float | None]:
        """Return the figures against the reference; without one, against the nearest sensor."""
        rows = []
        for sensor in self._sensors:
            for pair, sign in ((f'{name} - {sensor.name}', 1.0),
                               (f'{sensor.name} - {name}', -1.0)):
                values = self._figures.get(pair)
                if values is None or self._reference not in ('', sensor.name):
                    continue
                mean_deg, std_deg, share = (
                    real(values.get(key)) for key in ('mean_deg', 'std_deg', 'share'))
                if std_deg is not None:
                    rows.append((sensor.name, None if mean_deg is None else sign * mean_deg,
                                 std_deg, share))
        return min(rows, key=lambda row: row[3] if row[3] is not None else row[2],
                   default=('', None, None, None))
