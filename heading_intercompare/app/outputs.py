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

"""The files that an analysis writes: checks that they overwrite no input, and tables of pairs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
import math
import os
from pathlib import Path
from typing import Callable, Iterator, Sequence

from heading_intercompare.bags.csv.corrections_csv import CorrectionsCsvWriter
from heading_intercompare.bags.csv.ensembles_csv import EnsemblesCsvWriter
from heading_intercompare.bags.csv.pairs_account import (
    account_path,
    PairsAccount,
    write_account,
)
from heading_intercompare.bags.csv.pairs_csv import PairsCsvWriter
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.report import annexes_path, is_protocol


@dataclass(frozen=True, slots=True)
class Outputs:
    """
    The files to write; None for a file that is not wanted.

    Attributes
    ----------
    csv
        One row per pair.
    ensembles
        One row per ensemble of `ensemble_s` seconds.
    reports
        The protocols and verdicts, each in the form of its suffix.
    runs_csv
        One row per run.
    json
        The verdict or plan; '-' is standard output, not a file.
    plot
        A picture.
    page
        A page of HTML.
    annexes_apart
        Whether the annexes of each protocol are a file beside it.
    card
        The correction card, in the form of its suffix.
    corrections
        One row per ensemble: its correction, and that of `running_s` seconds.

    """

    csv: str | None = None
    ensembles: str | None = None
    reports: tuple[str, ...] = ()
    json: str | None = None
    ensemble_s: float = 120.0
    runs_csv: str | None = None
    plot: str | None = None
    page: str | None = None
    annexes_apart: bool = False
    card: str | None = None
    corrections: str | None = None
    running_s: float = 1800.0


def check_outputs(outputs: Outputs, inputs: Sequence[str], *, config: str | None = None,
                  runs: str | None = None) -> None:
    """
    Check that each output can be a file, and overwrites no file that is needed.

    Parameters
    ----------
    outputs
        The files that a command will write.
    inputs
        The inputs to judge.
    config, runs
        The parameter file and the table of runs.

    Raises
    ------
    ValueError
        If an output cannot; one line with the command-line option, the file, and what is wrong.

    """
    reserved = {Path(os.path.realpath(path)): f'the file of --{option}'
                for option, path in (('config', config), ('runs', runs)) if path}
    for input_path in map(Path, inputs):
        reserved[Path(os.path.realpath(input_path))] = 'an INPUT'
        for pattern in ('*.mcap*', 'metadata.yaml'):
            reserved |= {Path(os.path.realpath(file)): f'a file of {input_path}'
                         for file in input_path.glob(pattern)}
    beside = None if outputs.csv in (None, '', '-') else str(account_path(outputs.csv))
    annexes = [str(annexes_path(report)) for report in outputs.reports
               if outputs.annexes_apart and is_protocol(report)]
    for option, path in (('csv', outputs.csv), ('csv', beside), ('ensembles', outputs.ensembles),
                         ('corrections', outputs.corrections),
                         ('runs-csv', outputs.runs_csv), ('card', outputs.card),
                         *(('output', report) for report in outputs.reports),
                         *(('annexes-apart', annex) for annex in annexes),
                         ('json', outputs.json), ('plot', outputs.plot),
                         ('page', outputs.page)):
        if path is None or (option, path) == ('json', '-'):
            continue
        place = Path(os.path.realpath(path))
        fault = ('name a file' if path in ('', '-') else
                 f'that is {reserved[place]}; name another file' if place in reserved else
                 'is a folder; name a file' if place.is_dir() else
                 f'there is no folder {place.parent}' if not place.parent.is_dir() else None)
        if fault:
            raise ValueError(f'--{option} {path}: {fault}')
        reserved[place] = f'the file of --{option}'


_Writer = PairsCsvWriter | EnsemblesCsvWriter | CorrectionsCsvWriter


class _Table:
    """A table that opens with its first pairs, or empty at the end; an error leaves no table."""

    def __init__(self, path: str, open_file: Callable[[], _Writer]) -> None:
        self._path = path
        self._open_file = open_file
        self._file: _Writer | None = None
        self._account: PairsAccount | None = None

    def __enter__(self) -> '_Table':
        return self

    def __exit__(self, kind: type | None, *exception: object) -> None:
        if kind is not None:
            if self._file is not None:
                self._file.discard()
            return
        if self._file is None:
            self._file = self._open_file()
        self._file.close()
        if self._account is not None and isinstance(self._file, PairsCsvWriter) and (
                Path(self._path).is_file()):
            write_account(self._path, self._account, self._file.fingerprint)

    def add_account(self, account: PairsAccount | None) -> None:
        """Lay an account beside the table at the end, if it has pairs."""
        self._account = account

    def write(self, pairs: Pairs) -> None:
        """Append the rows of some pairs."""
        if self._file is None:
            self._file = self._open_file()
        self._file.write(pairs)


def open_tables(outputs: Outputs, settings: Settings) -> Iterator[_Table]:
    """Yield the requested tables; each takes the pairs."""
    center_deg = settings.wrap_center_deg
    if outputs.csv:
        yield _Table(outputs.csv, partial(
            PairsCsvWriter, outputs.csv, wrap_center_deg=center_deg))
    limit_deg = math.sqrt(Limits.of(settings.norms, settings.model).limit_deg2)
    if outputs.ensembles:
        yield _Table(outputs.ensembles, partial(
            EnsemblesCsvWriter, outputs.ensembles, outputs.ensemble_s, gap_s=settings.runs.gap_s,
            std_limit_deg=limit_deg, wrap_center_deg=center_deg))
    if outputs.corrections:
        yield _Table(outputs.corrections, partial(
            CorrectionsCsvWriter, outputs.corrections, outputs.ensemble_s,
            gap_s=settings.runs.gap_s, running_s=outputs.running_s, std_limit_deg=limit_deg,
            wrap_center_deg=center_deg))
