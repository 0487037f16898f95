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

"""Four sensors of a bag against three times two of them: CPU of the whole verdict, in one run."""

from __future__ import annotations

import argparse
from pathlib import Path
import resource
import tempfile

import numpy as np

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.heading_messages import encode_imu, IMU

NAMES = ('gyro1', 'gyro2', 'ins', 'gnss')
ROWS = 'gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; ins sigma_max_deg=0.3; ' \
       'gnss sigma_max_deg=0.3'


def write(path: Path, rate_hz: float, hours: float) -> None:
    """Write a bag of four sensors, minute by minute."""
    rng, per_minute = np.random.default_rng(4), round(60 * rate_hz)
    with BagWriter(path) as writer:
        for name in NAMES:
            writer.add_topic(f'{name}/heading', IMU)
        for minute in range(round(60 * hours)):
            t_s = minute * 60.0 + np.arange(per_minute) / rate_hz
            rows = []
            for at, name in enumerate(NAMES):
                stamps = 10 ** 18 + np.rint((t_s + at * 0.2 / rate_hz) * 1e9).astype(np.int64)
                true = 90.0 + 3.0 * np.sin(t_s / 1.4) + 40.0 * np.sin(t_s / 140.0)
                readings = Headings.of(stamps, true + 0.1 * rng.standard_normal(per_minute))
                rows.append(Rows(f'{name}/heading', encode_imu(readings, name), stamps))
            writer.write_rows(rows)


def cpu_s() -> float:
    """Return the CPU time of this process and of those that it has waited for, seconds."""
    return sum(use.ru_utime + use.ru_stime for use in (
        resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def measure(path: Path) -> tuple[float, float, float]:
    """Return CPU seconds: of two sensors, of four with a reference, of four without one."""
    began = cpu_s()
    judge_bags([str(path)], Settings.of(
        ts_topic='gyro1/heading', rs_topic='gnss/heading', sigma_max_deg=0.3,
        sigma_ref_max_deg=0.3), jobs=1)
    two = cpu_s()
    judge_bags([str(path)], Settings.of(sensors=f'{ROWS} rs'), jobs=1)
    with_reference = cpu_s()
    judge_bags([str(path)], Settings.of(sensors=ROWS), jobs=1)
    return two - began, with_reference - two, cpu_s() - with_reference


def main() -> None:
    """Print a row per repetition."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--hours', type=float, default=2.0)
    parser.add_argument('--rate-hz', type=float, default=100.0)
    parser.add_argument('--repeat', type=int, default=3)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(dir='/var/tmp') as folder:
        path = Path(folder, 'bag')
        write(path, given.rate_hz, given.hours)
        print('two [s]   four [s]   of 3 x two   four, no reference [s]   of 3 x two')
        for _ in range(given.repeat):
            two, four, alone = measure(path)
            print(f'{two:7.2f} {four:10.2f} {four / (3 * two):12.2f} {alone:24.2f} '
                  f'{alone / (3 * two):12.2f}', flush=True)


if __name__ == '__main__':
    main()
