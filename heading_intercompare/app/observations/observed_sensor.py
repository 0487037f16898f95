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

"""The judging of one sensor by a table of observations."""

from __future__ import annotations

from dataclasses import dataclass

from heading_intercompare.app.logs.log_import import import_log, options_for
from heading_intercompare.app.sources.csv_source import has_pairs
from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.bags.csv.pairs_csv import read_pairs_csv
from heading_intercompare.core.observations.corrections import Corrections, find_corrections
from heading_intercompare.core.observations.systematic_error import (
    judge_corrections,
    SystematicError,
)
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.registry import has_one_sensor, has_streams, open_recording
from heading_intercompare.readers.stream_recording import ReaderError, StreamOptions

from .observation_table import ObservationTable, read_observation_table
from .targets import Target


@dataclass(frozen=True, slots=True)
class Uncertainties:
    """
    What is stated of a set of observations; a column of the table replaces its default.

    Attributes
    ----------
    common_u_deg
        Standard uncertainty of the error that all share, degrees; None if the table says it.
    u_deg, time_u_s
        Standard uncertainties of one observation and of its time.
    clock_u_s
        Standard uncertainty of the offset between the clocks of observer and log, seconds.
    ts_step_deg
        Step in which the TS reports, degrees; None to find it.

    """

    common_u_deg: float | None = None
    u_deg: float = 0.0
    time_u_s: float = 1.0
    clock_u_s: float = 1.0
    ts_step_deg: float | None = None


@dataclass(frozen=True, slots=True)
class Observed:
    """
    The observations, their corrections and what they say.

    Attributes
    ----------
    table_sha256
        Hash of the table.
    recording
        Path of the readings of the TS; None if the observers noted all of them.
    recording_sha256
        Hash of a recording that is one file.

    """

    table: ObservationTable
    table_sha256: str
    recording: str | None
    recording_sha256: str | None
    corrections: Corrections
    error: SystematicError


def observe(recording: str | None, table: str, settings: Settings, *,
            driver: DriverSettings | None = None, target: Target | None = None,
            stated: Uncertainties | None = None,
            position: tuple[float, ...] | None = None) -> Observed:
    """
    Judge the systematic error of a sensor by observations of the true heading.

    Parameters
    ----------
    recording
        Readings of the TS: a bag, a log, or a csv of pairs. None if the table has them.
    table
        The observations; see `read_observation_table`.
    settings
        Norms, risks, topic of the TS, installation offset, longest gap.
    driver
        How to read a log.
    target
        Gives the true bearing of rows without one.
    stated
        What is known of the observations; by default what the table says.
    position
        Latitude and longitude of rows without their own, degrees.

    Returns
    -------
    Observed

    Raises
    ------
    OSError
        If a file cannot be read.
    ValueError
        If a file is wrong, the shared uncertainty is not stated, or stated twice.
    ModuleNotFoundError
        If a library for the sun is not installed.

    """
    stated = Uncertainties() if stated is None else stated
    rows = read_observation_table(table, target, u_deg=stated.u_deg, time_u_s=stated.time_u_s,
                                  position=position)
    common = stated.common_u_deg if rows.common_u_deg is None else rows.common_u_deg
    if common is None:
        raise ReaderError(
            table, 'nothing says how far all observations may be wrong together (survey, quay '
            'bearing, instrument): give --common-u-deg, or a column common_u_deg; 0 if they share '
            'no error')
    if stated.common_u_deg is not None and rows.common_u_deg is not None:
        raise ReaderError(table, 'has a column common_u_deg, and --common-u-deg is given: leave '
                          'out one of them')
    ts, digest = (None, None) if recording is None else _read_ts(
        recording, settings, DriverSettings() if driver is None else driver)
    step = rows.ts_step_deg if stated.ts_step_deg is None else stated.ts_step_deg
    corrections = find_corrections(
        rows.observations, ts, max_gap_s=settings.pairing.longest_gap_s,
        latency_s=settings.alignment.skew_s, offset_deg=settings.installation_offset_deg,
        step_deg=step)
    error = judge_corrections(
        corrections, settings, clock_u_s=stated.clock_u_s,
        common_u_deg=(common ** 2 + rows.target_u_deg ** 2) ** 0.5)
    return Observed(rows, hash_files([table]), recording, digest, corrections, error)


def _read_ts(path: str, settings: Settings,
             driver: DriverSettings) -> tuple[Headings, str | None]:
    """Return the readings of the TS in a recording of any kind, and the hash of a log."""
    if has_one_sensor(path) or has_streams(path, options_for(driver)):
        log = import_log(path, driver, role='ts', unit=settings.ts_unit)
        return log.headings, log.sha256
    if has_pairs(path):
        pairs = list(read_pairs_csv(path))
        return (Headings.concatenate(Headings.of(p.stamp_ns, p.ts_deg) for p in pairs),
                hash_files([path]))
    topic = settings.ts_topic
    recording = open_recording(path, settings.bag_namespace,
                               StreamOptions(driver, (topic,), settings.unit_of))
    chunks = recording.headings({topic: settings.ts_convention})
    return Headings.concatenate(chunk[topic] for chunk in chunks), None
