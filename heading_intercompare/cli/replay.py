# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``replay``: a bag to the topics from which it was recorded."""

from __future__ import annotations

import argparse

from heading_intercompare.cli.ros import program_node

__all__ = ['add_arguments', 'run']


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bag', metavar='BAG', help='.mcap file or rosbag2 directory')
    parser.add_argument('--rate', type=float, metavar='X',
                        help='speed, times that of the recording (default 1; 0: no waiting)')
    parser.add_argument('--start', type=float, metavar='S',
                        help='seconds to leave out at the start')
    parser.add_argument('--duration', type=float, metavar='S', help='seconds to replay')
    parser.add_argument('--loop', action='store_true', help='begin again at the end')
    parser.add_argument('--clock', action='store_true', help='publish the time on /clock')
    parser.add_argument('--config', metavar='F', help='ROS parameter file with the settings')


def run(arguments: argparse.Namespace) -> int:
    """Replay the bag; ends with it."""
    return program_node(
        'replayer', 'Replayer', arguments.config, bag=arguments.bag, rate=arguments.rate,
        start_s=arguments.start, duration_s=arguments.duration, loop=arguments.loop or None,
        clock=arguments.clock or None)
