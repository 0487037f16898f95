# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``analyze``: verdict on recorded runs."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
import math
from pathlib import Path
import sys
from typing import Any, Iterator, Mapping

from heading_intercompare.bags.ensembles_csv import EnsemblesCsvWriter
from heading_intercompare.bags.pairs_csv import PairsCsvWriter
from heading_intercompare.cli.campaign import capped, judge_inputs, positive
from heading_intercompare.cli.config import load_config, settings_for
from heading_intercompare.cli.inputs import read_run_table
from heading_intercompare.cli.table import verdict_text
from heading_intercompare.core.criteria import Limits
from heading_intercompare.core.intercomparison import join
from heading_intercompare.core.settings import Settings
from heading_intercompare.report import json, write, WRITERS

__all__ = ['add_arguments', 'add_settings_arguments', 'add_verdict_arguments', 'conclude', 'run']

_CHECK_CODES = {'compliant': 0, 'non_compliant': 1, 'indeterminate': 3}


def add_settings_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options with which every command takes settings."""
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')
    parser.add_argument('--set', metavar='name=value', action='append', default=[],
                        help='one setting, e.g. norms.sigma_max_deg=0.2; may be repeated')


def add_verdict_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of every command that ends with a verdict; see `conclude`."""
    parser.add_argument('--json', metavar='F', help="write the verdict as JSON; '-' for stdout")
    parser.add_argument('--check', action='store_true',
                        help='exit code 1 if non-compliant, 3 if indeterminate')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('inputs', nargs='+', metavar='INPUT',
                        help='.mcap file, rosbag2 directory or .csv of pairs')
    parser.add_argument('--ts', metavar='TOPIC', help='topic of the tested sensor')
    parser.add_argument('--rs', metavar='TOPIC', help='topic of the reference sensor')
    add_settings_arguments(parser)
    parser.add_argument('--runs', metavar='F.csv', help='table of runs: start,stop[,source]')
    parser.add_argument('--csv', metavar='F', help='write a row per pair')
    parser.add_argument('--ensembles', metavar='F', help='write a row per ensemble, with the '
                        'columns of UHDAS: dday,mean_hdg,last_hdg,mean_dh,std_dh,num,badflag; dh '
                        'is TS - RS')
    parser.add_argument('--ensemble-s', metavar='S', type=float, default=120.0,
                        help='length of an ensemble in seconds (default: 120)')
    parser.add_argument('--jobs', metavar='N', type=positive,
                        help='processes for several large INPUTs, or to read one (default: one '
                        'for each core)')
    parser.add_argument('--dask', metavar='ADDRESS', help='judge the INPUTs on the workers of a '
                        'Dask scheduler, which see the same paths: tcp://HOST:8786, or its .json '
                        'file')
    parser.add_argument('--report', metavar='F.html', help='write the protocol, with plots')
    add_verdict_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge the inputs; print and write the verdict."""
    settings = settings_for(load_config(arguments.config), arguments.set,
                            ts_topic=arguments.ts, rs_topic=arguments.rs)
    Limits.of(settings.norms, settings.model)
    table = read_run_table(arguments.runs) if arguments.runs else None
    _check_outputs(arguments)
    if arguments.report and Path(arguments.report).suffix not in WRITERS:
        raise ValueError(f'--report {arguments.report}: must end with {" or ".join(WRITERS)}')
    with ExitStack() as files:
        takers = [files.enter_context(file).write for file in _tables(arguments, settings)]
        judged = judge_inputs(arguments.inputs, settings, table, takers=takers,
                              sketched=bool(arguments.report), jobs=arguments.jobs,
                              dask=arguments.dask, quiet=arguments.quiet)
    results = [result for each in judged for result in each.results]
    verdict = join(results, settings, [each.description for each in judged]).to_dict()
    verdict = capped(verdict, judged)
    if arguments.report:
        write(verdict, arguments.report, [each.sketch for each in judged if each.sketch])
    for note in (note for each in judged for note in each.notes):
        print(f'note: {note}', file=sys.stderr)
    return conclude(verdict, arguments)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse tables of several inputs or of a cluster, and to write one file over another."""
    if arguments.dask is not None and arguments.jobs is not None:
        raise ValueError(f'--jobs {arguments.jobs}: with --dask the scheduler decides; '
                         'leave one of them out')
    taken = {Path(path).resolve(): 'an INPUT' for path in arguments.inputs}
    for option in ('csv', 'ensembles', 'report', 'json'):
        path = getattr(arguments, option)
        if path is None or path == '-':
            continue
        if option in ('csv', 'ensembles') and len(arguments.inputs) > 1:
            raise ValueError(f'--{option} {path}: takes the pairs of one INPUT, '
                             f'{len(arguments.inputs)} are given')
        if option in ('csv', 'ensembles') and arguments.dask is not None:
            raise ValueError(f'--{option} {path}: pairs stay on the workers; leave out --dask')
        other = taken.setdefault(Path(path).resolve(), f'the file of --{option}')
        if other != f'the file of --{option}':
            raise ValueError(f'--{option} {path}: that is {other}; name another file')


def _tables(arguments: argparse.Namespace,
            settings: Settings) -> Iterator[PairsCsvWriter | EnsemblesCsvWriter]:
    """Yield the open tables, each of which takes the pairs."""
    center_deg = settings.wrap_center_deg
    if arguments.csv:
        yield PairsCsvWriter(arguments.csv, wrap_center_deg=center_deg)
    if arguments.ensembles:
        limit_deg2 = Limits.of(settings.norms, settings.model).limit_deg2
        yield EnsemblesCsvWriter(
            arguments.ensembles, arguments.ensemble_s, gap_s=settings.runs.gap_s,
            std_limit_deg=math.sqrt(limit_deg2), wrap_center_deg=center_deg)


def conclude(verdict: Mapping[str, Any], arguments: argparse.Namespace) -> int:
    """
    Print the verdict, write it as JSON if asked for, and return the exit code.

    Parameters
    ----------
    verdict : mapping
        `Verdict.to_dict()`, or the JSON of a report.
    arguments : argparse.Namespace
        With `json` and `check`.

    """
    if arguments.json == '-':
        sys.stdout.write(json.render(verdict))
    else:
        print(verdict_text(verdict))
        if arguments.json:
            json.write(verdict, arguments.json)
    return _CHECK_CODES[verdict['outcome']] if arguments.check else 0
