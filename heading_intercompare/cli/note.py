# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The operator's notes: the command ``note``, and the option of the commands that make a bag."""

from __future__ import annotations

import argparse

__all__ = ['add_arguments', 'add_note_argument', 'noted', 'run']

_TIMED = 'one that begins with a time such as 2026-03-01T09:00:00Z is of that time'


def add_note_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--note``."""
    parser.add_argument(
        '--note', metavar='TEXT', action='append', default=[],
        help=f'a note kept in the bag: ship, sensors, an event; may be repeated; {_TIMED}')


def noted(arguments: argparse.Namespace) -> str:
    """
    Return the notes given with ``--note``, one a line.

    Raises
    ------
    ValueError
        If one is empty.

    """
    for note in arguments.note:
        if not note.strip():
            raise ValueError(f'--note {note!r}: must not be empty')
    return '\n'.join(arguments.note)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('text', nargs='+', metavar='TEXT', help=f'what happens; {_TIMED}')


def run(arguments: argparse.Namespace) -> int:
    """Publish a note; say so once it has been taken."""
    text = ' '.join(arguments.text).strip()
    if not text:
        raise ValueError("TEXT '': must not be empty")
    from heading_intercompare.nodes.note import publish_note

    publish_note(text)
    print(f'noted: {text}')
    return 0
