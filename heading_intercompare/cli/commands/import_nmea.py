# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``import-nmea``: the logs of two sensors into one bag."""

from __future__ import annotations

import argparse
import time

import numpy as np

from heading_intercompare.app.config import load_config, settings_for
from heading_intercompare.app.logs.log_import import import_log
from heading_intercompare.bags.recording.bag_writer import BagWriter, Rows
from heading_intercompare.bags.rosbag2.provenance import describe_origin, Notes, RECORD
from heading_intercompare.cli.terminal.progress import Progress
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu

from .analyze import add_log_arguments, add_settings_arguments, drivers_for
from .note import add_note_argument, read_notes

__all__ = ['add_arguments', 'run']

_PIECE = 20_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    for role, words in (('ts', 'tested'), ('rs', 'reference')):
        parser.add_argument(f'--{role}', metavar='FILE', required=True,
                            help=f'log of the {words} sensor: a file, a folder, or a pattern in '
                            'quotes')
    add_log_arguments(parser)
    parser.add_argument('-o', '--output', metavar='BAG', required=True,
                        help='the rosbag2 directory to write')
    add_note_argument(parser)
    add_settings_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Read both logs, write the bag, print the counts of headings and of rejected lines."""
    settings = settings_for(load_config(arguments.config), arguments.set)
    notes = read_notes(arguments)
    topics = {'ts': settings.ts_topic, 'rs': settings.rs_topic}
    drivers, logs = drivers_for(arguments), {}
    for role in topics:
        path = getattr(arguments, role)
        with Progress(path, arguments.quiet) as progress:
            logs[role] = import_log(path, drivers[role], progress.show, role=role)
    origins = {role: log.origin for role, log in logs.items()}
    read = {role: log.headings for role, log in logs.items()}
    _write(arguments.output, read, topics, describe_origin(settings.to_mapping(), origins), notes)
    for role in topics:
        print(f'{role.upper()} {logs[role].path}: {len(read[role])} headings on '
              f'{"; ".join((topics[role], *logs[role].remarks))}; not taken: '
              f'{logs[role].words_not_taken}')
    print(f'bag: {arguments.output}')
    return 0


def _write(path: str, read: dict[str, Headings], topics: dict[str, str],
           said: dict[str, object], notes: str) -> None:
    """Write both streams merged by stamp, each in the order of its log."""
    # A bag is ordered by log time. The largest stamp so far keeps a stream in order even if its
    # stamps step back.
    logs = {role: np.maximum.accumulate(h.stamp_ns) for role, h in read.items()}
    edges = _edges([log for log in logs.values() if len(log)])
    with BagWriter(path) as bag:
        for topic in topics.values():
            bag.add_topic(topic, 'sensor_msgs/msg/Imu')
        bag.metadata(RECORD, said)
        Notes(bag.metadata).add(notes, time.time_ns())
        for begin, end in zip(edges[:-1], edges[1:]):
            batches = []
            for role, log in logs.items():
                lo, hi = np.searchsorted(log, [begin, end])
                part = read[role][lo:hi]
                batches.append(Rows(topics[role], encode_imu(part, f'{role}_heading'),
                                    log[lo:hi], part.stamp_ns, np.arange(lo, hi)))
            bag.write_rows(batches)


def _edges(logs: list[np.ndarray]) -> list[int]:
    """Return the bounds of the pieces that are merged one at a time, to bound the memory."""
    joined = np.sort(np.concatenate(logs))
    return [*np.unique(joined[::_PIECE]).tolist(), int(joined[-1]) + 1]
