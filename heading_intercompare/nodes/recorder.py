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

"""The node `recorder`: headings, pairs, verdicts and reports to a bag."""

from __future__ import annotations

import math
from pathlib import Path
import time
from typing import Any, Mapping, Sequence

from heading_intercompare.bags.recording import recorder_losses
from heading_intercompare.bags.recording.cut_bag import LastMessages, read_last
from heading_intercompare.bags.recording.part_states import PartStates, STATES
from heading_intercompare.bags.recording.resilient_recording import Recording
from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import (
    ACTION_TOPIC,
    describe_origin,
    NOTE_TOPIC,
    Notes,
    RECORD,
    REPORT_TOPIC,
    SENSORS_REPORT_TOPIC,
)
from heading_intercompare.bags.rosbag2.publisher_starts import PublisherRecords
from heading_intercompare.bags.rosbag2.trial_parts import find_place, name_first
from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.alarms.alarm import Priority
from heading_intercompare.core.alarms.graph_watch import NOT_RECORDED
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.statistics.recent_count import RecentCount
from heading_intercompare.nodes.alarms.alarm_panel import AlarmPanel
from heading_intercompare.nodes.alarms.graph_alarms import GraphAlarms
from heading_intercompare.nodes.interface.parameters import declare
from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.spinning.clocks import every
from heading_intercompare.nodes.taking.judged_headings import JudgedHeadings
from heading_intercompare.nodes.taking.reception import Message
from heading_intercompare.nodes.taking.recorded_topics import (
    count_messages,
    make_intakes,
    report_files,
    text_of,
)

from .settings import HeadingTypes, RecorderNode, Taking

# Nobody waits for what is recorded, and its subscriptions hold more than a second at 1 kHz.
_QUIET_S, _DRAIN_S = 0.3, 0.4
# A full disk may be written for a moment now and then.
_FAULT_S = 10.0


