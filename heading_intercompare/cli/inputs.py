# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Recorded runs as inputs of an analysis: MCAP files, rosbag2 directories, csv of pairs."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
import csv
from datetime import datetime, timezone
import hashlib
from pathlib import Path
from typing import Any, Callable, Iterator, Sequence

from heading_intercompare.bags.cdr import decode
from heading_intercompare.bags.pairs_csv import read_pairs_csv
from heading_intercompare.bags.provenance import notes_in
from heading_intercompare.bags.reader import BagReader
from heading_intercompare.core.analysis import aligned
from heading_intercompare.core.intercomparison import Compliance, Intercomparison
from heading_intercompare.core.judge import RunResult
from heading_intercompare.core.ledger import Ledger
from heading_intercompare.core.pairing import rising
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.settings import Settings

__all__ = ['analyze_input', 'read_run_table', 'RunTable', 'sha256']

RunTable = Sequence[tuple[int, int, str]]
MARKER_TOPIC = 'compliance/marker'


def analyze_input(path: str, settings: Settings, table: RunTable | None,
                  takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                  *, name: str | None = None,
                  helpers: int = 0) -> tuple[list[RunResult], list[str], dict[str, Any]]:
    """
    Judge the runs of one input.

    Parameters
    ----------
    path : str
        ``.mcap`` file, rosbag2 directory or ``.csv`` of pairs.
    settings : Settings
    table : sequence of (start_ns, stop_ns, source), optional
        Runs; those with a source are for the input of that name only.
    takers : sequence of callable
        Each is given the pairs, chunk by chunk.
    progress : callable
        Told what has been done.
    name : str, optional
        What results and notes call it, and the table of runs; `path` by default.
    helpers : int
        Processes that decode a bag beside this one.

    Returns
    -------
    results : list of RunResult
    notes : list of str
        What the user should know of the input: unfinished bag, no run.
    described : dict
        Its entry in the verdict: name, SHA-256, topics, operator's notes.

    Raises
    ------
    OSError
        If it cannot be read.
    BagError
        If it is not what it should be.

    """
    name = path if name is None else name
    runs = None if table is None else [
        (start, stop) for start, stop, source in table
        if source in ('', name, Path(name).name)]
    with ThreadPoolExecutor(1) as beside:
        digest: list[Future[str]] = []

        def all_read() -> None:
            # Not earlier: helpers are started by a process that has one thread.
            digest.append(beside.submit(sha256, path))
        if Path(path).suffix == '.csv':
            results, notes = _analyze_csv(path, name, settings, runs, takers, progress, all_read)
        else:
            results, notes = _analyze_bag(path, name, settings, runs, takers, progress, all_read,
                                          helpers)
        return results, notes, _described(path, name, settings, digest[0].result())


def _analyze_csv(path: str, name: str, settings: Settings,
                 runs: Sequence[tuple[int, int]] | None,
                 takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                 all_read: Callable[[], None]) -> tuple[list[RunResult], list[str]]:
    compliance = Compliance(settings, source=name, table=runs)
    ledger = Ledger()
    n, newest_ns = 0, None
    for pairs in read_pairs_csv(path):
        n += len(pairs)
        ledger.receive('ts', pairs.stamp_ns)
        ledger.receive('rs', pairs.stamp_ns)
        rises = rising(pairs.stamp_ns, newest_ns)
        for stream in ('ts', 'rs'):
            ledger.add(f'{stream}_rejected.stamp_not_increasing', pairs.stamp_ns[~rises])
        pairs = pairs[rises]
        ledger.add('paired', pairs.stamp_ns)
        ledger.add('rs_used', pairs.stamp_ns)
        if len(pairs):
            newest_ns = int(pairs.stamp_ns[-1])
        compliance.update(pairs)
        for take in takers:
            take(pairs)
        progress(f'{n:,} pairs')
    all_read()
    compliance.finish()
    for cut_ns in compliance.cuts:
        ledger.cut(cut_ns)
    return compliance.results(ledger), []


