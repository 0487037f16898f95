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

"""The command ``replay``: publishes a bag on its topics, under the same or other names."""

from __future__ import annotations

import argparse
from pathlib import Path
import re
import sys
from typing import Any

from heading_intercompare.cli.node_command import add_namespace_argument, run_node
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.cli.terminal.status_lines import StatusLines

_TOPIC = re.compile(r'(?!.*__)(~?/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*', re.ASCII)
_NUMBER = re.compile(r'\d[\d.,]*')


def _parse_rule(text: str) -> tuple[str, str]:
    """Return the old and the new name of a topic."""
    old, _, new = text.partition(':=')
    if not (_TOPIC.fullmatch(old) and _TOPIC.fullmatch(new)):
        raise argparse.ArgumentTypeError(
            f'{text!r} must be OLD:=NEW, two topic names without __, as in '
            'ts/heading:=gyro/heading')
    return old, new


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bag', metavar='BAG', help='.mcap file or rosbag2 directory')
    parser.add_argument('--rate', type=float, metavar='X',
                        help='speed as a multiple of the recorded one (default: 1; 0: no waiting)')
    parser.add_argument('--start', type=float, metavar='S',
                        help='seconds to skip at the start')
    parser.add_argument('--duration', type=float, metavar='S', help='seconds to replay')
    parser.add_argument('--loop', action='store_true', help='start again at the end')
    parser.add_argument('--clock', action='store_true', help='publish the time on /clock')
    parser.add_argument('-m', '--remap', type=_parse_rule, nargs='+', action='extend', default=[],
                        metavar='OLD:=NEW', help='publish a topic under another name, e.g. '
                        'ts/heading:=gyro/heading; give it after BAG')
    parser.add_argument('--start-paused', action='store_true', help='start paused')
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')
    add_namespace_argument(parser)
    parser.add_argument_group('while it runs', 'In a terminal, the space bar pauses and resumes. '
                              'The services ~/pause, ~/resume and ~/toggle_paused always work.')


def run(arguments: argparse.Namespace) -> int:
    """Replay the bag, and return at its end."""
    from heading_intercompare.cli.terminal.keyboard import Keyboard

    remap: dict[str, str] = {}
    for old, new in arguments.remap:
        if old in remap:
            raise ValueError(f'--remap {old}:={new}: {old} is already remapped to {remap[old]}')
        remap[old] = new

    def watch(node: Any) -> None:
        if keyboard.keys().count(' ') % 2:
            node.pause()
        keys = '; space: pause, resume' if keyboard.on else ''
        line.show(f'{node.state}{keys}')
        if plain and lines.is_due(_NUMBER.sub('#', node.state)):
            lines.write(f'{name}: {node.state}')

    name, lines = Path(arguments.bag).name, StatusLines()
    plain = not (arguments.quiet or sys.stderr.isatty())
    with Progress(name, arguments.quiet) as line, Keyboard() as keyboard:
        return run_node(
            'replayer', 'Replayer', arguments.config, namespace=arguments.namespace,
            remap=remap, watch=watch, bag=arguments.bag, rate=arguments.rate,
            start_s=arguments.start, duration_s=arguments.duration, loop=arguments.loop or None,
            clock=arguments.clock or None, start_paused=arguments.start_paused or None)
