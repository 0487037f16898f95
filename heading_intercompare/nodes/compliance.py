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

"""The node `compliance`: pairs to figures, verdicts and reports."""

from __future__ import annotations

from functools import partial
import math
import time
from typing import Any, Callable, Mapping, Sequence

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.srv import AddDiagnostics
from std_msgs.msg import String
from std_srvs.srv import Trigger

from heading_intercompare.bags.rosbag2.provenance import SENSORS_REPORT_TOPIC
from heading_intercompare.core.alarms.graph_watch import estimate_judging_s
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.decision.coverage import least_duration_words
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_names import Names, TWO
from heading_intercompare.core.sensors.pair_settings import settings_of_tested
from heading_intercompare.core.sensors.sensors_verdict import SensorsVerdict
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.journal.journal_reading import Numbers
from heading_intercompare.journal.reading_batches import Batch
from heading_intercompare.messages.authors import sign_text, split_author, UNKNOWN_OPERATOR
from heading_intercompare.messages.ledger_messages import decode_ledger
from heading_intercompare.messages.status_messages import (
    decode_marks,
    encode_mark,
    encode_text,
    MARKER_TOPIC,
)
from heading_intercompare.nodes.alarms.alarm_panel import ACKNOWLEDGE_TOPIC, ALL
from heading_intercompare.nodes.alarms.graph_alarms import GraphAlarms
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.interface.places import label_tested, name_place, place_files
from heading_intercompare.nodes.judging.accounts import Account, HeardAccount, PairerAccount
from heading_intercompare.nodes.judging.heard_actions import HeardActions
from heading_intercompare.nodes.judging.heard_recorders import HeardRecorders
from heading_intercompare.nodes.judging.now_publisher import NowPublisher
from heading_intercompare.nodes.judging.operator_actions import OPERATOR_SERVICE
from heading_intercompare.nodes.judging.pair_intake import PairIntake
from heading_intercompare.nodes.judging.sensor_judgement import SensorJudgement
from heading_intercompare.nodes.judging.sensors_reporting import SensorsReporting
from heading_intercompare.nodes.judging.trial_journal import open_spool, TrialJournal
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.action_publisher import ActionPublisher
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.presence.setting_changes import SettingChanges
from heading_intercompare.nodes.presence.sole_node import SoleNode
from heading_intercompare.nodes.spinning.batches import Arrivals
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.taking.mark_intake import explain_mark, MarkIntake
from heading_intercompare.nodes.taking.motion_intake import MotionIntake
from heading_intercompare.nodes.taking.quality_intake import QualityIntake
from heading_intercompare.nodes.taking.raw_subscription import subscribe

from .interface import qos
from .settings import ComplianceNode, Taking

# How long the last messages of a synchronizer that has ended, and of a batch, may be under way.
_ALONE_S, _HOLD_OFF_S = 0.3, 0.002
_FOLLOWED = ('window_s', 'stale_s')


