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

"""The command ``rejudge``: judges old recordings again and lists the changed outcomes."""

from __future__ import annotations

import argparse
from collections import Counter
import json
import sys
from typing import Sequence

from heading_intercompare.app.config import load_config
from heading_intercompare.app.outputs import check_outputs, Outputs
from heading_intercompare.app.rejudge import (
    CHANGED,
    rejudge,
    Rejudged,
    SAME,
    UNJUDGED,
    WITHOUT_REPORT,
)
from heading_intercompare.cli.terminal.console import say_lines, tell, VERDICT_MARKS
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.typed_reader import make_plain
from heading_intercompare.core.verdict.verdict_document import Software
from heading_intercompare.core.version import RULE_VERSION
from heading_intercompare.replaced_file import replace_file

from .analyze import add_settings_arguments

SCHEMA = 'heading_intercompare/rejudge/1'
_CHANGED_CODE, _UNKNOWN_CODE = 1, 3
_WORDS = {CHANGED: 'changed', UNJUDGED: 'not judged', WITHOUT_REPORT: 'without a report',
          SAME: 'the same'}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bags', nargs='+', metavar='BAG',
                        help='.mcap file or rosbag2 directory; or a verdict in JSON, whose inputs '
                        'are judged. The settings are those stored in it, unless --config '
                        'replaces all and --set some of them')
    add_settings_arguments(parser)
    parser.add_argument('--json', metavar='F', help="write the results as JSON; '-' for stdout")
    parser.add_argument('--check', action='store_true',
                        help='exit code 1 if an outcome changed, 3 if one could not be compared')


def run(arguments: argparse.Namespace) -> int:
    """Judge the recordings again, and print one line for each, the worst change first."""
    config = load_config(arguments.config) if arguments.config else None
    check_outputs(Outputs(json=arguments.json), arguments.bags, config=arguments.config)
    with Progress(f'{len(arguments.bags)} bags', arguments.quiet) as progress:
        rejudged = rejudge(arguments.bags, config, arguments.set, progress=progress.show)
    for bag in rejudged:
        for note in bag.notes:
            tell(f'{bag.path}: {note}')
    if all(bag.status == UNJUDGED for bag in rejudged):
        several = f'none of the {len(rejudged)} bags can be judged: ' if len(rejudged) > 1 else ''
        raise ValueError(f'{several}{rejudged[0].path}: {rejudged[0].error}')
    counts = Counter(bag.status for bag in rejudged)
    if arguments.json == '-':
        sys.stdout.write(_render(rejudged))
    else:
        say_lines([bag.line for bag in rejudged], VERDICT_MARKS)
        say_lines([f'of {len(rejudged)}: ' + ', '.join(
            f'{counts[status]} {words}' for status, words in _WORDS.items())])
        if arguments.json:
            replace_file(arguments.json, _render(rejudged), 'backslashreplace')
    if not arguments.check:
        return 0
    return (_CHANGED_CODE if counts[CHANGED] else
            0 if counts[SAME] == len(rejudged) else _UNKNOWN_CODE)


def _render(rejudged: Sequence[Rejudged]) -> str:
    """Return the results as JSON text."""
    return json.dumps({'schema': SCHEMA, 'software': make_plain(Software()),
                       'rule_version': RULE_VERSION, 'bags': make_plain(rejudged)},
                      indent=1, ensure_ascii=False, allow_nan=False) + '\n'
