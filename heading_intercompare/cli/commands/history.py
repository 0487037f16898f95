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

"""The command ``history``: runs of logbooks, since when a sensor differs, and their verdict."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
import sys
from typing import Any, Mapping, Sequence

from heading_intercompare.app.correction_files import SUFFIXES, write_corrections
from heading_intercompare.app.history_table import (
    check_table,
    SUFFIXES as TABLE_SUFFIXES,
    write_csv,
    write_table,
)
from heading_intercompare.app.run_table import parse_stamp
from heading_intercompare.cli.terminal.console import say, say_lines, tell, VERDICT_MARKS
from heading_intercompare.core.count_words import count_words
from heading_intercompare.core.decision.campaign import LEAST_RUNS
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.utc_text import utc
from heading_intercompare.core.validity.condition import HOLDS
from heading_intercompare.core.verdict.headline import say_outcome
from heading_intercompare.core.verdict.verdict_document import Software
from heading_intercompare.logbook.control_chart import LEAST_BASELINE
from heading_intercompare.logbook.correction import list_corrections
from heading_intercompare.logbook.history import History, Point, tell_histories
from heading_intercompare.logbook.last_runs import judge_last_runs
from heading_intercompare.logbook.logbook_file import Logbook, merge_logbooks
from heading_intercompare.logbook.row_chain import ChainHead
from heading_intercompare.logbook.run_row import RunRow
from heading_intercompare.logbook.service_change import compare_service, ServiceChange
from heading_intercompare.replaced_file import replace_file
from heading_intercompare.report import check_form

from .analyze import add_delivery_arguments, check_delivery, check_signing, deliver

SCHEMA = 'heading_intercompare/history/1'
_DIFFERS_CODE = 1
_BASELINE = 20
_OF_HISTORY = 'since', 'baseline', 'one_in', 'service', 'csv', 'html', 'correction', 'merge_into'
_OF_CERTIFY = 'reports', 'annexes_apart', 'runs_csv', 'verbose', 'sign', 'signers'
_NAMES = {'reports': 'output'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('logbooks', nargs='+', metavar='LOGBOOK',
                        help='written by the node compliance or by analyze --logbook')
    parser.add_argument('--ship', metavar='NAME', help='only this ship or station, with all its '
                        'sensors; SHIP/SENSOR for one of several')
    parser.add_argument('--since', metavar='UTC', help='list only the runs that end at or after '
                        'this time, such as 2026-03-01; the charts rest on all runs')
    parser.add_argument('--baseline', metavar='K', type=int,
                        help=f'number of runs that the charts learn from (default: {_BASELINE})')
    parser.add_argument('--one-in', metavar='N', type=float, help='false alarms of a chart: one '
                        'in N runs (default: 370, or more runs, so that the chance of a false '
                        'alarm in any chart is at most 5 %%)')
    parser.add_argument('--service', metavar='UTC', help='time of a service: say whether the runs '
                        'after it differ from those before')
    parser.add_argument('--json', metavar='F', help="write runs and charts; '-' for stdout")
    parser.add_argument('--csv', metavar='F', help="write a row per run; '-' for stdout")
    parser.add_argument('--html', metavar='F.html', help='write a page with the charts')
    parser.add_argument('--correction', metavar='F', help='write what to add to the heading of '
                        'the tested sensor, a row per run that is not void: F.csv with its '
                        'interval and by heading, or F.ang as UHDAS has it')
    parser.add_argument('--merge-into', metavar='FLEET', help='write all runs of the LOGBOOKs '
                        'into this one, and do no more')
    parser.add_argument('--check', action='store_true',
                        help='exit code 1 if a mean or standard deviation differs lastingly; with '
                        '--service, if it differs after that; with --certify as analyze')
    parser.add_argument('--certify', metavar='N', type=int, help='judge the last N usable runs of '
                        'a sensor together, by the rule sensor; choose N beforehand')
    parser.set_defaults(card=None)
    add_delivery_arguments(parser.add_argument_group(
        'with --certify, which writes its verdict to --json; without it, -o F.csv or -o F.parquet '
        'writes a row per run'))


def run(arguments: argparse.Namespace) -> int:
    """List the runs and say what the charts show."""
    _check_options(arguments)
    books = [Logbook(path) for path in arguments.logbooks]
    if arguments.merge_into is not None:
        n = merge_logbooks(Logbook(arguments.merge_into), books)
        say_lines([f'{count_words(n, "run")} of {count_words(len(books), "logbook")} are in '
                   f'{arguments.merge_into}'])
        return 0
    if arguments.certify is not None:
        return _certify(arguments, books)
    since_ns, service_ns = _read_time(arguments, 'since'), _read_time(arguments, 'service')
    contents = [book.read_with_head(arguments.ship) for book in books]
    histories = tell_histories(
        (row for rows, _ in contents for row in rows), baseline=arguments.baseline or _BASELINE,
        runs_between=arguments.one_in)
    changes = [() if service_ns is None else compare_service(
        [point.row for point in history.points], service_ns) for history in histories]
    heads = {book.path: head for book, (_, head) in zip(books, contents)}
    document = '' if arguments.json is None else _render(histories, changes, heads, since_ns)
    _write_files(histories, document, arguments, heads, since_ns)
    if arguments.json == '-':
        sys.stdout.write(document)
    elif arguments.csv == '-':
        write_csv(histories, sys.stdout, since_ns)
    else:
        lines = (_summarize(histories, changes) if len(histories) > 1 and arguments.ship is None
                 else _list(histories, changes, since_ns))
        say('\n'.join(lines) or 'no runs', VERDICT_MARKS)
    differs = (any(change.differs for service_changes in changes for change in service_changes)
               if service_ns is not None
               else any(h.differs for h in histories))
    return _DIFFERS_CODE if arguments.check and differs else 0


def _certify(arguments: argparse.Namespace, books: Sequence[Logbook]) -> int:
    """Judge the last runs together; print, write and sign their verdict as ``analyze`` does."""
    check_delivery(arguments, arguments.logbooks)
    check_signing(arguments)
    return deliver(judge_last_runs(books, arguments.certify, arguments.ship), arguments)


def _write_files(histories: Sequence[History], document: str, arguments: argparse.Namespace,
                 heads: Mapping[str, ChainHead | None], since_ns: int | None) -> None:
    if arguments.json not in (None, '-'):
        replace_file(arguments.json, document)
    for path in _list_tables(arguments):
        write_table(histories, path, since_ns, heads)
    if arguments.html is not None:
        from heading_intercompare.app.history_page import write_page

        write_page(histories, arguments.html, since_ns)
    if arguments.correction is not None:
        _write_corrections(histories, arguments.correction, since_ns)


def _list_tables(arguments: argparse.Namespace) -> list[str]:
    """Return the files of tables of runs; without --certify, -o names tables."""
    return [*arguments.reports, *([arguments.csv] if arguments.csv not in (None, '-') else [])]


def _write_corrections(histories: Sequence[History], path: str, since_ns: int | None) -> None:
    """Write the corrections of the heading, and say how many runs give none."""
    corrections, left_out = list_corrections(
        point.row for history in histories for point in history.list_since(since_ns))
    write_corrections(corrections, path)
    why = ', '.join(f'{n} {reason}' for reason, n in left_out.items())
    tell(f'--correction {path}: {count_words(len(corrections), "run")}'
         + (f'; no correction from {count_words(sum(left_out.values()), "run")}: {why}' if why
            else ''))


def _check_options(arguments: argparse.Namespace) -> None:
    _check_certify(arguments)
    if arguments.certify is None:
        for path in _list_tables(arguments):
            check_table(path)
    if arguments.baseline is not None and arguments.baseline < LEAST_BASELINE:
        raise ValueError(f'--baseline {arguments.baseline}: must be at least {LEAST_BASELINE}')
    if arguments.one_in is not None and not 2.0 <= arguments.one_in <= 1e6:
        raise ValueError(f'--one-in {arguments.one_in:g}: must be from 2 to 1000000')
    if arguments.json == arguments.csv == '-':
        raise ValueError('--json - and --csv -: only one can be on standard output')
    logbooks = {Path(os.path.realpath(path)) for path in arguments.logbooks}
    paths = [(option, getattr(arguments, option))
             for option in ('json', 'csv', 'html', 'correction')]
    paths += [('output', path) for path in arguments.reports]
    for option, path in paths:
        if path is not None and path != '-' and Path(os.path.realpath(path)) in logbooks:
            raise ValueError(f'--{option} {path}: that is a LOGBOOK; name another file')
    if arguments.correction is not None and not arguments.correction.endswith(SUFFIXES):
        raise ValueError(f'--correction {arguments.correction}: must end with '
                         f'{" or ".join(SUFFIXES)}')
    if arguments.html is not None:
        if Path(arguments.html).suffix != '.html':
            raise ValueError(f'--html {arguments.html}: must end with .html')
        check_form(arguments.html)


def _check_certify(arguments: argparse.Namespace) -> None:
    """Reject a number of runs that is too small, and options that do not go with it."""
    n = arguments.certify
    if n is not None and n < LEAST_RUNS:
        raise ValueError(f'--certify {n}: must be at least {LEAST_RUNS} runs, for fewer say '
                         'nothing about errors slower than a run')
    options, why = ((_OF_HISTORY, 'is not for --certify') if n is not None
                    else (_OF_CERTIFY, 'is for --certify N'))
    for option in options:
        value = getattr(arguments, option)
        if n is None and option == 'reports':
            value = [path for path in value if not path.endswith(TABLE_SUFFIXES)]
        if value:
            shown = value[0] if isinstance(value, list) else '' if value is True else value
            raise ValueError(f'--{_NAMES.get(option, option).replace("_", "-")} {shown}'.rstrip()
                             + f': {why}; leave it out')


def _read_time(arguments: argparse.Namespace, option: str) -> int | None:
    text = getattr(arguments, option)
    try:
        return None if text is None else parse_stamp(text)
    except ValueError:
        raise ValueError(f'--{option} {text}: must be a time, UTC, such as 2026-03-01 or '
                         '2026-03-01T12:00:00Z') from None


def _list(histories: Sequence[History], changes: Sequence[Sequence[ServiceChange]],
          since_ns: int | None) -> list[str]:
    """Return the lines on standard output: runs, newest last, then what the charts say."""
    lines = []
    for history, service_changes in zip(histories, changes):
        lines += [f'{history.name}: {count_words(len(history.points), "run")}',
                  f'  {"start, UTC":16}  {"hours":>7}  {"n":>9}  {"mean/deg":>9}  {"sd/deg":>8}  '
                  'outcome']
        lines += [f'  {_describe(point)}' for point in history.list_since(since_ns)]
        if history.why_no_chart is not None:
            lines.append(f'  no charts yet: {history.why_no_chart}')
        lines += [f'  {trend.words}' for trend in history.trends]
        lines += [f'  service: {change.words}' for change in service_changes]
    return lines


def _summarize(histories: Sequence[History],
               changes: Sequence[Sequence[ServiceChange]]) -> list[str]:
    """Return a line for each history, the worst first, and one for all of them."""
    width = max(len(history.name) for history in histories)
    return [f'{"ship":{width}}  {"runs":>6}  {"newest, UTC":16}  outcome',
            *(_summarize_history(history, service_changes, width)
              for history, service_changes in zip(histories, changes)),
            f'{sum(history.differs for history in histories)} of {len(histories)} differ; '
            '--ship NAME lists the runs']


def _summarize_history(history: History, service_changes: Sequence[ServiceChange],
                       width: int) -> str:
    """Return the line of a history: runs, newest run, and what the charts say."""
    newest = history.points[-1].row
    words = [*history.state, *(change.words for change in service_changes)]
    return (f'{history.name:{width}}  {len(history.points):>6}  {utc(newest.end_ns)[:16]}  '
            f'{_say_outcome(newest)}' + ''.join(f'; {word}' for word in words))


def _say_outcome(row: RunRow) -> str:
    conditions = '' if row.validity_effect == HOLDS else f': {row.conditions}'
    return say_outcome(row.outcome, row.validity_effect) + conditions


def _describe(point: Point) -> str:
    row = point.row
    figures = ['-' if figure is None else f'{figure:.4f}' for figure in (row.mean_deg, row.sd_deg)]
    outcome = _say_outcome(row)
    if point.outside:
        outcome += f'; {" and ".join(point.outside)} outside the limits'
    hours = (row.end_ns - row.start_ns) / 3.6e12
    return (f'{utc(row.start_ns)[:16]}  {hours:7.2f}  {row.n:9}  {figures[0]:>9}  '
            f'{figures[1]:>8}  {outcome}')


def _render(histories: Sequence[History], changes: Sequence[Sequence[ServiceChange]],
            heads: Mapping[str, ChainHead | None], since_ns: int | None) -> str:
    """Return runs and charts as JSON, and the newest entry of the chain of each logbook."""
    plain: list[dict[str, Any]] = [
        {**make_plain(history), 'points': make_plain(history.list_since(since_ns)),
         **({'service': make_plain(service_changes)} if service_changes else {})}
        for history, service_changes in zip(histories, changes)]
    return json.dumps({'schema': SCHEMA, 'software': make_plain(Software()),
                       'one_in': histories[0].runs_between if histories else None,
                       'chains': {path: head and head._asdict() for path, head in heads.items()},
                       'histories': plain},
                      indent=1, ensure_ascii=False, allow_nan=False) + '\n'
