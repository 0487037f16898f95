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

"""The runs of histories as Parquet: each column with its type, its unit and what it is."""

from __future__ import annotations

from dataclasses import fields
import json
from types import NoneType
from typing import Any, get_args, get_origin, get_type_hints, Mapping, Sequence

import pyarrow
from pyarrow import parquet

from heading_intercompare.core.declared_figures import find_unit, list_figures
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Software
from heading_intercompare.logbook.history import History, Point
from heading_intercompare.logbook.row_chain import ChainHead
from heading_intercompare.logbook.run_row import RunRow
from heading_intercompare.replaced_file import ReplacedFile

from .history_table import LIMITS

_TYPES = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}


def write_parquet(histories: Sequence[History], path: str, since_ns: int | None,
                  heads: Mapping[str, ChainHead | None]) -> None:
    """
    Write a row per run with its limits; see `history_table.write_table`.

    Stamps are timestamps in UTC, and several figures a list. The metadata of a column are its
    unit, and what it is, where the verdict says so; those of the file are the program and the
    newest entry of the chain of each logbook.
    """
    points = [point for history in histories for point in history.list_since(since_ns)]
    columns = _list_columns(points)
    schema = pyarrow.schema([field for field, _ in columns], {
        'software': Software().version,
        'chains': json.dumps({book: head and head._asdict() for book, head in heads.items()})})
    table = pyarrow.table([pyarrow.array(cells, field.type) for field, cells in columns], schema)
    with ReplacedFile(path) as file:
        parquet.write_table(table, file)


def _list_columns(points: Sequence[Point]) -> list[tuple[pyarrow.Field, list[Any]]]:
    """Return the columns of the table with their cells."""
    hints, figures = get_type_hints(RunRow), list_figures(RunVerdict)
    words_of = {column.name: figures[column.metadata['key']].words for column in fields(RunRow)
                if column.metadata.get('key') in figures}
    limits = get_type_hints(Point)
    return [*((_declare(name, hints[name], words_of.get(name, '')),
               [getattr(point.row, name) for point in points]) for name in RunRow.columns()),
            *((_declare(name, limits[name], 'limit of the chart'),
               [getattr(point, name) for point in points]) for name in LIMITS),
            (_declare('outside', str, 'figures outside their limits'),
             [' '.join(point.outside) for point in points])]


def _declare(name: str, hint: Any, words: str) -> pyarrow.Field:
    """Return a column with its type, its unit and what it is."""
    kinds = [hint] if get_origin(hint) is tuple else [*get_args(hint)] or [hint]
    kind = pyarrow.timestamp('ns', tz='UTC') if name.endswith('_ns') else _find_type(kinds[0])
    metadata = {'unit': find_unit(name, hint), 'description': words}
    return pyarrow.field(name, kind, nullable=NoneType in kinds,
                         metadata={key: text for key, text in metadata.items() if text})


def _find_type(kind: Any) -> pyarrow.DataType:
    """Return the type of a plain type, or of a tuple of one."""
    return (pyarrow.list_(_find_type(get_args(kind)[0])) if get_origin(kind) is tuple
            else _TYPES[kind])