class Compliance(GraphNode):
    """
    Publish figures of the runs in progress, and verdict and report at the end of each.

    Parameters
    ----------
    pairs_here
        A synchronizer in this process pairs the readings of all sensors as `comparison` says,
        keeps them with `keep` and gives the pairs to `take`. Otherwise the pairs of a tested
        sensor are heard on their topic.
    **kwargs
        As for `Node`.

    Attributes
    ----------
    comparison : SensorsComparison
        All pairs of sensors.
    journal : TrialJournal
        What has come in since the last judged runs.
    actions : HeardActions
        What operators did.
    recorders : HeardRecorders
        What was recorded meanwhile.
    n_pairs : int
        How many pairs of tested sensors have come.
    while_judging
        Called now and then while a run is judged, which may take seconds.

    """

    done, n_pairs, _alone_s, _end_s = False, 0, math.inf, math.inf

    def __init__(self, pairs_here: bool = False, **kwargs: Any) -> None:
        super().__init__('compliance', **kwargs)
        whole, taking, own = declare(
            self, Settings, Taking, ComplianceNode, followed=_FOLLOWED)
        sensor = _find_sensor(whole, own.sensor, pairs_here)
        settings = settings_of_tested(whole, sensor or None)
        self._end_wait_s = own.end_wait_s
        self.health = Health(self, keeper=True)
        SettingChanges(self, self.health, _FOLLOWED)
        self.actions = HeardActions(self, self.health)
        self.recorders = HeardRecorders(self, self.health)
        self.while_judging: Callable[[], None] = lambda: None
        self.comparison = SensorsComparison(
            settings, source='live', keeper=lambda: open_spool(self.health),
            progress=lambda words: self.while_judging())
        self.get_logger().info(least_duration_words(settings.risk))
        pairs = self.comparison.pairs
        self._judges = {names: pair.compliance for names, pair in pairs.items()}
        self._makers = {names: pair.maker for names, pair in pairs.items()} if pairs_here else {}
        self.journal = TrialJournal(self, settings, self._judges, place_files(own, sensor),
                                    self.health, [*self._makers.values()] or None)
        labels = label_tested(settings) if pairs_here else {TWO: sensor}
        self._heard: HeardAccount | None = None
        accounts: dict[Names, Account] = {
            names: PairerAccount(self._makers[names], self.journal, names)
            if pairs_here else self._hear(settings, taking, label)
            for names, label in labels.items()}
        self._judgements = {names: SensorJudgement(
            self, self.health, label, self._judges[names], own, accounts[names], self.journal,
            self.actions, self.recorders)
            for names, label in labels.items()}
        self._now: NowPublisher | None = None
        if settings.sensors is not None:
            self._now = NowPublisher(self, self.health, self.comparison,
                                     settings.detectors.mean_max_deg, taking.stale_s)
            self._all = SensorsReporting(
                self, self.health, settings, own, self.comparison,
                {names[0]: judgement for names, judgement in self._judgements.items()},
                self.journal)
        alarms = [judgement.alarms for judgement in self._judgements.values()]
        self.panels = [*([self._now.panel] if self._now is not None else ()),
                       *(watch.panel for watch in alarms)]
        GraphAlarms(self, self.health, self.panels[0])
        self._beside = (
            MotionIntake(self, self.health, taking, settings.motion, (
                self.journal, self.comparison, *alarms), self.journal.kept.motion_ns),
            QualityIntake(self, self.health, taking, settings, (self.journal, self.comparison)))
        self._marks = MarkIntake(self.health, self.journal.kept.marks)
        self.sole = SoleNode(self, [
            *(f'{name_place(label)}compliance/report' for label in labels.values()),
            *([SENSORS_REPORT_TOPIC] if self._now is not None else ())], self.health)
        self._marker = self.create_publisher(DiagnosticArray, MARKER_TOPIC, qos.MARKER)
        self._acknowledged = self.create_publisher(String, ACKNOWLEDGE_TOPIC, qos.ACKNOWLEDGE)
        subscribe(self, DiagnosticArray, MARKER_TOPIC, qos.MARKER, self.health, decode_marks,
                  self._mark)
        self._action_publisher = ActionPublisher(self, self.health)
        self._commands: dict[str, Callable[[str], str]] = {
            'start': partial(self._command, 'start'), 'stop': partial(self._command, 'stop'),
            'acknowledge': self._acknowledge}
        for service, what in (('start_run', 'start'), ('stop_run', 'stop'),
                              ('acknowledge', 'acknowledge')):
            self.create_service(Trigger, f'~/{service}', partial(self._obey, what))
        self.create_service(AddDiagnostics, OPERATOR_SERVICE, self._obey_operator)
        self.create_service(Trigger, '~/report', self._report)
        every(self, 1.0, self._beat)

    def _hear(self, settings: Settings, taking: Taking, label: str) -> HeardAccount:
        """Hear the pairs and ledgers of a synchronizer in another process."""
        topic = f'{name_place(label)}pairs'
        judge, = self._judges.values()
        self._pairs = PairIntake(self, topic, self.health, taking, settings.pairing,
                                 Arrivals(self, self._drain, _HOLD_OFF_S))
        self._pairs.go_on(self.journal.kept.numbers, judge.newest_ns, judge.segment)
        self._heard = HeardAccount(self._pairs, self.journal)
        subscribe(self, DiagnosticArray, f'{topic}/ledger', qos.LEDGER, self.health,
                  decode_ledger, self._heard.book)
        return self._heard

    @property
    def verdict(self) -> Verdict | SensorsVerdict | None:
        """Return the verdict of the last report; None before the first."""
        if self._now is not None:
            return self._all.verdict
        judgement, = self._judgements.values()
        return judgement.reporting.verdict

    @property
    def newest_ns(self) -> int | None:
        """Return the stamp of the newest pair of all; None before the first."""
        stamps = [*(judge.newest_ns for judge in self._judges.values()),
                  *(maker.newest_ns for maker in self._makers.values())]
        return max((stamp_ns for stamp_ns in stamps if stamp_ns is not None), default=None)

    def _drain(self) -> None:
        """Take the pairs that were heard."""
        if self.ended or self._heard is None:
            return
        pairs = self._pairs.read()
        self._heard.look()
        self._pass_on_beside()  # What was sent before these pairs is there by now.
        names, = self._judges
        self.take({names: pairs}, self._pairs.numbers_by_name)
        if self._end_s < math.inf:
            self._finish_if_complete(self._heard)

    def _pass_on_beside(self) -> None:
        """Take motion and quality."""
        for intake in self._beside:
            intake.pass_on()

    def keep(self, batch: Batch, received_ns: Mapping[str, int]) -> None:
        """
        Keep readings, before they are paired here, and what came beside them before.

        Parameters
        ----------
        batch
            The readings.
        received_ns
            When the newest message of each sensor came, UTC ns.

        """
        self._pass_on_beside()
        self.journal.add_batch(batch, self.sole.clear)
        if self._now is not None:
            self._now.take(batch.headings, received_ns)

    def take(self, pairs: Mapping[Names, Pairs], numbers: Numbers | None = None) -> None:
        """
        Judge pairs, and publish what they say.

        Parameters
        ----------
        pairs
            By their sensors, those of all: of the readings kept last, or heard.
        numbers
            As for `TrialJournal.add`.

        """
        for names, of_sensors in pairs.items():
            self.journal.add(of_sensors, numbers, names)
            self._judges[names].update(of_sensors)
        self.journal.tick(self.sole.clear)
        for names, judgement in self._judgements.items():
            self.n_pairs += len(pairs[names])
            judgement.take(pairs[names])

    def _beat(self) -> None:
        rolling = {names: judgement.look() for names, judgement in self._judgements.items()}
        for pair in self.comparison.others.values():
            pair.compliance.take_earlier()
            pair.compliance.forget()
        if self._now is not None:
            verdict = self._all.verdict
            self._now.look(rolling, self.newest_ns, None if verdict is None else verdict.vote)
            self._all.look(self.newest_ns)
        self.health.judging_s = estimate_judging_s(sum(
            judge.n_in_run for judge in self._judges.values()))

    def _mark(self, marks: Sequence[tuple[str, int]]) -> None:
        for kind, stamp_ns in marks:
            if self._marks.take(kind, stamp_ns):
                self.journal.mark(kind, stamp_ns)
                self.comparison.mark(kind, stamp_ns)
                for judgement in self._judgements.values():
                    judgement.alarms.start_run()
        self.journal.tick(self.sole.clear)

    def _obey(self, what: str, _: Trigger.Request,
              response: Trigger.Response) -> Trigger.Response:
        response.success, response.message = True, self._commands[what](UNKNOWN_OPERATOR)
        return response

    def _obey_operator(self, request: AddDiagnostics.Request,
                       response: AddDiagnostics.Response) -> AddDiagnostics.Response:
        """Do what a text says, in the name of the operator at its end."""
        what, operator = split_author(request.load_namespace)
        response.success = what in self._commands
        response.message = self._commands[what](operator) if response.success else (
            f'{what!r:.60}: must be one of {", ".join(self._commands)}, and then [by NAME]')
        return response

    def _command(self, kind: str, operator: str) -> str:
        """Set a mark after the newest pair of all; pairs up to it belong to the run before."""
        self._drain()
        did = explain_mark(kind, next(iter(self._judges.values())).keep().cutter)
        stamp_ns = self.newest_ns or 0
        self._mark([(kind, stamp_ns)])
        self._marker.publish(encode_mark(kind, stamp_ns, operator))
        words = f'{kind} after the pair of {stamp_ns} ns: {did}'
        self._action_publisher.publish(words, operator)
        for judgement in self._judgements.values():
            judgement.reporting.look()
        return words

    def _acknowledge(self, operator: str) -> str:
        self._acknowledged.publish(encode_text(sign_text(ALL, operator)))
        n = self.health.acknowledge() + sum(panel.acknowledge() for panel in self.panels)
        words = f'{count_words(n, "alert")} acknowledged'
        if n:
            self._action_publisher.publish(words, operator)
        return words

    def _report(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        headlines = [headline for judgement in self._judgements.values()
                     if (headline := judgement.reporting.report())]
        response.success = bool(headlines)
        response.message = '; '.join(headlines) or 'no pair has come yet'
        return response

    def end(self) -> None:
        """Take the last pairs and the final ledger, then end the runs and report on them."""
        self._end_s = time.monotonic() + self._end_wait_s
        if self._heard is None:
            # The synchronizer of this process has ended, and has given all.
            self._finish(True)

    def _finish_if_complete(self, heard: HeardAccount) -> None:
        self._pairs.look()
        now_s = time.monotonic()
        # Since the first look: what has come is served before the second.
        self._alone_s = math.inf if self._pairs.publishers else min(self._alone_s, now_s)
        complete = heard.is_complete
        if complete or now_s > min(self._alone_s + _ALONE_S, self._end_s):
            self._finish(complete)

    def _finish(self, complete: bool) -> None:
        for judge in self._judges.values():
            judge.finish()
        for judgement in self._judgements.values():
            judgement.reporting.close(complete)
        if self._now is not None:
            self._all.close(self.newest_ns)
        self.journal.close()
        self.ended = True


def _find_sensor(settings: Settings, sensor: str | None, pairs_here: bool) -> str:
    """Return the tested sensor whose pairs are heard; '' if all sensors are judged."""
    if pairs_here and sensor is not None:
        raise SettingsError(f'sensor = {sensor!r}: this process judges all sensors; leave it out')
    if not pairs_here and sensor is None and settings.sensors is not None:
        raise SettingsError('sensor is required with the setting sensors: the one to judge; the '
                            'executable intercompare judges all')
    return sensor or ''


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('compliance', Compliance, args)
