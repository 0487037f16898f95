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

"""The figures of what was read: headings, their difference, gaps, and what gave no pair."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from heading_intercompare.core.angles import wrap360
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.records import Headings, Integers, Pairs, Reals
from heading_intercompare.core.settings import SILENCE_STEPS
from heading_intercompare.report.formatting import number
from heading_intercompare.report.sketching.bins import Envelope

from .drawing import days, Drawing, pad, RANGE, SERIES

_UTC = 'time UTC'
_LOOKS: tuple[dict[str, Any], ...] = (
    {'color': '#000000', 'linewidth': 0.9, 'linestyle': (0, (3.0, 1.5)), 'zorder': 3},
    {**SERIES, 'linewidth': 2.6, 'alpha': 0.55})
_HATCHES = '////', '\\\\\\\\'
_HEIGHT_MM, _ROW_MM, _FRAME_MM = 60.0, 6.0, 26.0
#: The longest gaps that are drawn; all are counted.
_MOST_GAPS = 200


def _as_text(name: str) -> str:
    """Return a name that matplotlib shows as it is: no formula, and not left out of a legend."""
    # A name with an underscore first would have no legend.
    return '\u200b' * name.startswith('_') + name.replace('$', r'\$')


class _Trace:
    """Values against time in bins, and where nothing was read."""

    def __init__(self, stamp_ns: Integers, value_deg: Reals) -> None:
        order = np.argsort(stamp_ns, kind='stable')
        self.stamp_ns, envelope = stamp_ns[order], Envelope()
        envelope.update(self.stamp_ns, value_deg[order])
        bins, at = envelope.bins, np.flatnonzero(envelope.bins.n)
        self.width_s = envelope.width_ns / 1e9
        self.days = days((envelope.start_ns or 0) + at * envelope.width_ns
                         + envelope.width_ns // 2)
        self.mean_deg, self.low_deg, self.up_deg = (
            column[at] for column in (bins.mean_deg, bins.low_deg, bins.up_deg))
        steps_ns = np.diff(self.stamp_ns)
        usual_ns = np.median(steps_ns[steps_ns > 0]) if np.any(steps_ns > 0) else 0
        self._gaps = np.flatnonzero(steps_ns > SILENCE_STEPS * usual_ns)
        self.gap_s = float(np.sum(steps_ns[self._gaps])) / 1e9
        self.n_gaps = len(self._gaps)
        limit_ns = max(2.0 * envelope.width_ns, SILENCE_STEPS * usual_ns)
        self._cuts = np.flatnonzero(np.diff(at) * envelope.width_ns > limit_ns) + 1

    def plot(self, axes: Any, value_deg: Reals, look: Mapping[str, Any], label: str) -> None:
        """Draw a line that breaks at gaps and where a heading passes through north."""
        cuts = np.union1d(np.flatnonzero(np.abs(np.diff(value_deg)) > 180.0) + 1, self._cuts)
        axes.plot(np.insert(self.days, cuts, np.nan), np.insert(value_deg, cuts, np.nan),
                  **look, label=f'{label}, mean in each {number(self.width_s)} s')

    def fill(self, axes: Any, label: str) -> None:
        """Draw the range of the values in each bin."""
        days_of, low, up = (np.insert(column, self._cuts, np.nan)
                            for column in (self.days, self.low_deg, self.up_deg))
        axes.fill_between(days_of, low, up, **RANGE, label=label)

    def mark_gaps(self, axes: Any, row: int, n_rows: int, name: str) -> None:
        """Hatch the longest gaps, each stream in a strip of its own."""
        lengths_ns = self.stamp_ns[self._gaps + 1] - self.stamp_ns[self._gaps]
        longest = self._gaps[np.argsort(lengths_ns)[-_MOST_GAPS:]]
        for k, gap in enumerate(longest):
            axes.axvspan(days(self.stamp_ns[gap]), days(self.stamp_ns[gap + 1]), row / n_rows,
                         (row + 1) / n_rows, facecolor='none', edgecolor='#767676',
                         hatch=_HATCHES[row], linewidth=0.0, label=None if k else
                         f'{name}: {self.n_gaps} gap{"s" * (self.n_gaps > 1)}, '
                         f'{number(self.gap_s)} s')


def draw_readings(streams: Mapping[str, Headings], pairs: Pairs) -> list[Drawing]:
    """
    Return the figures of the headings, and of their difference if there are pairs.

    Parameters
    ----------
    streams
        One or two, by name: that of the TS first.
    pairs
        Their pairs.

    """
    traces = {}
    streams = {_as_text(name): headings for name, headings in streams.items()}
    for name, headings in streams.items():
        readings = headings[np.isfinite(headings.heading_deg) & (headings.stamp_ns > 0)]
        traces[name] = _Trace(readings.stamp_ns, np.unwrap(readings.heading_deg, period=360.0))

    def fill_headings(axes: Any) -> None:
        for row, (name, trace) in enumerate(traces.items()):
            trace.plot(axes, wrap360(trace.mean_deg), _LOOKS[row], name)
            trace.mark_gaps(axes, row, len(traces), name)
        axes.set_ylim(0.0, 360.0)
        axes.set_yticks(range(0, 361, 90))

    counts = ', '.join(f'{len(headings)} of {name}' for name, headings in streams.items())
    drawings = [Drawing(name='read', title=f'headings as read: {counts}', caption='',
                        x_label=_UTC, y_label='heading [deg]', fill=fill_headings, is_time=True,
                        height_mm=_HEIGHT_MM)]
    differences = subtract(pairs)
    finite = np.isfinite(differences.x_deg)
    if np.any(finite):
        trace = _Trace(differences.stamp_ns[finite], differences.x_deg[finite])

        def fill_difference(axes: Any) -> None:
            trace.fill(axes, f'range in each {number(trace.width_s)} s')
            trace.plot(axes, trace.mean_deg, SERIES, 'difference')
            axes.set_ylim(*pad(float(trace.low_deg.min()), float(trace.up_deg.max())))

        drawings.append(Drawing(
            name='difference', title=f'{" - ".join(streams)}: n = {int(np.sum(finite))}',
            caption='', x_label=_UTC, y_label='difference [deg]', fill=fill_difference,
            is_time=True, height_mm=_HEIGHT_MM))
    return drawings


def draw_counts(counts: Mapping[str, int]) -> list[Drawing]:
    """Return the figure of what gave no pair, by reason; no figure if there is nothing."""
    rows: Sequence[tuple[str, int]] = sorted(counts.items(), reverse=True)
    if not rows:
        return []

    def fill(axes: Any) -> None:
        places = range(len(rows))
        axes.barh(places, [n for _, n in rows], color=SERIES['color'], height=0.4)
        axes.set_yticks(places, [f'{n} ' for _, n in rows])
        for place, (reason, _) in zip(places, rows):
            axes.text(0.01, place + 0.4, _as_text(reason), transform=axes.get_yaxis_transform(),
                      fontsize=6.5, va='center')
        axes.set_ylim(-0.4, len(rows) - 0.2)

    return [Drawing(name='rejected', title=f'not taken: {sum(n for _, n in rows)}', caption='',
                    x_label='readings or lines', y_label='count', fill=fill,
                    height_mm=_FRAME_MM + _ROW_MM * len(rows))]
