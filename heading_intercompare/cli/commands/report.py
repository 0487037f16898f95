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

"""The command ``report``: the protocol of recorded runs, or of a verdict in JSON."""

from __future__ import annotations

import argparse
from pathlib import Path

from heading_intercompare.app.outputs import check_outputs, Outputs
from heading_intercompare.report import json

from . import analyze
from .log_options import LOG_OPTIONS

#: Options that need readings, which a verdict lacks.
_JUDGING = ('ts', 'rs', 'config', 'set', 'runs', 'exclude', 'csv', 'ensembles', 'jobs', 'dask',
            'baseline_m', 'baseline_angle', *LOG_OPTIONS)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('inputs', nargs='+', metavar='INPUT',
                        help='.mcap file, rosbag2 directory, .csv of pairs or .journal; two '
                        'logs, first that of the TS, then that of the RS; or one '
                        '.json written by analyze --json or a node, which is not judged again')
    parser.add_argument('-o', '--output', dest='report', metavar='F', required=True,
                        help='the protocol: F.html, or F.pdf with the extra pdf')
    analyze.add_analysis_arguments(parser)
    analyze.add_verdict_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge the inputs as `analyze` does, or read the verdict; then write the protocol."""
    verdicts = [path for path in arguments.inputs if Path(path).suffix.lower() == '.json']
    if not verdicts:
        return analyze.run(arguments)
    if len(arguments.inputs) > 1:
        raise ValueError(f'{verdicts[0]}: a verdict must be the only INPUT, '
                         f'{len(arguments.inputs)} are given')
    for option in _JUDGING:
        if value := getattr(arguments, option):
            shown = value[0] if isinstance(value, list) else value
            raise ValueError(f'--{option.replace("_", "-")} {shown}: {verdicts[0]} is a verdict, '
                             'which is not judged again; leave it out')
    analyze.check_report(arguments)
    check_outputs(Outputs(report=arguments.report, json=arguments.json,
                          runs_csv=arguments.runs_csv), arguments.inputs)
    verdict = json.read_any(verdicts[0])
    return analyze.deliver(verdict, arguments)
