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

"""Operator's notes: the command ``note``, and the option ``--note`` of other commands."""

from __future__ import annotations

import argparse

from heading_intercompare.bags.errors import utf8
from heading_intercompare.bags.rosbag2.provenance import note_lines
from heading_intercompare.cli.node_command import add_namespace_argument
from heading_intercompare.cli.terminal.console import say_lines

_TIMED = 'if it begins with a time such as 2026-03-01T09:00:00Z, it gets that time'


def add_note_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--note``."""
    parser.add_argument(
        '--note', metavar='TEXT', action='append', default=[],
        help=f'a note to keep in the bag: ship, sensors, an event; may be repeated; {_TIMED}')


def read_notes(arguments: argparse.Namespace) -> str:
    """
    Return the notes given with ``--note``, one per line.

    Raises
    ------
    ValueError
        If one is empty, or not UTF-8.

    """
    return '\n'.join(_check('--note', note) for note in arguments.note)


def _check(option: str, text: str) -> str:
    if not note_lines(utf8(text, option)):
        raise ValueError(f'{option} {text!r}: must not be empty')
    return text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('text', nargs='+', metavar='TEXT', help=f'the note; {_TIMED}')
    add_namespace_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Publish a note, and confirm it once a recorder has received it."""
    text = _check('TEXT', ' '.join(arguments.text).strip())
    from heading_intercompare.nodes.sending.note_publisher import publish_note

    publish_note(text, arguments.namespace)
    say_lines([f'noted: {text}'])
    return 0
