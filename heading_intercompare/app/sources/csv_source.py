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

"""
The verdict on a csv of pairs.

With the account that this package writes beside a csv, the verdict is that of the recording that
the pairs came from. Without one, the rows are all that is known.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
import os
from typing import Any, Callable, Iterator, Mapping, Protocol, Sequence

import numpy as np

from heading_intercompare.bags.csv.pairs_account import (
    account_path,
    motion_of_text,
    PairsAccount,
    PairsDigest,
    quality_of_text,
    read_account,
)
from heading_intercompare.bags.csv.pairs_csv import COLUMNS, PairsCsv
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.raw_streams.stamp_jumps import Decided, JumpFilter
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.units.angle_units import AngleWatch
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.readers.registry import (
    find_format,
    find_written,
    has_pairs as has_pairs_in_parquet,
)
from heading_intercompare.readers.stream_recording import StreamOptions, UNSTATED
from heading_intercompare.readers.written_files import is_of_pairs
from heading_intercompare.report import SegmentSketches

from .file_hash import hash_files
from .input_comparison import describe_two, Spans
from .judged_input import JudgedInput

_HEAD_BYTES = 1 << 12


class _Pairs(Protocol):
    """A table of pairs."""

    names: tuple[str, ...]
    ignored: tuple[str, ...]

    @property
    def cut(self) -> str:
        """Which line was left out because the file ends within it; empty if none."""

    def __iter__(self) -> Iterator[Pairs]:
        """Yield the pairs."""


def has_pairs(path: str, options: StreamOptions = UNSTATED) -> bool:
    """
    Tell whether a path is a table of pairs: csv, or Parquet with the headings of both sensors.

    A csv of the headings of one or several sensors, as stated, is none, a csv with any other
    header is.
    """
    if not os.path.isfile(path):
        return path.lower().endswith('.csv') and find_format(path, options) is None
    with open(path, 'rb') as file:
        head = file.read(_HEAD_BYTES)
    if not head.startswith(b'PAR1') and is_of_pairs(head):
        return True
    form = find_format(path, options)
    if form is None or form.extra != 'parquet':
        return (form is None and path.lower().endswith('.csv')
                and find_written(path) is None)
    return has_pairs_in_parquet(path)


def find_pairs_reader(path: str) -> Callable[[str], _Pairs]:
    """Return what reads a table of pairs."""
    form = find_format(path)
    if form is None or form.extra != 'parquet':
        return PairsCsv
    from heading_intercompare.readers.parquet import PairsParquet
    return PairsParquet


def judge_csv(path: str, name: str, settings: Settings,
              runs: Spans | None, takers: Sequence[Callable[[Pairs], None]],
              progress: Callable[[str], None] = lambda text: None,
              sketch: SegmentSketches | None = None) -> JudgedInput:
    """
    Judge the pairs of a csv file.

    Parameters
    ----------
    path
        The file; see `PairsCsv`.
    name
        Name of the file in the verdict.
    settings
        Settings with the norms.
    runs : sequence of (start_ns, stop_ns), optional
        Table of runs. Without one, that of the account decides, or its marks.
    takers
        Each is called with the pairs, chunk by chunk.
    progress
        Called with the progress in words.
    sketch
        Takes the pairs for the figures, and the motion of the ship if the account has it.

    Raises
    ------
    OSError
        If the file cannot be read.
    BagError
        If the file, or its account, is wrong.

    """
    # A pipe can be read only once.
    digest = hash_files([path] if os.path.isfile(path) else [])
    open_pairs = find_pairs_reader(path)
    account, problems = _find_account(path, digest, open_pairs, progress)
    table = account.table if account is not None and runs is None else runs
    compliance = Compliance(settings, source=name, table=table, progress=progress)
    if sketch is not None:
        takers = (*takers, partial(sketch.update, settings=settings))
    judging = _Judging(compliance, settings, takers, progress,
                       trusted=None if account is None else account.ledger)
    if account is not None:
        _take_from_account(account, compliance, table, sketch)
    rows = open_pairs(path)
    for pairs in rows:
        judging.take(pairs)
    judging.end()
    if why := judging.why_not_degrees:
        raise BagError(why, path)
    problems += [rows.cut] if rows.cut else []
    ledger, judged_account = judging.ledger, None
    if account is not None:
        problems += _compare_pairing(account.settings, settings.to_mapping())
        if _has_runs_of(account, table, compliance.cuts):
            ledger = account.ledger
            judged_account = replace(account, table=None if table is None else tuple(table))
        else:
            problems.append('its runs are not those of its account: what was rejected, lost or '
                            'without partner is unknown')
    described = _describe(name, digest, account)
    noted = (*_list_notes(rows, settings), *problems)
    if account is None and rows.names == COLUMNS and not problems:
        # This program wrote the csv.
        problems.append(f'{account_path(path).name} is not beside it: what was rejected, lost or '
                        'without partner is unknown')
    account_problems = () if account is None else account.inputs[0].ledger_problems or ()
    described = replace(described, ledger_problems=(*account_problems, *problems) or None)
    return describe_two(
        compliance.results(ledger), compliance.take_earlier(ledger), described, noted, ledger,
        settings, table=runs, account=judged_account, sketch=sketch)


def _take_from_account(account: PairsAccount, compliance: Compliance, table: Spans | None,
                       sketch: SegmentSketches | None) -> None:
    """Take from an account what belongs between the pairs."""
    for kind, stamp_ns in account.marks if table is None else ():
        compliance.mark(kind, stamp_ns)
    motion = motion_of_text(account.motion)
    compliance.take_motion(motion)
    for stream, quality in quality_of_text(account.quality).items():
        compliance.take_quality(stream, quality)
    if sketch is not None:
        sketch.take_motion(motion)


def _list_notes(rows: _Pairs, settings: Settings) -> Iterator[str]:
    """Yield what a person should know of a csv that is read to its end."""
    if settings.alignment.skew == 'apply':
        yield ('alignment.skew = apply: a csv of pairs has no readings to align; it is judged as '
               'it was paired')
    if rows.ignored:
        yield f'columns that are not read: {", ".join(rows.ignored)}'


def _find_account(path: str, digest: str, open_pairs: Callable[[str], _Pairs],
                  progress: Callable[[str], None],
                  ) -> tuple[PairsAccount | None, list[str]]:
    """Return the account of a csv of this hash, and why the one beside it does not count."""
    record = read_account(path)
    if record is None:
        return None, []
    account, of = record
    if digest != of.csv_sha256:
        progress('comparing the pairs with their account')
        pairs_digest = PairsDigest()
        for pairs in open_pairs(path):
            pairs_digest.update(pairs)
        if pairs_digest.hexdigest() != of.pairs_sha256:
            return None, [f'{account_path(path).name} belongs to other pairs, and does not count: '
                          'what was rejected, lost or without partner is unknown']
    return account, []


class _Judging:
    """Hands pairs to a judge and to the takers, and books each row as a reading of both."""

    def __init__(self, compliance: Compliance, settings: Settings,
                 takers: Sequence[Callable[[Pairs], None]], progress: Callable[[str], None],
                 *, trusted: Ledger | None) -> None:
        self.ledger = Ledger()
        self._compliance, self._takers, self._progress = compliance, takers, progress
        # The stamps of a recording were examined when its pairs were made.
        self._jump_s, self._segment = settings.pairing.jump_s, 0
        self._jumps = None if trusted is not None else self._make_filter()
        self._bounds = [] if trusted is None else np.cumsum(
            [ledger.paired for ledger in trusted.clock_segments]).tolist()[:-1]
        self._n = 0
        self._watches = {name: AngleWatch() for name in ('ts_deg', 'rs_deg')}

    def _make_filter(self) -> JumpFilter[Pairs]:
        return JumpFilter('ts', self._jump_s, Pairs.empty())

    def take(self, pairs: Pairs) -> None:
        before, self._n = self._n, self._n + len(pairs)
        for name, watch in self._watches.items():
            watch.update(pairs.stamp_ns, getattr(pairs, name))
        for stream in ('ts', 'rs'):
            self.ledger.receive(stream, pairs.stamp_ns)
        if self._jumps is None:
            rows = np.arange(before, self._n)
            self._judge(replace(pairs, segment=np.searchsorted(self._bounds, rows, 'right')))
        else:
            self._sift(self._jumps, pairs)
        self._progress(f'{self._n:,} pairs')

    def end(self) -> None:
        if self._jumps is not None:
            self._decide(self._jumps.end())
        self._end_runs()

    def _end_runs(self) -> None:
        """End the run in progress, and cut the ledger of the clock segment into its runs."""
        self._compliance.finish()
        for cut_ns in self._compliance.cuts.get(self._segment, ()):
            self.ledger.cut(cut_ns)

    def _sift(self, jumps: JumpFilter[Pairs], pairs: Pairs) -> None:
        """Judge the pairs whose stamps are decided; open a segment where a clock was set back."""
        rows: Pairs | None = pairs
        while rows is not None:
            decided = jumps.take(rows)
            self._decide(decided)
            rows = decided.after
            if decided.set_back is not None:
                for stream in ('ts', 'rs'):
                    # A row has one stamp for both sensors.
                    self.ledger.note_set_back(replace(decided.set_back, stream=stream))
                self._end_runs()
                self.ledger.open_clock_segment()
                self._segment += 1
                jumps = self._jumps = self._make_filter()

    @property
    def why_not_degrees(self) -> str:
        """Return which headings are in another unit, in words; empty if none."""
        return '; '.join(f'{name}: {watch.words}; give it in degrees'
                         for name, watch in self._watches.items() if watch.words)

    def _decide(self, decided: Decided[Pairs]) -> None:
        for reason, stamps in (('stamp_not_increasing', decided.late_ns),
                               ('jump', decided.jumped_ns)):
            for stream in ('ts', 'rs'):
                self.ledger.add(LedgerKey.of_rejected(stream, reason), stamps)
        pairs = decided.accepted
        self._judge(replace(pairs, segment=np.full(len(pairs), self._segment)))

    def _judge(self, pairs: Pairs) -> None:
        for key in (LedgerKey.PAIRED, LedgerKey.TS_PAIRED, LedgerKey.RS_USED):
            self.ledger.add(key, pairs.stamp_ns)
        self._compliance.update(pairs)
        for take in self._takers:
            take(pairs)


def _has_runs_of(account: PairsAccount, table: Sequence[tuple[int, int]] | None,
                 cuts: Mapping[int, Sequence[int]]) -> bool:
    """Tell whether the ledger of an account can be divided among runs with these cuts."""
    if (None if table is None else {*table}) != (
            None if account.table is None else {*account.table}):
        return False
    starts = {(segment.clock_segment or 0, segment.start_ns) for segment in account.segments}
    opened = [(number, cut_ns) for number, stamps in cuts.items() for cut_ns in stamps]
    return {*opened[1:]} <= starts


def _compare_pairing(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Return which settings of the pairing differ; the pairs remain as they were made."""
    names = [name for name in now if name.startswith('pairing.') or name == 'alignment.skew_s']
    differences = [f'{name} = {before[name]}, not {now[name]}' for name in names
                   if name in before and before[name] != now[name]]
    return [f'its pairs were made with {", ".join(differences)}'] if differences else []


def _describe(name: str, digest: str, account: PairsAccount | None) -> Input:
    if account is None:
        return Input(name, digest)
    ts = next((recording.ts_topic for recording in account.inputs if recording.ts_topic), None)
    rs = next((recording.rs_topic for recording in account.inputs if recording.rs_topic), None)
    return Input(
        path=name, sha256=digest, ts_topic=ts, rs_topic=rs, notes=account.inputs[0].notes,
        made_from={os.fspath(recording.path): recording.sha256 for recording in account.inputs})