def _analyze_bag(path: str, name: str, settings: Settings,
                 runs: Sequence[tuple[int, int]] | None,
                 takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                 all_read: Callable[[], None],
                 helpers: int) -> tuple[list[RunResult], list[str]]:
    comparison = Intercomparison(settings, source=name, table=runs)
    reader = BagReader(path)
    ts, rs = settings.ts_topic, settings.rs_topic
    conventions = {ts: settings.ts_convention, rs: settings.rs_convention}
    if runs is None:
        for kind, stamp_ns in _marks(reader):
            comparison.mark(kind, stamp_ns)
    # To align a run takes all readings once more; else they are forgotten chunk by chunk.
    kept = {ts: [], rs: []} if settings.alignment.skew == 'apply' else {}
    n = 0
    for chunk in reader.headings(conventions, helpers):
        for topic, chunks in kept.items():
            chunks.append(chunk[topic])
        pairs = comparison.update(ts=chunk[ts], rs=chunk[rs])
        n += sum(len(h) for h in chunk.values())
        for take in takers:
            take(pairs)
        progress(f'{n:,} headings')
    all_read()
    pairs = comparison.finish()
    for take in takers:
        take(pairs)
    notes = [f'{name}: {why}' for why in (reader.incomplete, reader.recovered) if why]
    results = comparison.results()
    if kept:
        results = aligned(*(Headings.concatenate(kept[topic]) for topic in (ts, rs)), results,
                          settings, source=name)
    return results, notes


def _marks(reader: BagReader) -> Iterator[tuple[str, int]]:
    """Yield the start and stop marks that were recorded."""
    topics = [t for t in reader.topics if t.lstrip('/') == MARKER_TOPIC]
    for message in reader.messages(topics) if topics else ():
        mark = decode(message.type_name, message.data)
        stamp = mark['header']['stamp']
        stamp_ns = stamp['sec'] * 1_000_000_000 + stamp['nanosec']
        for status in mark['status']:
            yield status['message'], stamp_ns


def _described(path: str, name: str, settings: Settings, digest: str) -> dict[str, Any]:
    is_bag = Path(path).suffix != '.csv'
    notes = notes_in(BagReader(path)) if is_bag else []
    return {'path': name, 'sha256': digest,
            'ts_topic': settings.ts_topic if is_bag else None,
            'rs_topic': settings.rs_topic if is_bag else None,
            **({'notes': [note._asdict() for note in notes]} if notes else {})}


def sha256(path: str) -> str:
    """Return the SHA-256 of a file, or of the .mcap files of a folder in order of their names."""
    place = Path(path)
    digest = hashlib.sha256()
    for part in sorted(place.glob('*.mcap')) if place.is_dir() else [place]:
        with part.open('rb') as file:
            while block := file.read(1 << 20):
                digest.update(block)
    return digest.hexdigest()


def read_run_table(path: str) -> list[tuple[int, int, str]]:
    """
    Read a table of runs: ``start,stop[,source]``, ISO UTC or integer nanoseconds.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, or a row is wrong: file and line.

    """
    with open(path, newline='', encoding='utf-8') as file:
        rows = csv.DictReader(file)
        names = [name.strip() for name in rows.fieldnames or ()]
        if 'start' not in names or 'stop' not in names:
            raise ValueError(f'{path}: the header must be start,stop[,source], '
                             f'not {",".join(names) or "empty"}')
        rows.fieldnames = names
        table = []
        for row in rows:
            try:
                table.append((_stamp(row['start']), _stamp(row['stop']),
                              (row.get('source') or '').strip()))
            except ValueError as error:
                raise ValueError(f'{path}, line {rows.line_num}: {error}') from error
    return sorted(table)


def _stamp(text: str | None) -> int:
    text = (text or '').strip()
    if text.lstrip('-').isdigit():
        return int(text)
    try:
        moment = datetime.fromisoformat(text[:19].replace('Z', ''))
        fraction = text[19:].rstrip('Z').lstrip('.')
        ns = int((fraction or '0').ljust(9, '0')) if len(fraction) <= 9 else None
    except ValueError:
        ns = None
    if ns is None:
        raise ValueError(f'{text!r} is neither ISO UTC (2014-08-01T00:00:00.5Z) nor integer '
                         'nanoseconds')
    return int(moment.replace(tzinfo=timezone.utc).timestamp()) * 1_000_000_000 + ns
