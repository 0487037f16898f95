# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The verdict as a JSON file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Mapping, Sequence

from .series_sketch import SeriesSketch

__all__ = ['render', 'write']


def render(verdict: Mapping[str, Any]) -> str:
    """Return the verdict as JSON text; a figure that is not finite is refused."""
    return json.dumps(verdict, indent=1, ensure_ascii=False, allow_nan=False) + '\n'


def write(verdict: Mapping[str, Any], path: str | Path,
          sketches: Sequence[SeriesSketch] = ()) -> None:
    """Write the verdict; JSON holds no figures to look at, so sketches have no place in it."""
    # The name of a file may have bytes that are no UTF-8.
    Path(path).write_text(render(verdict), 'utf-8', 'backslashreplace')
