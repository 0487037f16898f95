# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Settings of the nodes themselves; those of the analysis are in `core.settings`."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.core.settings import Checked, setting

__all__ = ['ComplianceNode', 'DriverNode', 'RecorderNode', 'ReplayerNode', 'Sending',
           'SimulatorNode', 'SynchronizerNode', 'Taking']


@dataclass(frozen=True, slots=True)
class Taking(Checked):
    """How a node takes messages that come at the rate of the sensors."""

    drain_period_s: float = setting(
        0.05, 'time between two looks for messages; they are taken in batches [s]', 0.001, 1.0)
    stale_s: float = setting(
        3.0, 'silence of an input after which the diagnostics warn [s]', 0.1, 3600.0)


@dataclass(frozen=True, slots=True)
class Sending(Checked):
    """How headings from a file, a bag or a simulation are published."""

    subscribers: int = setting(
        1, 'subscriptions of each topic waited for before the first message, so that none is '
        'lost; 0: none', 0, 100)
    max_rate_hz: float = setting(
        2000.0, 'most messages a second, at any speed: more would overrun subscribers [Hz]',
        1.0, 100000.0)


@dataclass(frozen=True, slots=True)
class DriverNode(Checked):
    """Settings of the node nmea_driver beside those of the driver."""

    frame_id: str | None = setting(
        None, 'frame of the messages; none: made of the topic (ts_heading)')
    origin_ns: int | None = setting(
        None, 'log time that a file is played from, UTC [ns]; drivers of two logs that are given '
        'the same one play in step; none: the first stamp of the log', 0)


@dataclass(frozen=True, slots=True)
class SimulatorNode(Checked):
    """Settings of the node sensor_simulator beside those of the scenario."""

    speed: float = setting(
        1.0, 'speed of the simulation, times real time; 0: as fast as possible', 0.0)
    stamps: str = setting(
        'now', "the trial begins 'now', or when the 'scenario' says (start_utc)",
        choices=('now', 'scenario'))


@dataclass(frozen=True, slots=True)
class SynchronizerNode(Checked):
    """Settings of the node synchronizer beside those of the analysis."""

    subscribers: int = setting(
        1, 'subscriptions of the pairs waited for before headings are taken', 0, 100)
    startup_wait_s: float = setting(
        10.0, 'longest time that this takes [s]', 0.0, 3600.0)
    end_wait_s: float = setting(
        1.0, 'at the end: how long headings are taken while their publishers go on [s]', 0.0, 5.0)


@dataclass(frozen=True, slots=True)
class ComplianceNode(Checked):
    """Settings of the node compliance beside those of the analysis."""

    report_dir: str | None = setting(
        None, 'folder in which each report is also written as verdict_<UTC>.json')
    ledger_wait_s: float = setting(
        2.0, 'at the end of a run: how long its ledger is waited for [s]', 0.0, 60.0)
    end_wait_s: float = setting(
        3.0, 'at the end: how long the last pairs and the final ledger are waited for [s]', 0.0,
        5.0)


@dataclass(frozen=True, slots=True)
class RecorderNode(Checked):
    """Settings of the node recorder beside those of bags."""

    output: str | None = setting(
        None, 'bag to write, a folder that does not exist; none: heading_<UTC> here')
    note: str | None = setting(
        None, "operator's notes kept in the bag, one a line; one that begins with a time such as "
        '2026-03-01T09:00:00Z is of that time')
    parameter_file: str | None = setting(
        None, 'file of which a copy is kept in the bag; the commands record and live, and the '
        'launch file, give the parameter file')
    end_wait_s: float = setting(
        6.0, 'at the end: how long the last verdict is waited for while nodes go on [s]', 0.0, 8.0)


@dataclass(frozen=True, slots=True)
class ReplayerNode(Checked):
    """Settings of the node replayer."""

    bag: str | None = setting(None, 'bag to replay: an .mcap file or a rosbag2 folder; required')
    rate: float = setting(
        1.0, 'speed, times that of the recording; 0: as fast as possible', 0.0)
    start_s: float = setting(0.0, 'what is left out at the start of the bag [s]', 0.0)
    duration_s: float | None = setting(None, 'length of the part replayed [s]; none: all', 0.0)
    loop: bool = setting(False, 'begin again at the end')
    clock: bool = setting(False, 'publish the time of the recording on /clock')
    start_paused: bool = setting(
        False, 'stand at the start until ~/resume or ~/toggle_paused is called')
