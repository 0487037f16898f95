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

"""The command ``recover``: everything readable of a damaged bag into a new one."""

from __future__ import annotations

import argparse

from heading_intercompare.bags.recovery.recover_bag import recover
from heading_intercompare.bags.recovery.recovered import Recovered
from heading_intercompare.cli.terminal.console import say_lines, tell
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.count_words import count_words


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bag', metavar='BAG',
                        help='.mcap file or rosbag2 directory; it is not changed')
    parser.add_argument('-o', '--output', metavar='BAG', required=True,
                        help='the rosbag2 directory to write')
    parser.add_argument('--unproven', action='store_true',
                        help='also keep the messages of chunks whose checksum is wrong, as far '
                             'as they can be read; the new bag and its verdicts say so')


def run(arguments: argparse.Namespace) -> int:
    """Write the new bag, and print what was kept and what was lost."""
    with Progress(arguments.bag, arguments.quiet) as progress:
        total = recover(arguments.bag, arguments.output, progress=progress.show,
                        unproven=arguments.unproven)
    for note in total.notes:
        tell(note)
    for topic, count in sorted(total.counts.items()):
        say_lines([f'{topic}: {count_words(count, "message")}'])
    say_lines([f'kept: {count_words(total.messages, "message")} in '
               f'{count_words(total.chunks, "chunk")} of {count_words(total.files, "file")}, '
               f'{total.bytes} bytes', f'lost: {_describe_losses(total)}',
               *([f'kept without proof: {count_words(total.messages_unproven, "message")}']
                 if total.messages_unproven else []),
               f'bag: {arguments.output}'])
    return 0


def _describe_losses(total: Recovered) -> str:
    if not total.damaged:
        return 'nothing'
    bound = '' if total.messages_known else 'at least '
    return (f'{bound}{count_words(total.messages_lost, "message")}; '
            f'{count_words(total.chunks_lost, "chunk")} damaged or cut; '
            f'{count_words(total.bytes_lost, "byte")} unreadable')
