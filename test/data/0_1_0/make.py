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

"""Make the frozen samples with the sources on the path."""

import os
from pathlib import Path
import sys

from heading_intercompare.cli import main
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.graph import intercompare, Source
from heading_intercompare.nodes.sensor_simulator import SensorSimulator

NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'risk.min_duration_s': 0.0}
SCENARIO = {
    'duration_s': 150.0, 'start_utc': '2026-03-01T09:00:00Z', 'seed': 7, 'seaway': 'ss3',
    'legs': '0 45 12\n75 90 12\n', 'ts.model': 'ideal', 'ts.rate_hz': 1.0,
    'ts.white_deg': 0.1, 'rs.model': 'ideal', 'rs.rate_hz': 1.0, 'rs.phase_s': 0.03,
    'rs.white_deg': 0.03, 'stamps': 'scenario', 'speed': 50.0}


def make(folder: Path) -> None:
    """Write bag, csv and verdict into a folder; they name each other without its path."""
    os.chdir(folder)
    intercompare([Source(SensorSimulator, 'sensor_simulator', SCENARIO)],
                 Settings.from_mapping(NORMS).to_mapping(), output='bag', private=True)
    given = [f'--set={name}={value}' for name, value in NORMS.items()]
    main(['analyze', 'bag', *given, '--json', 'verdict.json', '--csv', 'pairs.csv',
          '--ensembles', 'ensembles.csv', '--ensemble-s', '60'])


if __name__ == '__main__':
    make(Path(sys.argv[1]))
