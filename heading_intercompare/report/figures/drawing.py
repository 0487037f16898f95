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

"""What a figure shows, before it is drawn; and a figure that is left out, with the reason."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable

import numpy as np

from heading_intercompare.core.records import Integers, Reals

__all__ = ['days', 'Drawing', 'LeftOut', 'LIMIT', 'MEAN', 'RANGE', 'SERIES', 'SIGMA', 'START',
           'TAKEN_OUT', 'TIGHTENED', 'UNIT']

_DAY_NS = 86_400 * 10 ** 9

#: Looks of lines. Each kind also has a dash or a width of its own, so that it needs no colour.
#: Orange is that of Okabe and Ito. All differ in lightness, and for the colour-blind.
SERIES: dict[str, Any] = {'color': '#1b4f8a', 'linewidth': 1.0}
MEAN: dict[str, Any] = {'color': '#000000', 'linewidth': 0.9, 'linestyle': (0, (1.0, 1.2))}
RANGE: dict[str, Any] = {'color': '#c3d3e6', 'linewidth': 0.8}
LIMIT: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2, 'linestyle': (0, (9.0, 4.0))}
TIGHTENED: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2, 'linestyle': (0, (2.0, 2.5))}
SIGMA: dict[str, Any] = {'color': '#000000', 'linewidth': 1.2,
                         'linestyle': (0, (9.0, 3.0, 2.0, 3.0))}
UNIT: dict[str, Any] = {'color': '#d55e00', 'linewidth': 1.4, 'linestyle': (0, (6.0, 2.0))}
TAKEN_OUT: dict[str, Any] = {'facecolor': 'none', 'edgecolor': '#767676', 'hatch': '////',
                             'linewidth': 0.0}
START: dict[str, Any] = {'color': '#767676', 'linewidth': 1.0, 'linestyle': (0, (1.0, 3.0))}


@dataclass(frozen=True, slots=True)
class Drawing:
    """
    A figure that can be drawn.

    Attributes
    ----------
    name : str
        Its name among the figures of a record, such as 'histogram'.
    title : str
        Says what, of which run, and of how many values; a screen reader reads it aloud.
    caption : str
        How to read it, in a sentence.
    x_label, y_label : str
        With the units.
    fill : callable
        Draws into given axes of matplotlib. Everything it labels gets a legend below them.
    is_time : bool
        Whether the x axis is time: days since 1970, from `days`.
    height_mm : float
        Height without the legend; the width is that of the text on A4.

    """

    name: str
    title: str
    caption: str
    x_label: str
    y_label: str
    fill: Callable[[Any], object]
    is_time: bool = False
    height_mm: float = 70.0


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A figure that cannot be drawn: its name, its title, and why."""

    name: str
    title: str
    reason: str


def days(stamp_ns: Integers | int) -> Reals:
    """Return stamps as days since 1970, the unit of a time axis; to a microsecond."""
    stamp = np.asarray(stamp_ns, np.int64)
    return stamp // _DAY_NS + (stamp % _DAY_NS) / _DAY_NS
