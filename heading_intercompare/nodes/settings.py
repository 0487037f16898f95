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

"""Settings of the nodes themselves; those of the analysis are in `core.settings`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Mapping

from heading_intercompare.core.declared_settings import Checked, setting, Used
from heading_intercompare.core.settings import Secrets, Settings
from heading_intercompare.messages.sentence_messages import TOPIC_TYPES

PUBLISHED = Used(Settings, ('ts_topic', 'rs_topic', 'sensors', 'motion'))
"""What a node that publishes headings uses of the settings of the analysis."""

REPLAYED = Used(Settings, (*PUBLISHED.names, 'bag_namespace'))
"""What a node that publishes those of a bag uses of them."""

PAIRED = Used(Settings, (
    'ts_topic', 'rs_topic', 'ts_convention', 'rs_convention', 'sensors', 'pairing',
    'alignment.skew_s', 'runs.gap_s', 'runs.every_h', 'runs.cut_at_utc', 'runs.keep'))
"""What the node that pairs headings uses of them."""

TOLD = Used(Settings, ('sensors',))
"""What the node that sends alerts uses of them: they name its alarms, no more."""

SHOWN = Used(Settings, (*PAIRED.names, 'norms', 'model', 'variant', 'installation_offset_deg',
                        'wrap_center_deg', 'window_s', 'motion'))
"""What nodes that show a graph use of them."""


@dataclass(frozen=True, slots=True)
class Taking(Checked):
    """How a node takes messages that arrive at the rate of the sensors."""

    drain_period_s: float = setting(
        0.012, 'how long messages are gathered into a batch after the first one [s]; where few '
        'come, up to 0.2 s', 0.001, 1.0)
    stale_s: float = setting(
        3.0, 'silence of an input after which the diagnostics warn [s]', 0.1, 3600.0)
    first_wait_s: float = setting(
        10.0, 'how long the diagnostics do not warn of an input that has not been heard since the '
        'start of the node [s]: its publisher may start later', 0.0, 3600.0)
    lost_shown_s: float = setting(
        600.0, 'how long the diagnostics warn of messages lost or readings rejected [s]; their '
        'totals stay', 1.0, 86400.0)


@dataclass(frozen=True, slots=True)
class HeadingTypes(Checked):
    """What is known of the headings before their publishers are seen."""

    ts_message_type: str | None = setting(
        None, 'message type of the TS headings, if it is known: they are then heard from the '
        'start of the node, for publishers that wait for nobody, such as ros2 bag play; none: the '
        'type of the publisher, once it is seen', choices=TOPIC_TYPES)
    rs_message_type: str | None = setting(
        None, 'the same for the RS headings', choices=TOPIC_TYPES)


@dataclass(frozen=True, slots=True)
class Sending(Checked):
    """How headings are published: when the first one goes out, and how fast."""

    subscribers: int = setting(
        1, 'subscriptions that each topic must have before the first message, so that none is '
        'lost; 0: do not wait', 0, 100)
    start_wait_s: float = setting(
        10.0, 'how long a live driver keeps its first readings for these subscriptions; then they '
        'go out without [s]', 0.0, 60.0)
    max_rate_hz: float = setting(
        2000.0, 'most messages per second, at any speed: more would overrun subscribers [Hz]',
        1.0, 100000.0)


@dataclass(frozen=True, slots=True)
class DriverNode(Checked):
    """Settings of the node nmea_driver in addition to those of the driver."""

    frame_id: str | None = setting(
        None, 'frame of the messages; none: made from the topic (ts_heading)')
    origin_ns: int | None = setting(
        None, 'log time at which a file starts to play, UTC [ns]; give the drivers of two logs '
        'the same one to play them in step; none: the first stamp of the log', 0)
    motion: bool = setting(
        True, 'publish what the sentences tell of the motion of the ship, unless another node '
        'does')


@dataclass(frozen=True, slots=True)
class SimulatorNode(Checked):
    """Settings of the node sensor_simulator in addition to those of the scenario."""

    speed: float = setting(
        1.0, 'speed of the simulation relative to real time; 0: as fast as possible', 0.0)
    stamps: str = setting(
        'now', "the trial begins 'now', or when the 'scenario' says (start_utc)",
        choices=('now', 'scenario'))


@dataclass(frozen=True, slots=True)
class SynchronizerNode(Checked):
    """Settings of the node synchronizer in addition to those of the analysis."""

    subscribers: int = setting(
        1, 'subscriptions that the pairs must have before headings are taken', 0, 100)
    startup_wait_s: float = setting(
        10.0, 'longest wait for the subscriptions of the pairs [s]', 0.0, 3600.0)
    end_wait_s: float = setting(
        1.0, 'at the end: how long to take headings while their publishers continue [s]', 0.0, 5.0)


@dataclass(frozen=True, slots=True)
class ComplianceNode(Checked):
    """Settings of the node compliance in addition to those of the analysis."""

    sensor: str | None = setting(
        None, 'with the setting sensors, where another process pairs: the sensor whose pairs this '
        'node judges; where the readings are paired in this process, it judges all')
    report_dir: str | None = setting(
        None, 'folder in which each report is also written as verdict_<UTC>.json; with the '
        'setting sensors in a folder with the name of the sensor, and that on all of them as '
        'sensors_<UTC>.json and .txt')
    logbook: str | None = setting(
        None, 'logbook (SQLite) that gets a row per judged run; none: no logbook')
    ship: str | None = setting(
        None, 'name of the ship or station in the logbook; with the setting sensors the name of '
        'the sensor follows')
    bag: str | None = setting(
        None, 'recording of these runs, for the logbook; the command live gives it')
    journal: str | None = setting(
        None, 'file that keeps the run in progress, from which a node that was killed goes on; '
        "none: <node>.journal in report_dir, or no file without that; '-': no file. The command "
        'live keeps it beside its bag')
    resume_within_s: float = setting(
        3600.0, 'a journal that was not written for longer than this belongs to another trial, '
        'and is set aside [s]', 0.0)
    report_every_h: float | None = setting(
        None, 'time of the stamps from one intermediate report to the next [h]; none: only on '
        'request (~/report)', 0.001, 8784.0)
    scalars_hz: float = setting(
        10.0, 'most messages per second on each topic scalar/..., for displays that plot numbers; '
        '0: no such topics [Hz]', 0.0, 1000.0)
    ledger_wait_s: float = setting(
        2.0, 'at the end of a run: how long to wait for its ledger [s]', 0.0, 60.0)
    end_wait_s: float = setting(
        5.0, 'at the end: how long to wait for the last pairs and the final ledger [s]', 0.0,
        5.0)


@dataclass(frozen=True, slots=True)
class RecorderNode(Checked):
    """Settings of the node recorder in addition to those of bags."""

    output: str | None = setting(
        None, 'bag to write, a folder that does not exist; none: heading_<UTC> here')
    go_on: bool = setting(
        False, 'if the bag is there, record NAME_2; it belongs to the same trial if the recorder '
        'of NAME was cut off; the launch file gives it')
    continues: str | None = setting(
        None, 'name of the bag of the same trial before this one, which ended in a crash; the '
        'command live gives it')
    note: str | None = setting(
        None, "operator's notes to keep in the bag, one per line; a line that begins with a time "
        'such as 2026-03-01T09:00:00Z gets that time')
    parameter_file: str | None = setting(
        None, 'file to copy into the bag; the commands record and live, and the launch file, give '
        'the parameter file')
    diagnostics_period_s: float = setting(
        10.0, 'record /diagnostics when a state changes, and once in this time; 0: never [s]',
        0.0, 3600.0)
    end_wait_s: float = setting(
        7.0, 'at the end: how long to wait for the last verdict while other nodes run [s]', 0.0,
        8.0)


@dataclass(frozen=True, slots=True)
class DashboardNode(Checked):
    """Settings of the node dashboard in addition to those of the analysis."""

    REMOVED: ClassVar[Mapping[str, Any]] = Secrets.REMOVED

    host: str = setting(
        '127.0.0.1', 'address to serve the page on; with another one than loopback, actions need '
        'a token')
    port: int = setting(8080, 'TCP port of the page; 0: any free one', 0, 65535)
    names: str | None = setting(
        None, 'names under which the page is reached, beside the addresses and the name of this '
        'computer, with commas between them: such as that of a reverse proxy. Requests that name '
        'another host are refused')
    connections_by_address: int = setting(
        64, 'most connections of one address; a page needs one, and some more while it loads. '
        'Raise it for a reverse proxy, whose address all have', 8, 512)
    token_file: str | None = setting(
        None, "file of mode 0600 with the tokens that actions need, one operator per line: 'NAME "
        "TOKEN'; none: the one token in the environment variable HEADING_INTERCOMPARE_TOKEN; "
        'without it none on loopback, otherwise one is made and printed at the start')


@dataclass(frozen=True, slots=True)
class ReplayerNode(Checked):
    """Settings of the node replayer."""

    bag: str | None = setting(None, 'bag to replay: an .mcap file or a rosbag2 folder; required')
    rate: float = setting(
        1.0, 'speed relative to the recording; 0: as fast as possible', 0.0)
    start_s: float = setting(0.0, 'time to skip at the start of the bag [s]', 0.0)
    duration_s: float | None = setting(None, 'length of the part to replay [s]; none: all', 0.0)
    loop: bool = setting(False, 'begin again at the end')
    clock: bool = setting(False, 'publish the time of the recording on /clock')
    start_paused: bool = setting(
        False, 'wait at the start until ~/resume or ~/toggle_paused is called')
