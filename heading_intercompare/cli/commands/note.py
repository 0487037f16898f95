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
import getpass

from heading_intercompare.bags.errors import utf8
from heading_intercompare.bags.rosbag2.provenance import note_lines
from heading_intercompare.cli.node_command import add_namespace_argument
from heading_intercompare.cli.terminal.console import say_lines
from heading_intercompare.messages.authors import sign_text

_TIMED = 'if it begins with a time such as 2026-03-01T09:00:00Z, it gets that time'


def add_note_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--note``."""
    parser.add_argument(
        '--note', metavar='TEXT', action='append', default=[],
        help=f'a note to keep in the bag: ship, sensors, an event; may be repeated; {_TIMED}')
    _add_operator_argument(parser)


def _add_operator_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--operator', metavar='NAME', default=_find_login(),
        help='who notes this; the name stands at the end of each note (default: the login name)')


def _find_login() -> str:
    """Return the login name; '' if the computer does not know it."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return ''


def read_notes(arguments: argparse.Namespace) -> str:
    """
    Return the notes given with ``--note``, one per line, each with the name of the operator.

    Raises
    ------
    ValueError
        If one is empty, or a note or the name is not UTF-8.

    """
    return '\n'.join(_sign(_check('--note', note), arguments.operator) for note in arguments.note)


def _sign(text: str, operator: str) -> str:
    name = utf8(operator, '--operator')
    return '\n'.join(sign_text(line, name) for line in note_lines(text))


def _check(option: str, text: str) -> str:
    if not note_lines(utf8(text, option)):
        raise ValueError(f'{option} {text!r}: must not be empty')
    return text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('text', nargs='+', metavar='TEXT', help=f'the note; {_TIMED}')
    _add_operator_argument(parser)
    add_namespace_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Publish a note, and confirm it once a recorder has received it."""
    text = _sign(_check('TEXT', ' '.join(arguments.text).strip()), arguments.operator)
    from heading_intercompare.nodes.sending.note_publisher import publish_note

    publish_note(text, arguments.namespace)
    say_lines([f'noted: {text}'])
    return 0
