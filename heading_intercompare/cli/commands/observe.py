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

"""The command ``observe``: a sensor against observations of the true heading."""

from __future__ import annotations

import argparse
import json
import math
import sys
from typing import Any, Iterator

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.observations.observed_sensor import observe, Observed, Uncertainties
from heading_intercompare.app.observations.targets import parse_position, Target
from heading_intercompare.app.outputs import check_outputs, Outputs
from heading_intercompare.cli.terminal.console import say, tell, VERDICT_MARKS
from heading_intercompare.core.declared_settings import settings_sha256
from heading_intercompare.core.norm_tests.judged_test import JudgedTest
from heading_intercompare.core.norm_tests.observed_tests import judge_observed
from heading_intercompare.core.observations.wording import explain_outcome, explain_scatter
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.verdict.verdict_document import Software
from heading_intercompare.replaced_file import replace_file

from .analyze import add_settings_arguments, code_of
from .log_options import add_log_arguments, drivers_for

SCHEMA = 'heading_intercompare/observations/1'
_TARGETS = {'line': 2, 'mark': 1}
_MOST_NU = 1000.0


def _number(text: str) -> float:
    """Return a number of at least 0 from the command line."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f'{text!r} must be a number of at least 0')
    return value


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('input', nargs='?', metavar='INPUT', help='readings of the tested sensor: '
                        'bag, log or csv of pairs; leave it out if the table has them '
                        '(ts_heading_deg or ts_bearing_deg)')
    parser.add_argument('table', metavar='OBSERVATIONS.csv', help='a row per observation: a time '
                        'and true_heading_deg, relative_bearing_deg, ts_bearing_deg, or fore_m, '
                        'aft_m, base_m and side; see docs/howto/procedures')
    target = parser.add_mutually_exclusive_group()
    target.add_argument('--bearing', metavar='DEG', help='true bearing of the quay or mark that '
                        'rows without their own refer to')
    target.add_argument('--line', metavar="'LAT LON LAT LON'", help='a leading line, the nearer '
                        'mark first; or two surveyed points of a quay, from stern to bow')
    target.add_argument('--mark', metavar="'LAT LON'", help='a charted mark, seen from the '
                        'position of each row')
    target.add_argument('--sun', action='store_true', help='the azimuth of the sun at the time '
                        'and position of each row')
    parser.add_argument('--position', metavar="'LAT LON'", help='position of rows without their '
                        'own, decimal degrees, north and east positive')
    for option, metavar, words in (
            ('common-u-deg', 'DEG', 'standard uncertainty that all observations share, such as '
             'that of the survey; needed, 0 if there is none'),
            ('point-u-m', 'M', 'standard uncertainty of each point of --line or --mark, across '
             'the line'),
            ('u-deg', 'DEG', 'standard uncertainty of one observation (default: 0, so the scatter '
             'alone tells)'),
            ('time-u-s', 'S', 'standard uncertainty of the time of one observation (default: 1)'),
            ('clock-u-s', 'S', 'standard uncertainty of the offset between the clocks of observer '
             'and log (default: 1)'),
            ('ts-step-deg', 'DEG', 'step in which the tested sensor reports (default: found in '
             'its readings)')):
        parser.add_argument(f'--{option}', metavar=metavar, type=_number, help=words)
    parser.add_argument('--ts', metavar='TOPIC', help='topic of the tested sensor')
    add_log_arguments(parser, ('ts',))
    add_settings_arguments(parser)
    parser.add_argument('--json', metavar='F', help="write all figures as JSON; '-' for stdout")
    parser.add_argument('--check', action='store_true',
                        help='exit code 1 if non-compliant, 3 if indeterminate')


def run(arguments: argparse.Namespace) -> int:
    """Judge the observations; print and write what they say."""
    settings = settings_for(load_config(arguments.config), arguments.set, ts_topic=arguments.ts)
    target = _read_target(arguments)
    position = None if arguments.position is None else parse_position(
        arguments.position, 'position')
    files = [path for path in (arguments.input, arguments.table) if path is not None]
    check_outputs(Outputs(json=arguments.json), files, config=arguments.config)
    stated = {name: value for name in Uncertainties.__dataclass_fields__
              if (value := getattr(arguments, name)) is not None}
    try:
        observed = observe(arguments.input, arguments.table, settings, target=target,
                           driver=drivers_for(arguments, ('ts',))['ts'], position=position,
                           stated=Uncertainties(**stated))
    except ModuleNotFoundError as error:
        if error.name != 'ephem':
            raise
        raise ValueError('--sun: no module ephem: install heading_intercompare[sun]') from error
    if arguments.json == '-':
        sys.stdout.write(_render(observed, settings))
    else:
        say('\n'.join([*_list(observed), *(_say_test(test) for test in judge_observed(
            observed.error, settings))]), VERDICT_MARKS)
        if arguments.json:
            replace_file(arguments.json, _render(observed, settings))
    for name in observed.table.ignored:
        tell(f'{arguments.table}: column {name} is not read')
    return code_of(observed.error.outcome, 'holds') if arguments.check else 0


def _read_target(arguments: argparse.Namespace) -> Target:
    """Return what bearings were taken of."""
    point_u_m = arguments.point_u_m
    if arguments.sun:
        target = Target('sun')
    elif arguments.bearing is not None:
        try:
            target = Target('bearing', (float(arguments.bearing.replace(',', '.')),))
        except ValueError:
            raise ValueError(f'--bearing {arguments.bearing}: must be a number of degrees'
                             ) from None
    else:
        target = Target()
        for kind, points in _TARGETS.items():
            if (text := getattr(arguments, kind)) is not None:
                if point_u_m is None:
                    raise ValueError(f'--{kind} {text!r}: give --point-u-m, the standard '
                                     'uncertainty of the points in metres')
                target = Target(kind, parse_position(text, kind, points), point_u_m)
    if point_u_m is not None and target.kind not in _TARGETS:
        raise ValueError(f'--point-u-m {point_u_m:g}: is for --line and --mark; leave it out')
    return target


def _list(observed: Observed) -> Iterator[str]:
    """Yield the lines on standard output."""
    corrections, error = observed.corrections, observed.error
    yield (f'{"time, UTC":23}  {"computed/deg":>12}  {"TS/deg":>8}  {"C - O/deg":>9}  '
           f'{"u/deg":>7}')
    for i, row in enumerate(corrections.row.tolist()):
        marked = '?' if i in error.questionable else ' '
        yield (f'{utc(int(corrections.stamp_ns[i]))}  {corrections.true_deg[i]:12.3f}  '
               f'{corrections.ts_deg[i]:8.3f}  {corrections.c_minus_o_deg[i]:+9.3f}{marked} '
               f'{corrections.u_deg[i]:7.3f}  {observed.table.notes[row]}'.rstrip())
    lacking = ', '.join(f'{n} {reason}' for reason, n in corrections.not_used.items())
    span_min = corrections.span_s / 60.0
    yield (f'{error.n} observations over {span_min:.1f} min of {observed.table.target}'
           + (f'; not used: {lacking}' if lacking else ''))
    if error.correction_deg is not None:
        side = 'much' if error.correction_deg < 0.0 else 'little'
        yield ''
        yield (f'C - O, the correction to add  {error.correction_deg:+.3f} deg (the TS shows '
               f'{abs(error.correction_deg):.3f} deg too {side})')
    if error.std_deg is not None:
        yield from _budget(observed)
    yield ''
    yield f'VERDICT: {explain_outcome(error)}'
    if words := explain_scatter(error):
        yield words
    if error.std_deg is not None and all(c.name != 'slow_errors' for c in error.components):
        yield ('It covers the hours of the observations: TS errors that last longer look like a '
               'systematic error, unless norms.sigma_max_deg and risk.slowest_error_s state them.')


def _say_test(test: JudgedTest) -> str:
    """Return a test of the norm as a line."""
    result, figures, limit, clause = test.cells
    return f'test of the norm: {test.words} {figures}, limit {limit} ({clause}): {result}'


def _budget(observed: Observed) -> Iterator[str]:
    """Yield the lines of the uncertainty budget."""
    error = observed.error
    yield f'standard deviation            {error.std_deg:.3f} deg'
    yield 'uncertainty of the mean, standard:'
    for component in error.components:
        freedom = '' if component.nu is None else f', {component.nu:.0f} degrees of freedom'
        yield f'  {component.name:26}  {component.u_deg:.3f} deg  {component.words}{freedom}'
    nu = 'many' if error.nu is None or error.nu > _MOST_NU else f'{error.nu:.1f}'
    yield f'  {"combined":26}  {error.u_deg:.3f} deg  {nu} effective degrees of freedom'
    yield (f'  {"expanded, 95 %":26}  {error.expanded_u_deg:.3f} deg  k = {error.k:.2f}, Student')


def _render(observed: Observed, settings: Settings) -> str:
    """Return the observations, their budget and the outcome as JSON."""
    corrections, table = observed.corrections, observed.table
    rows: list[dict[str, Any]] = [
        {'stamp_ns': int(corrections.stamp_ns[i]), 'stamp_utc': utc(int(corrections.stamp_ns[i])),
         'computed_deg': float(corrections.true_deg[i]), 'ts_deg': float(corrections.ts_deg[i]),
         'c_minus_o_deg': float(corrections.c_minus_o_deg[i]),
         'u_deg': float(corrections.u_deg[i]), 'note': table.notes[row]}
        for i, row in enumerate(corrections.row.tolist())]
    stored_settings = settings.to_mapping()
    return json.dumps({
        'schema': SCHEMA, 'software': make_plain(Software()),
        'headline': explain_outcome(observed.error),
        'cannot_decide': explain_scatter(observed.error),
        **make_plain(observed.error), 'target': table.target, 'observations': rows,
        'norm_tests': make_plain(judge_observed(observed.error, settings)),
        'not_used': dict(corrections.not_used), 'span_s': corrections.span_s,
        'ts_step_deg': corrections.step_deg, 'recording': observed.recording,
        'recording_sha256': observed.recording_sha256, 'table_sha256': observed.table_sha256,
        'settings': stored_settings, 'settings_sha256': settings_sha256(stored_settings),
    }, indent=1, ensure_ascii=False, allow_nan=False) + '\n'
