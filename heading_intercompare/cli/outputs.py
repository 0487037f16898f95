# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The files that ``analyze`` writes: that they harm no other, and the tables of pairs."""

from __future__ import annotations

import argparse
from contextlib import contextmanager
import math
from pathlib import Path
from typing import Callable, Iterator

from heading_intercompare.bags.csv.ensembles_csv import EnsemblesCsvWriter
from heading_intercompare.bags.csv.pairs_csv import PairsCsvWriter
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings

__all__ = ['check_outputs', 'name_file', 'open_tables']


def check_outputs(arguments: argparse.Namespace) -> None:
    """Refuse to write where no file can be, or over one that is needed."""
    taken = {Path(path).resolve(): f'the file of --{option}' for option in ('config', 'runs')
             if (path := getattr(arguments, option))}
    for path in map(Path, arguments.inputs):
        taken[path.resolve()] = 'an INPUT'
        for pattern in ('*.mcap', 'metadata.yaml'):
            taken |= {file.resolve(): f'a file of {path}' for file in path.glob(pattern)}
    for option in ('csv', 'ensembles', 'report', 'json'):
        path = getattr(arguments, option)
        if path is None or (option, path) == ('json', '-'):
            continue
        place = Path(path).resolve()
        fault = ('name a file' if path in ('', '-') else
                 f'that is {taken[place]}; name another file' if place in taken else
                 'is a folder; name a file' if place.is_dir() else
                 f'there is no folder {place.parent}' if not place.parent.is_dir() else None)
        if fault:
            raise ValueError(f'--{option} {path}: {fault}')
        taken[place] = f'the file of --{option}'


@contextmanager
def name_file(path: str) -> Iterator[None]:
    """Have an error of writing name the file."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, path) from error


_Writer = PairsCsvWriter | EnsemblesCsvWriter


class _Table:
    """A table that is opened when the first pairs come, or at the end if none has failed."""

    def __init__(self, path: str, opened: Callable[[], _Writer]) -> None:
        self._path = path
        self._opened = opened
        self._file: _Writer | None = None

    def __enter__(self) -> '_Table':
        return self

    def __exit__(self, kind: type | None, *exception: object) -> None:
        with name_file(self._path):
            if self._file is None and kind is None:
                self._file = self._opened()
            if self._file is not None:
                self._file.close()

    def write(self, pairs: Pairs) -> None:
        """Append the rows of some pairs."""
        with name_file(self._path):
            if self._file is None:
                self._file = self._opened()
            self._file.write(pairs)


def open_tables(arguments: argparse.Namespace, settings: Settings) -> Iterator[_Table]:
    """Yield the tables asked for, each of which takes the pairs."""
    center_deg = settings.wrap_center_deg
    if arguments.csv:
        yield _Table(arguments.csv, lambda: PairsCsvWriter(
            arguments.csv, wrap_center_deg=center_deg))
    if arguments.ensembles:
        limit_deg2 = Limits.of(settings.norms, settings.model).limit_deg2
        yield _Table(arguments.ensembles, lambda: EnsemblesCsvWriter(
            arguments.ensembles, arguments.ensemble_s, gap_s=settings.runs.gap_s,
            std_limit_deg=math.sqrt(limit_deg2), wrap_center_deg=center_deg))
