# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``info``: what a bag holds."""

from __future__ import annotations

import argparse
import json
from typing import Iterator, Mapping, Sequence

from heading_intercompare.bags.reader import Attachment, BagReader
from heading_intercompare.cli.table import verdict_text
from heading_intercompare.report.wording import utc

__all__ = ['add_arguments', 'run']

#: The metadata record with what the program knew when it wrote the bag.
_OURS = 'heading_intercompare'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument('bag', metavar='BAG', help='.mcap file or rosbag2 directory')


def run(arguments: argparse.Namespace) -> int:
    """Print what the bag says of itself."""
    reader = BagReader(arguments.bag)
    metadata = reader.metadata()
    lines = [*_whole(reader), *_topics(reader), *_records(metadata),
             *_files(reader.attachments())]
    print('\n'.join(lines))
    return 0


def _whole(reader: BagReader) -> Iterator[str]:
    yield f'bag: {reader.path}'
    missing = reader.incomplete or reader.recovered
    yield f'complete: {"yes" if missing is None else f"no: {missing}"}'
    span_s = _span_s(reader)
    if span_s is None:
        yield 'span: no message'
    else:
        yield (f'span: {utc(reader.start_ns)} to {utc(reader.end_ns)} UTC, '
               f'{span_s:.1f} s')


def _span_s(reader: BagReader) -> float | None:
    return None if reader.start_ns is None else (reader.end_ns - reader.start_ns) / 1e9


def _topics(reader: BagReader) -> Iterator[str]:
    span_s = _span_s(reader)
    rows = [('topic', 'type', 'messages', 'rate [1/s]')]
    for name, info in sorted(reader.topics.items()):
        rate = f'{(info.count - 1) / span_s:.2f}' if span_s and info.count > 1 else '-'
        rows.append((name, info.type_name or '(without a schema)', str(info.count), rate))
    yield ''
    yield from _columns(rows)


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in rows]


def _records(metadata: Mapping[str, Mapping[str, str]]) -> Iterator[str]:
    """Yield the metadata records; ours by its groups: version, sources, settings with norms."""
    for name, entries in sorted(metadata.items(), key=lambda item: item[0] != _OURS):
        if name == 'rosbag2':
            continue
        yield ''
        if name == _OURS:
            yield f'software: {_OURS} {entries.get("version", "(unknown version)")}'
            groups = {key.partition('.')[0] for key in entries if '.' in key}
        else:
            yield f'{name}:'
            groups = set()
        for key, value in entries.items():
            if key != 'version' and key.partition('.')[0] not in groups:
                yield f'  {key}: {value}'
        for group in sorted(groups):
            yield f'{group}:'
            for key, value in entries.items():
                if key.startswith(f'{group}.'):
                    yield f'  {key[len(group) + 1:]}: {value}'


def _files(attachments: Sequence[Attachment]) -> Iterator[str]:
    """Yield the attachments; of the verdict and the table of runs what they say."""
    for attachment in attachments:
        yield ''
        yield (f'attachment: {attachment.name} ({attachment.media_type}, '
               f'{len(attachment.data)} bytes)')
        text = attachment.data.decode(errors='replace')
        if attachment.name == 'runs.csv':
            yield from (f'  {line}' for line in text.splitlines())
        elif attachment.name == 'report.json':
            yield from _verdict(text)


def _verdict(text: str) -> Iterator[str]:
    try:
        yield from verdict_text(json.loads(text)).splitlines()
    except (ValueError, KeyError, TypeError, AttributeError):
        yield '  not a verdict that this version reads'
