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

"""The command ``demo``: checks that the live, replayed and offline verdicts agree."""

from __future__ import annotations

import argparse
from dataclasses import replace
from functools import partial
import math
from pathlib import Path
import shutil
from typing import Callable, Iterator, Mapping

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.scenarios import read_scenario
from heading_intercompare.cli.terminal.console import say, say_lines, VERDICT_MARKS
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.sensors.sensors_verdict import (
    find_sensor_differences,
    SensorsVerdict,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.report import check_form, json
from heading_intercompare.report.sensors_report import write_protocols

from .web_option import add_web_argument, read_web

NORMS = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}
_SENSORS = {'sensors': '; '.join((
    'gyro1 topic=ts/heading sigma_max_deg=0.3', 'gyro2 sigma_max_deg=0.3',
    'ins sigma_max_deg=0.1', 'gnss topic=rs/heading sigma_max_deg=0.1 rs')),
    'risk.slowest_error_s': 60.0}
_SENSORS_S = 1800.0
_MADE = ('bag', 'live', 'replayed', 'offline.json', 'report.html',
         *(f'report-{name}.html' for name in ('gyro1', 'gyro2', 'ins')))
#: Files in a folder are only removed if this file is there too.
_MARK = '.heading_intercompare_demo'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('--out', metavar='DIR', default='demo_out',
                        help='folder for the bag and the verdicts; replaces those of an earlier '
                        'demo (default: demo_out)')
    parser.add_argument('--speed', type=float, metavar='X', default=50.0,
                        help='speed of the simulation as a multiple of real time (default: 50)')
    parser.add_argument('--duration', type=float, metavar='S',
                        help='simulated seconds (default: the whole scenario, 1200; 1800 of four '
                        'sensors)')
    parser.add_argument('--sensors', action='store_true',
                        help='four sensors, one of them beyond its norm, instead of two')
    add_web_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Get the three verdicts, print the offline one and whether they agree."""
    from heading_intercompare.nodes.graph import intercompare, Source
    from heading_intercompare.nodes.replayer import Replayer
    from heading_intercompare.nodes.sensor_simulator import SensorSimulator

    page = read_web(arguments, {})
    several = arguments.sensors
    scenario = read_scenario('four_sensors' if several else 'demo').scenario
    parameters = _SENSORS if several else NORMS
    if arguments.duration is not None or several:
        scenario = replace(scenario, duration_s=arguments.duration or _SENSORS_S)
    if not 0.0 < arguments.speed < math.inf:
        raise ValueError(f'--speed {arguments.speed}: must be greater than 0, and finite')
    out = Path(arguments.out)
    _clear(out)
    bag = str(out / 'bag')
    tell = print if not arguments.quiet else lambda *_: None

    expected = '' if several else f' of {round(scenario.duration_s * scenario.ts.rate_hz):,}'
    tell('1. live: simulator -> synchronizer -> compliance -> recorder, '
         f'{scenario.duration_s:g} s at {arguments.speed:g} times real time')
    with Progress('live', arguments.quiet) as progress:
        live = intercompare(
            [Source(SensorSimulator, 'sensor_simulator',
                    {**scenario.to_mapping(), 'speed': arguments.speed, 'stamps': 'scenario'})],
            parameters, output=bag, report_dir=str(out / 'live'), private=True, page=page,
            progress=lambda n: progress.show(f'{n:,}{expected} pairs'))
    tell(f'2. replayed: {bag} -> synchronizer -> compliance')
    with Progress('replayed', arguments.quiet) as progress:
        replayed = intercompare(
            [Source(Replayer, 'replayer', {'bag': bag, 'rate': 1.0})],
            parameters, report_dir=str(out / 'replayed'), private=True,
            progress=lambda n: progress.show(f'{n:,} pairs'))
    tell(f'3. offline: analyze {bag}\n')
    settings, report = Settings.from_mapping(parameters), out / 'report.html'
    with Progress(bag, arguments.quiet) as progress:
        judged = judge_bags([bag], settings, sketched=True, progress=progress.show)
    offline = judged.verdict
    json.write(offline, out / 'offline.json')
    say(f'VERDICT: {offline.summary()}' if isinstance(offline, Verdict) else str(offline),
        VERDICT_MARKS)
    protocol = _write_protocol(report, partial(write_protocols, offline, report,
                                               judged.sketches))
    say('')
    code = _compare({'live': live, 'replayed': replayed}, offline)
    demo = 'demo --sensors' if several else 'demo'
    say_lines([f'live page: heading-intercompare {demo} --web --speed 10; of a trial: live --web',
               f'protocol: {protocol}'])
    return code


def _write_protocol(path: Path, draw: Callable[[], object]) -> str:
    """Write the protocol and say how to open it, or why it cannot be written."""
    try:
        check_form(path)
    except ValueError as error:
        return f'left out: {error}'
    draw()
    return f'open {path.resolve().as_uri()} in a browser'


def _differences(verdict: Verdict | SensorsVerdict,
                 offline: Verdict | SensorsVerdict) -> Iterator[str]:
    if isinstance(verdict, SensorsVerdict) and isinstance(offline, SensorsVerdict):
        return find_sensor_differences(verdict, offline)
    assert isinstance(verdict, Verdict) and isinstance(offline, Verdict)
    return find_differences(verdict, offline)


def _compare(others: Mapping[str, Verdict | SensorsVerdict],
             offline: Verdict | SensorsVerdict) -> int:
    """Say whether the verdicts agree; 0 if they do."""
    differences = [f'{name} and offline differ in {difference}' for name, verdict in others.items()
                   for difference in _differences(verdict, offline)]
    if differences:
        say_lines([*differences[:20], 'live, replayed and offline verdicts DO NOT AGREE'])
        return 1
    pairs = (sum(pair.n for pair in offline.pairs) if isinstance(offline, SensorsVerdict)
             else sum(run.n_input for run in offline.runs))
    say_lines([f'live, replayed and offline verdicts agree: {pairs} pairs, every count and word, '
               'every figure to 1e-12'])
    return 0


def _clear(out: Path) -> None:
    """Make the folder, or remove what an earlier demo left in it."""
    out.mkdir(parents=True, exist_ok=True)
    foreign = [name for name in _MADE if (out / name).exists() and not (out / _MARK).exists()]
    if foreign:
        raise ValueError(f'--out {out}: {foreign[0]} exists and was not made by a demo; '
                         'remove it or name another folder')
    (out / _MARK).touch()
    for name in _MADE:
        if (out / name).is_dir():
            shutil.rmtree(out / name)
        else:
            (out / name).unlink(missing_ok=True)
