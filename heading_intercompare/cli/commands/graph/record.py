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

"""The command ``record``: records the topics of the graph to a bag until Ctrl-C."""

from __future__ import annotations

import argparse
from typing import Any

from heading_intercompare.cli.commands.note import add_note_argument, read_notes
from heading_intercompare.cli.node_command import add_namespace_argument, run_node
from heading_intercompare.cli.terminal.live_view import LiveView


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('-o', '--output', metavar='BAG', help='the rosbag2 directory to write '
                        '(default: heading_<UTC> in this folder)')
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')
    add_namespace_argument(parser)
    add_note_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Record until Ctrl-C."""
    def watch(recorder: Any, watcher: Any) -> None:
        if recorder.written:
            watcher.open()
        shown.show(watcher.view())

    with LiveView('heading-intercompare record', 'Ctrl-C ends the recording',
                  arguments.quiet) as shown:
        return run_node('recorder', 'Recorder', arguments.config,
                        namespace=arguments.namespace, output=arguments.output,
                        beside=None if arguments.quiet else ('watcher', 'Watcher', watch),
                        note=read_notes(arguments) or None, parameter_file=arguments.config)
