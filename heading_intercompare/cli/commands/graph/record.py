# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``record``: records the topics of the graph to a bag until Ctrl-C."""

from __future__ import annotations

import argparse
from typing import Any

from heading_intercompare.cli.commands.note import add_note_argument, read_notes
from heading_intercompare.cli.node_command import run_node
from heading_intercompare.cli.terminal.live_view import LiveView

__all__ = ['add_arguments', 'run']


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('-o', '--output', metavar='BAG', help='the rosbag2 directory to write '
                        '(default: heading_<UTC> in this folder)')
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')
    add_note_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Record until Ctrl-C."""
    def watch(recorder: Any, watcher: Any) -> None:
        if recorder.written:
            watcher.open()
        shown.show(watcher.view())

    with LiveView('heading-intercompare record', 'Ctrl-C ends the recording',
                  arguments.quiet) as shown:
        return run_node('recorder', 'Recorder', arguments.config, output=arguments.output,
                        beside=None if arguments.quiet else ('watcher', 'Watcher', watch),
                        note=read_notes(arguments) or None, parameter_file=arguments.config)
