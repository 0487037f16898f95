# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``report``: the protocol of recorded runs, with plots."""

from __future__ import annotations

import argparse

from . import analyze

__all__ = ['add_arguments', 'run']


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('inputs', nargs=1, metavar='INPUT',
                        help='.mcap file, rosbag2 directory or .csv of pairs')
    parser.add_argument('-o', '--output', dest='report', metavar='F.html', required=True,
                        help='the protocol')
    analyze.add_settings_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Judge the input as `analyze` does, and write the protocol."""
    parser = argparse.ArgumentParser()
    analyze.add_arguments(parser)
    others = parser.parse_args([*arguments.inputs])
    return analyze.run(argparse.Namespace(**{**vars(others), **vars(arguments)}))
