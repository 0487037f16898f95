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

"""Everything that the live page shows, from the messages of the graph and a steady clock."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
import math
from typing import Mapping, Sequence

from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.sensors.compared_sensors import list_sensors, pair_with_reference
from heading_intercompare.core.sensors.pair_settings import settings_of_pair
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.ledger_messages import LedgerMessage
from heading_intercompare.messages.status_messages import ERROR, OK, Status, WARN
from heading_intercompare.web.figures.difference_watch import DifferenceWatch
from heading_intercompare.web.figures.stream_watch import SensorView, StreamWatch

from .alert_list import AlertList, state_of
from .bridge_records import (
    AlarmView,
    AlertView,
    BagView,
    JudgedRunView,
    JudgedTestView,
    LampView,
    NodeView,
    RunView,
    Tone,
    TrendView,
    ValidityView,
    WindowView,
)
from .judged_runs import list_runs, list_tests
from .sensors_panel import SensorRow, SensorsPanel, SensorsView
from .verdict_lamp import light_lamp
from .view_texts import integer, lacking_words, real, shorten

#: Names in messages of others must not fill the memory.
_MOST_NODES, _MOST_ALARMS, _MOST_PARTS, _LONGEST = 50, 200, 100, 300
_MOST_STRETCHES = 100
#: A node that has kept silent for this time has ended; its states are dropped.
_FORGET_S = 600.0


@dataclass(frozen=True, slots=True)
class BridgeView:
    """
    Everything that the page shows, at a moment.

    Attributes
    ----------
    ts, rs
        The two sensors.
    difference_deg
        TS - RS of the newest pair, wrapped, the installation offset removed, degrees; None if
        it is stale.
    last_difference_deg, difference_age_s
        The last difference, however old, degrees; its age, seconds.
    turn_deg_min
        Rate of turn by the RS, otherwise by the TS, degrees per minute, positive to starboard.
    paired_share
        Share of the readings that were paired in the last minute.
    paired, rejected
        Pairs made, and readings rejected, by the newest ledger.
    validity
        What speaks against the comparison now.
    alarms
        Those that are not normal, the gravest first.
    alerts
        The same in plain words, each with what follows from it.
    rows
        What to show of each sensor, of two as of several.
    trends
        The trend of each tested sensor; the first one is `trend`.
    runs
        The runs that were judged, the newest first.
    tests
        The tests that the norm requires, by all these runs.
    nodes
        By name.
    mode
        Mode of an AHRS, in words; None if there is none.
    graph_age_s
        Time since anything came from the graph, seconds; None before the first message.
    judged
        The node that judges is heard.
    sensors
        With several sensors: all of them; then there are neither TS and RS nor their difference.

    """

    ts: SensorView = SensorView()
    rs: SensorView = SensorView()
    difference_deg: float | None = None
    last_difference_deg: float | None = None
    difference_age_s: float | None = None
    difference_stale: bool = True
    turn_deg_min: float | None = None
    paired_share: float | None = None
    paired: int | None = None
    rejected: int | None = None
    lamp: LampView = LampView()
    validity: ValidityView = ValidityView('not known: nothing is heard', Tone.DOUBT)
    window: WindowView = WindowView()
    run: RunView = RunView()
    trend: TrendView = TrendView()
    alarms: tuple[AlarmView, ...] = ()
    alerts: tuple[AlertView, ...] = ()
    rows: tuple[SensorRow, ...] = ()
    trends: tuple[TrendView, ...] = ()
    runs: tuple[JudgedRunView, ...] = ()
    tests: tuple[JudgedTestView, ...] = ()
    nodes: tuple[NodeView, ...] = ()
    mode: str | None = None
    bag: BagView = BagView()
    graph_age_s: float | None = None
    judged: bool = False
    sensors: SensorsView | None = None


@dataclass(slots=True)
class _LastMessage:
    """The last message of one kind: its statuses by name, stamp, and time of receipt."""

    statuses: tuple[Status, ...] = ()
    stamp_ns: int = 0
    came_s: float | None = None

    def values(self, name: str) -> Mapping[str, str]:
        """Return the values of a status; none if it is absent."""
        return next((status.values for status in self.statuses if status.name == name), {})


@dataclass(slots=True)
class _Node:
    """The parts of one node since its start, as last told."""

    owner: str
    came_s: float
    parts: dict[str, Status] = field(default_factory=dict)


class Bridge:
    """
    Takes decoded messages of a graph and says what to show of them.

    Parameters
    ----------
    settings
        Of the analysis.
    limits_deg
        Limit of a single difference of each tested sensor, degrees; drawn about the centre of its
        trend.
    stale_s
        Age after which a figure is stale, seconds; a slow sensor has longer.
    namespace
        Namespace of the graph; nodes of others on /diagnostics are left out.

    Notes
    -----
    Every method that takes a message is given the time of a steady clock, seconds. Memory does
    not grow, whatever comes.

    """

    def __init__(self, settings: Settings, *, limits_deg: Mapping[str, float] | None = None,
                 stale_s: float = 3.0, namespace: str = '/') -> None:
        self._settings, self._stale_s = settings, stale_s
        self._owners = f'{namespace.rstrip("/")}/'
        self._streams = {'ts': StreamWatch(stale_s), 'rs': StreamWatch(stale_s)}
        self._limits_deg = limits_deg or {}
        self._differences = {
            tested.name: DifferenceWatch(settings_of_pair(settings, tested, reference))
            for tested, reference in pair_with_reference(settings)}
        self._first_s: float | None = None
        self._data_time: tuple[int, float] | None = None
        self._ledger: LedgerMessage | None = None
        self._rolling, self._verdict = _LastMessage(), _LastMessage()
        self._runs = {tested: _LastMessage() for tested in self._differences}
        self._alarms: dict[str, Status] = {}
        self._nodes: dict[str, _Node] = {}
        self._heard_s: float | None = None
        # Begin and end of the stretches without a comparison, stamps; one may still be going on.
        self._doubtful: deque[tuple[int, int]] = deque(maxlen=_MOST_STRETCHES)
        self._in_doubt = False
        sensors = list_sensors(settings)
        several = settings.sensors is not None
        self._panel = SensorsPanel(sensors, stale_s) if several else None
        self._places = {'', *(sensor.name for sensor in sensors)} if several else {''}
        self._titles = {sensor.name: sensor.name for sensor in sensors} if several else {
            'ts': 'Tested sensor', 'rs': 'Reference'}
        self._alert_list = AlertList(
            self._titles, next((sensor.name for sensor in sensors if sensor.is_reference), ''))

    def take_sensors(self, topic: str, stamp_ns: int, statuses: Sequence[Status],
                     now_s: float) -> None:
        """Take `sensors/figures`, `sensors/vote` or `sensors/verdict`, without the first word."""
        self._heard_s = now_s
        if self._panel is None:
            return
        if topic == 'figures':
            self._panel.take_figures(statuses, now_s)
            self._data_time = stamp_ns, now_s
        elif topic == 'vote':
            self._panel.take_vote(statuses)
        else:
            self._panel.take_verdict(stamp_ns, statuses)

    def take_headings(self, stream: str, headings: Headings, received_ns: int,
                      now_s: float) -> None:
        """Take readings of 'ts' or 'rs'; the last one came at this time of day, UTC ns."""
        if len(headings):
            self._heard_s = now_s
            self._data_time = int(headings.stamp_ns[-1]), now_s
            if self._first_s is None:
                self._first_s = now_s
            self._streams[stream].take(headings, received_ns, now_s)

    def take_pairs(self, pairs: Pairs, now_s: float, tested: str = 'ts') -> None:
        """Take pairs of a tested sensor with the reference, in the order of their stamps."""
        if len(pairs):
            self._heard_s = now_s
            self._differences[tested].take(pairs, now_s)

    def take_rolling(self, stamp_ns: int, statuses: Sequence[Status], now_s: float) -> None:
        """Take `compliance/rolling`."""
        self._rolling = self._tell(stamp_ns, statuses, now_s)

    def take_run(self, stamp_ns: int, statuses: Sequence[Status], now_s: float,
                 tested: str = 'ts') -> None:
        """Take `compliance/run` of a tested sensor."""
        self._runs[tested] = self._tell(stamp_ns, statuses, now_s)

    def take_verdict(self, stamp_ns: int, statuses: Sequence[Status], now_s: float) -> None:
        """Take `compliance/verdict`."""
        self._verdict = self._tell(stamp_ns, statuses, now_s)

    def take_alarms(self, statuses: Sequence[Status], now_s: float, *,
                    in_doubt: bool = False) -> None:
        """
        Take `compliance/alarms`, which holds all alarms of one node.

        An alarm with another owner than its node is left out. If the message may be a copy, as
        while somebody else publishes the topic (`in_doubt`), no alarm ends.
        """
        self._heard_s = now_s
        statuses = [status for status in statuses if not status.owner or status.owner.partition(
            ' ')[0] == f'{self._owners}{status.name.partition(": ")[0]}']
        # A node that was started again may not know the nodes that its predecessor missed.
        nodes = set() if in_doubt else {status.name.partition(': ')[0] for status in statuses}
        self._alarms = {name: status for name, status in self._alarms.items()
                        if name.partition(': ')[0] not in nodes}
        for status in statuses:
            if (status.values.get('state', 'normal') != 'normal'
                    and len(self._alarms) < _MOST_ALARMS):
                self._alarms[status.name] = status

    def take_ledger(self, ledger: LedgerMessage, now_s: float) -> None:
        """Take `pairs/ledger`."""
        self._heard_s, self._ledger = now_s, ledger

    def take_health(self, statuses: Sequence[Status], now_s: float) -> None:
        """Take a message of /diagnostics; that of another graph or package is left out."""
        for status in statuses:
            full_name, colon, part = status.name.partition(': ')
            owner, name = f'/{full_name}', f'/{full_name}'.removeprefix(self._owners)
            if not colon or status.owner.partition(' ')[0] != owner or name == owner or (
                    name.rpartition('/')[0] not in self._places):
                continue
            if name not in self._nodes and len(self._nodes) >= _MOST_NODES:
                continue
            node = self._nodes.get(name)
            if node is None or node.owner != status.owner:
                # The node was started again: nothing of the former node holds.
                node = self._nodes[name] = _Node(status.owner, now_s)
            node.came_s = self._heard_s = now_s
            if part in node.parts or len(node.parts) < _MOST_PARTS:
                node.parts[part] = status

    def _tell(self, stamp_ns: int, statuses: Sequence[Status], now_s: float) -> _LastMessage:
        self._heard_s = now_s
        return _LastMessage(tuple(statuses), stamp_ns, now_s)

    def view(self, now_s: float) -> BridgeView:
        """Return what to show at a time of the steady clock, seconds."""
        self._forget(now_s)
        alarms = self._view_alarms()
        alerts = self._alert_list.list_alerts(alarms, self._now_ns(now_s))
        judged = not self._is_silent('compliance', now_s)
        view = BridgeView(
            alarms=alarms, alerts=alerts, judged=judged,
            nodes=tuple(self._view_node(name, now_s) for name in sorted(self._nodes)),
            mode=self._view_mode(now_s), bag=self._view_bag(now_s),
            graph_age_s=None if self._heard_s is None else now_s - self._heard_s)
        self._follow_doubt(alerts, now_s)
        whole = self._view_pair(view, now_s) if self._panel is None else self._view_several(
            view, self._panel, now_s)
        if whole.lamp.tone is Tone.GOOD and (whole.validity.tone is not Tone.NONE or not judged):
            # It is never good while something speaks against the comparison.
            return replace(whole, lamp=replace(whole.lamp, tone=Tone.DOUBT))
        return whole

    def _now_ns(self, now_s: float) -> int | None:
        """Return the present in the time of the data; None before any came."""
        if self._data_time is None:
            return None
        stamp_ns, came_s = self._data_time
        return stamp_ns + round((now_s - came_s) * 1e9)

    def _follow_doubt(self, alerts: Sequence[AlertView], now_s: float) -> None:
        """Keep the stretches in which an alert makes the comparison meaningless."""
        now_ns = self._now_ns(now_s)
        grave = any(alert.active and alert.priority != 'caution' for alert in alerts)
        if grave and now_ns is not None:
            begin_ns = self._doubtful.pop()[0] if self._in_doubt else now_ns
            self._doubtful.append((begin_ns, now_ns))
        self._in_doubt = grave and now_ns is not None

    def _view_pair(self, view: BridgeView, now_s: float) -> BridgeView:
        """Return a view with what there is of two sensors."""
        ts, rs = (self._streams[name].view(now_s) for name in ('ts', 'rs'))
        watch = self._differences['ts']
        stale = self._is_stale(watch, now_s, (ts, rs))
        window = self._view_window(now_s)
        validity = self._view_validity(view, window, stale, now_s)
        run = self._view_run(now_s, validity)
        ledger = None if self._ledger is None else self._ledger.ledger
        pairing = self._part('synchronizer', 'pairing')
        silent = pairing is None or self._is_silent('synchronizer', now_s)
        trend = self._view_trend('ts', validity, stale, now_s)
        x_deg = None if stale else watch.x_deg
        return replace(
            view, ts=ts, rs=rs, difference_deg=x_deg,
            last_difference_deg=watch.x_deg, difference_age_s=watch.age_s(now_s),
            difference_stale=stale,
            turn_deg_min=ts.turn_deg_min if rs.turn_deg_min is None else rs.turn_deg_min,
            paired_share=None if silent or pairing is None else real(
                pairing.values.get('paired_share')),
            paired=None if ledger is None else ledger.paired,
            rejected=None if ledger is None else ledger.rejected,
            lamp=light_lamp(self._verdict.statuses, self._verdict.stamp_ns, run.next_look_ns,
                            run.ends_ns),
            runs=list_runs(self._verdict.statuses), tests=list_tests(self._verdict.statuses),
            validity=validity, window=window, run=run,
            trend=trend, trends=(trend,), rows=tuple(
                SensorRow(name, name == 'rs', now, title=self._titles[name],
                          difference_deg=x_deg if name == 'ts' else None,
                          state=self._state_of(name, view))
                for name, now in (('ts', ts), ('rs', rs))))

    def _view_several(self, view: BridgeView, panel: SensorsPanel, now_s: float) -> BridgeView:
        """Return a view with what there is of several sensors."""
        sensors = panel.view(now_s)
        grave = [alert.words for alert in view.alerts if alert.active
                 and alert.priority != 'caution']
        if grave:
            validity = ValidityView(f'not all sensors are sound now: {"; ".join(grave)}', Tone.BAD)
        elif not view.judged:
            validity = ValidityView('not known: the compliance node is not heard', Tone.DOUBT)
        else:
            validity = ValidityView('nothing speaks against a sensor now', Tone.NONE)
        readings = {row.name: row.now for row in sensors.rows}
        stale = {name: self._is_stale(watch, now_s, (readings[name],))
                 for name, watch in self._differences.items()}
        return replace(
            view, lamp=panel.lamp, validity=validity, sensors=sensors,
            run=self._view_run(now_s, validity), rows=tuple(replace(
                row, title=row.name, state=self._state_of(row.name, view),
                difference_deg=None if stale.get(row.name, True) else
                self._differences[row.name].x_deg) for row in sensors.rows),
            trends=tuple(self._view_trend(name, validity, stale[name], now_s)
                         for name in self._differences))

    @staticmethod
    def _state_of(sensor: str, view: BridgeView) -> str:
        """Return what is wrong with a sensor, in a word; '' if nothing is."""
        alert = state_of(sensor, view.alerts)
        return '' if alert is None else alert.state

    def _is_stale(self, watch: DifferenceWatch, now_s: float,
                  sensors: Sequence[SensorView]) -> bool:
        """Tell whether the newest difference is old; a pair waits for readings on both sides."""
        slow_s = max(4.0 / sensor.rate_hz if sensor.rate_hz else 0.0 for sensor in sensors)
        age_s = watch.age_s(now_s)
        return age_s is None or age_s > max(self._stale_s, slow_s)

    def _forget(self, now_s: float) -> None:
        """Drop the nodes that ended long ago, with their alarms: nobody is left to clear them."""
        for name in [name for name, node in self._nodes.items()
                     if now_s - node.came_s > _FORGET_S]:
            del self._nodes[name]
            self._alarms = {alarm: status for alarm, status in self._alarms.items()
                            if alarm.partition(': ')[0] != name}

    def _part(self, node: str, part: str) -> Status | None:
        return self._nodes[node].parts.get(part) if node in self._nodes else None

    def _is_silent(self, node: str, now_s: float) -> bool:
        return node not in self._nodes or now_s - self._nodes[node].came_s > self._stale_s

    def _age_of(self, message: _LastMessage, now_s: float) -> tuple[float | None, bool]:
        if message.came_s is None:
            return None, True
        age_s = now_s - message.came_s
        return age_s, age_s > self._stale_s

    def _view_window(self, now_s: float) -> WindowView:
        values = self._rolling.values('rolling')
        age_s, stale = self._age_of(self._rolling, now_s)
        limit_deg2 = real(values.get('limit_deg2'))
        return WindowView(
            n=integer(values.get('n')) or 0, mean_deg=real(values.get('mean_deg')),
            std_deg=real(values.get('std_deg')), age_s=age_s, stale=stale,
            limit_deg=None if limit_deg2 is None else math.sqrt(max(0.0, limit_deg2)),
            nu=real(values.get('nu')), judges_mean=self._settings.variant == 'A')

    def _view_run(self, now_s: float, validity: ValidityView) -> RunView:
        # Runs of several sensors have the same cuts; the one that lacks most decides last.
        message = max(self._runs.values(), default=_LastMessage(), key=lambda run: real(
            run.values('run').get('needed_s')) or 0.0)
        values = message.values('run')
        age_s, stale = self._age_of(message, now_s)
        if age_s is None:
            return RunView()
        number, n = integer(values.get('run')) or 0, integer(values.get('n')) or 0
        marked = values.get('marked') != 'false'
        if not number:
            return RunView(lacking='no run is in progress', age_s=age_s, stale=stale,
                           marked=marked)
        needed_s = real(values.get('needed_s'))
        std_deg, limit_deg2 = real(values.get('std_deg')), real(values.get('limit_deg2'))
        beyond = std_deg is not None and limit_deg2 is not None and std_deg ** 2 > limit_deg2
        return RunView(
            number=number, n=n, span_s=real(values.get('span_s')), needed_s=needed_s,
            marked=marked,
            next_look_ns=integer(values.get('next_look_ns')),
            ends_ns=integer(values.get('ends_ns')), start_ns=integer(values.get('start_ns')),
            lacking='waits until the alert is over' if validity.tone is Tone.BAD else
            lacking_words(n, needed_s, beyond), age_s=age_s, stale=stale)

    def _view_validity(self, view: BridgeView, window: WindowView, stale: bool,
                       now_s: float) -> ValidityView:
        active = [alert for alert in view.alerts if alert.active]
        grave = [alert.words for alert in active if alert.priority != 'caution']
        if grave:
            return ValidityView(f'no comparison now: {"; ".join(grave)}', Tone.BAD)
        if not view.judged:
            return ValidityView('not known: the compliance node is not heard', Tone.DOUBT)
        if self._differences['ts'].came_s is None and not self._verdict.statuses:
            return ValidityView(self._describe_start(now_s), Tone.NONE)
        if stale:
            return ValidityView('no comparison now: no pairs come', Tone.BAD)
        if active:
            words = '; '.join(alert.words for alert in active)
            return ValidityView(f'the comparison goes on, with trouble: {words}', Tone.DOUBT)
        if window.std_deg is not None and window.limit_deg and not window.stale and (
                window.std_deg > window.limit_deg):
            return ValidityView('the scatter of the window is '
                                f'{window.std_deg / window.limit_deg:.2g} times the norm',
                                Tone.DOUBT)
        return ValidityView('nothing speaks against the comparison now', Tone.NONE)

    def _describe_start(self, now_s: float) -> str:
        """Return what a comparison that has no pair yet waits for; such a start is in order."""
        rule = self._settings.pairing
        if rule.method != 'auto':
            return 'no comparison yet: no pair has come'
        if self._first_s is None:
            return f'no comparison yet: the first pairs come after {rule.auto_s:g} s of readings'
        left_s = rule.auto_s - (now_s - self._first_s)
        return ('choosing the pairing: a moment more' if left_s < 1.0 else
                f'choosing the pairing: {left_s:.0f} s more')

    def _view_alarms(self) -> tuple[AlarmView, ...]:
        alarms = [AlarmView(status.name, status.values.get('priority', ''), status.values['state'],
                            shorten(status.message, _LONGEST),
                            integer(status.values.get('raised_ns')), status.values)
                  for status in self._alarms.values()]
        return tuple(sorted(alarms, key=lambda alarm: (
            alarm.acknowledged, not alarm.active, alarm.priority == 'caution', alarm.name)))

    def _view_node(self, name: str, now_s: float) -> NodeView:
        node = self._nodes[name]
        # The list of alerts has the alarms.
        worst = max((status for part, status in node.parts.items() if part != 'alarms'),
                    key=lambda status: status.level, default=None)
        words = 'running' if worst is None or worst.level == OK else \
            f'{worst.name.partition(": ")[2]}: {worst.message}'
        level = OK if worst is None else max(OK, min(worst.level, ERROR))
        return NodeView(name, level, shorten(words, _LONGEST), now_s - node.came_s,
                        self._is_silent(name, now_s))

    def _view_mode(self, now_s: float) -> str | None:
        """Return the mode of the first AHRS that tells one."""
        for name, node in self._nodes.items():
            for part, status in node.parts.items():
                if 'mode' in status.values and 'validity' in status.values:
                    silent = ', not heard' if self._is_silent(name, now_s) else ''
                    return f'{part.upper()}: {shorten(status.message, _LONGEST)}{silent}'
        return None

    def _view_bag(self, now_s: float) -> BagView:
        part = self._part('recorder', 'bag')
        if part is None:
            return BagView()
        silent = self._is_silent('recorder', now_s)
        return BagView(words=shorten(part.message, _LONGEST),
                       level=max(part.level, WARN) if silent else part.level,
                       free_bytes=integer(part.values.get('free_bytes')),
                       age_s=now_s - self._nodes['recorder'].came_s, stale=silent)

    def _view_trend(self, tested: str, validity: ValidityView, stale: bool,
                    now_s: float) -> TrendView:
        watch = self._differences[tested]
        columns = watch.columns()
        return TrendView(
            columns=columns, newest_ns=watch.stamp_ns, center_deg=watch.follow_center(
                columns, validity.tone is Tone.NONE, now_s),
            limit_deg=self._limits_deg.get(tested), age_s=watch.age_s(now_s), stale=stale,
            sensor=tested,
            longer=watch.longer_columns(now_s), doubtful=() if watch.stamp_ns is None else tuple(
                ((watch.stamp_ns - begin_ns) / 1e9, (watch.stamp_ns - end_ns) / 1e9)
                for begin_ns, end_ns in self._doubtful))
