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

"""The designs of control charts on the disk: each takes seconds to simulate."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

import numpy as np

from heading_intercompare.replaced_file import replace_file


def find_place(code: bytes, arguments: tuple[float, ...]) -> Path | None:
    """
    Return the file of a design; None if the user has no folder for such files.

    Parameters
    ----------
    code
        The program that simulates it. Another program or another numpy has other files.
    arguments
        What is simulated.

    """
    cache = os.environ.get('XDG_CACHE_HOME') or os.path.expanduser('~/.cache')
    if not os.path.isabs(cache):
        return None
    name = hashlib.sha256(code + repr((np.__version__, *arguments)).encode()).hexdigest()
    return Path(cache, 'heading_intercompare', 'charts', f'{name}.json')


def read_design(place: Path | None) -> tuple[int, tuple[float, ...], float] | None:
    """Return step, factors and threshold to the bit as they were written; None if they cannot."""
    try:
        if place is None:
            return None
        step, factors, threshold = json.loads(place.read_text('ascii'))
        return int(step), tuple(map(float, factors)), float(threshold)
    except (OSError, ValueError, TypeError):
        return None


def write_design(place: Path | None, step: int, factors: tuple[float, ...],
                 threshold: float) -> None:
    """Write a design; where the disk does not take it, it is simulated the next time too."""
    if place is None:
        return
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        replace_file(place, json.dumps([step, factors, threshold]))
    except OSError:
        pass
