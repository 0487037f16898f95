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

"""The headings of an RS that is two antennas, from the logs of their receivers."""

from __future__ import annotations

from dataclasses import replace
import os
from typing import Callable, Sequence

from heading_intercompare.app.sources.file_hash import hash_files
from heading_intercompare.core.motion.antennas import BaselineHeadings, find_baseline_headings
from heading_intercompare.core.settings import Antennas
from heading_intercompare.drivers.log_lines.log_files import LogFiles
from heading_intercompare.drivers.motion.motion_log import read_log_motion
from heading_intercompare.drivers.settings import DriverError, DriverSettings

from .log_import import ImportedLog


def import_antennas(paths: Sequence[str], driver: DriverSettings, rule: Antennas,
                    progress: Callable[[str], None] = lambda text: None) -> ImportedLog:
    """
    Return the headings of the baseline between two antennas as if from one log.

    Parameters
    ----------
    paths : sequence of two str
        Logs of the fore and of the aft antenna.
    driver
        How their lines are stamped.
    rule
        Length and mounting of the baseline.
    progress
        Called with the progress in words.

    Raises
    ------
    OSError
        If a log cannot be read.
    DriverError
        If a log has no position, or no two positions give a heading.

    """
    motions = [read_log_motion(path, driver, progress) for path in paths]
    for path, motion in zip(paths, motions):
        if 'fix' not in motion.rows:
            lacking = ', '.join(f'{n} {why}' for why, n in motion.not_taken.items())
            raise DriverError(f'{path}: has no position: no GNS, GGA, RMC or GLL with a stamp'
                              + (f' (not taken: {lacking})' if lacking else ''))
    baseline = find_baseline_headings(motions[0].rows['fix'], motions[1].rows['fix'], rule)
    name = ' and '.join(paths)
    if not len(baseline.headings):
        why = ', '.join(f'{n} {reason}' for reason, n in baseline.rejected.items())
        raise DriverError(f'{name}: no heading from the two antennas ({why}): are the times and '
                          'antennas.baseline_m right?')
    files = [file for path in paths for file in LogFiles(path).paths]
    sentences = ' - '.join(motion.sentences['fix'] for motion in motions)
    return ImportedLog(path=name, headings=baseline.headings, sha256=hash_files(files),
                       size=sum(os.path.getsize(file) for file in files), sentence=sentences,
                       not_taken=baseline.rejected, driver=replace(driver), files=len(files),
                       remarks=[describe_baseline(baseline)])


def describe_baseline(baseline: BaselineHeadings) -> str:
    """Return length, scatter and uncertainty of a baseline, in words."""
    words = f'baseline of {baseline.length_m or 0.0:.2f} m'
    if baseline.scatter_m is not None:
        words += f', which scatters by {baseline.scatter_m:.3f} m'
    if baseline.sigma_deg is not None:
        words += f': standard uncertainty of a heading {baseline.sigma_deg:.2g} deg'
    return words