class Recorder(GraphNode):
    """Record headings, pairs, ledger, marks, verdicts and reports, at most a second late."""

    done = ended = False

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('recorder', **kwargs)
        self._settings, taking, types, bag_settings, self._own = declare(
            self, Settings, Taking, HeadingTypes, BagSettings, RecorderNode)
        self.health = Health(self, priority=Priority.CAUTION)
        self.path, self._before = self._own.output or name_first(), self._own.continues
        if self._own.go_on:
            self.path, self._before = find_place(self.path)
        file = self._own.parameter_file and Path(self._own.parameter_file)
        copy = file and (file.name, 'application/yaml', file.read_bytes())
        self._states = PartStates(self._own.diagnostics_period_s)
        # What pairs and judges dies as one; only another process can miss it.
        self.alarms = GraphAlarms(self, self.health, AlarmPanel(self, self.health, ()),
                                  keepers_only=True)
        self._topics = make_intakes(self, self._settings, taking, types, self.health,
                                    self._states)
        self._bag = Recording(self.path, bag_settings)
        self.state_sources({})
        if copy:
            self._bag.attachment(*copy)
        self._awaited = [recorded.intake.full_name for recorded in self._topics.values()
                         if recorded.expected and not recorded.is_heading]
        self._judged = JudgedHeadings(self._topics, self._go_on())
        self._starts = PublisherRecords(self._bag.metadata)
        self._faults = RecentCount(_FAULT_S)
        self._notes = Notes(self._bag.metadata)
        self._notes.add(self._own.note or '', time.time_ns())
        self._state, self._report, self._quiet_s, self._end_s = '', '', 0.0, math.inf
        self.health.add_refresher(self._note)
        every(self, max(taking.drain_period_s, _DRAIN_S), self._drain)

    def _go_on(self) -> dict[str, str]:
        """Go on after the bag of a recorder that was cut off; return its last publishers."""
        if self._before is None:
            return {}
        try:
            last = read_last(BagReader(Path(self.path).with_name(self._before)))
        except (OSError, ValueError) as error:
            self.get_logger().warning(f'what publishers still hold is not recorded: {error}')
            return {}
        for recorded in self._topics.values():
            if recorded.intake.counted:
                recorded.intake.go_on_after(last.get(recorded.intake.full_name, LastMessages()))
        return {topic: last[name].publisher for topic, recorded in self._topics.items()
                if (name := recorded.intake.full_name) in last}

    @property
    def written(self) -> int:
        """Return the number of messages handed to the bag."""
        return self._bag.written

    def state_sources(self, sources: Mapping[str, Mapping[str, Any]]) -> None:
        """Record where the headings come from: the settings of each source, by node name."""
        origin = describe_origin(self._settings.to_mapping(), sources, self._before,
                                 self.get_namespace())
        self._bag.metadata(RECORD, origin)

    def _drain(self) -> None:
        if self.ended:
            return
        rows: list[tuple[str, Message]] = []
        now_s = time.monotonic()
        for topic, recorded in self._topics.items():
            messages = recorded.intake.take()
            if messages:
                self._bag.add_topic(recorded.intake.full_name, recorded.intake.type_name or '',
                                    recorded.offered)
                if recorded.is_heading:
                    recorded.intake.take_losses()
                    starts = recorded.intake.take_starts()
                    self._starts.add(recorded.intake.full_name, starts)
                    self._judged.note_starts(topic, starts)
                if topic in (REPORT_TOPIC, SENSORS_REPORT_TOPIC):
                    self._report = text_of(messages[-1][0])
            for data, info in messages if topic in (NOTE_TOPIC, ACTION_TOPIC) else ():
                for note in self._notes.add(text_of(data), info['received_timestamp']):
                    self.get_logger().info(f'note: {note.text}')
            rows += [(topic, message) for message in self._judged.take(
                topic, messages, now_s, self.health.ending)]
        self._write(rows)
        self._bag.tick(now_s)
        if (state := self._bag.fault + self._bag.remark) != self._state:
            self._state = state
            self._note()
        if self._end_s < math.inf:
            self._close_if_quiet(self._end_s)

    def _write(self, rows: Sequence[tuple[str, Message]]) -> None:
        """Write messages of topics in the order of their receipt."""
        for topic, (data, info) in sorted(rows, key=lambda row: row[1][1]['received_timestamp']):
            self._bag.write(
                self._topics[topic].intake.full_name, data, info['received_timestamp'],
                info['source_timestamp'], info['publication_sequence_number'])

    def _note(self) -> None:
        bag = self._bag
        faults, chain = self._faults.take(bag.faults, time.monotonic()), bag.chain
        figures = {'chain_chunks': chain.chunks, recorder_losses.CHAIN_SHA256: chain.sha256}
        self.health.note(recorder_losses.BAG_PART, *recorder_losses.bag_state(bag, self.path),
                         alarm=NOT_RECORDED if bag.fault or faults else '', messages=bag.written,
                         waiting=bag.waiting, lost=sum(bag.lost.values()), faults=bag.faults,
                         absent=bag.absent, free_bytes=bag.free_bytes, notes_cut=self._notes.cut,
                         notes_left_out=self._notes.left_out, parts_cut=self._states.cut,
                         path=str(self.path), figures=figures if chain.chunks else {})

    def end(self) -> None:
        """Keep recording until the other nodes are gone or time is up, for the last verdict."""
        for recorded in self._topics.values():
            recorded.intake.bring_back()
        self._quiet_s, self._end_s = (time.monotonic() + s
                                      for s in (_QUIET_S, self._own.end_wait_s))

    def _close_if_quiet(self, end_s: float) -> None:
        now_s = time.monotonic()
        # The publishers of headings may never end.
        if self._judged.may_come() or any(
                self.count_publishers(name) for name in self._awaited):
            self._quiet_s = now_s + _QUIET_S
        if now_s < min(self._quiet_s, end_s):
            return
        self._write(self._judged.release())
        bag = self._bag
        bag.settle()
        for file in report_files(self._report) if self._report else ():
            bag.attachment(*file)
        losses = recorder_losses.loss_record(bag.faults, bag.absent, count_messages(
            self._topics, bag.lost, self._judged.counts))
        if words := recorder_losses.loss_words(losses):
            self.get_logger().warning(f'bag: {words}')
        bag.metadata(STATES, self._states.record())
        bag.metadata(recorder_losses.RECORDING, losses)
        bag.close()
        self._note()
        self.ended = True

    def destroy_node(self) -> None:
        """Close the bag, also of a graph that could not start, and destroy the node."""
        if not self.ended:
            self._bag.close()
        super().destroy_node()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('recorder', Recorder, args)
