# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Bags of one trial: after a crash, `live` goes on in a new bag that names the one before it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Sequence

from .bag_reader import BagReader
from .provenance import CONTINUES, RECORD

__all__ = ['find_parts']


def find_parts(paths: Sequence[str]) -> dict[str, list[str]]:
    """
    Return which inputs go on with the trial of another input.

    Parameters
    ----------
    paths : sequence of str
        The inputs.

    Returns
    -------
    dict of str to list of str
        For the first bag of each trial of several bags, the others in their order.

    """
    bags = {Path(os.path.abspath(path)).name: path for path in paths}
    before = {}
    for path in paths:
        name = _read_continues(path) if len(paths) > 1 else None
        if name is not None and bags.get(name, path) != path:
            before[path] = bags[name]
    found: dict[str, list[str]] = {}
    for path in paths:
        if path not in before:
            chain = [path]
            while after := [one for one, earlier in before.items()
                            if earlier == chain[-1] and one not in chain]:
                chain.append(after[0])
            if len(chain) > 1:
                found[path] = chain[1:]
    return found


def _read_continues(path: str) -> str | None:
    """Return the name of the bag before this one; None if there is none, or no bag."""
    if Path(path).suffix == '.csv':
        return None
    try:
        return BagReader(path).metadata().get(RECORD, {}).get(CONTINUES)
    except (OSError, ValueError):
        return None
