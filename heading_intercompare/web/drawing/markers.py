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

"""The shape of each sensor, and the symbols of alerts."""

from __future__ import annotations

#: Shapes that are told apart at a glance, in a box of 20 by 20.
_SHAPES = (
    '<path d="M10 2 18 17 2 17z"/>', '<circle cx="10" cy="10" r="7.5"/>',
    '<path d="M10 1 19 10 10 19 1 10z"/>', '<path d="M3 3h14v14H3z"/>',
    '<path d="M10 1 19 8 15.5 18.5h-11L1 8z"/>', '<path d="M8 2h4v6h6v4h-6v6H8v-6H2V8h6z"/>')

DASHES = ('none', '9 5', '2 4', '12 4 2 4', '5 3', '16 6')
"""Dash of the line of each sensor, in pixels."""

#: After IEC 62923: a triangle, a circle and a square; the letters are for the colour-blind, too.
_SYMBOLS = {'alarm': '<path d="M12 2 23 21 1 21z"/>',
            'warning': '<circle cx="12" cy="12" r="10"/>',
            'caution': '<path d="M2.5 2.5h19v19h-19z"/>'}
_MARK = '<path class="mark" d="M12 6.5v7.5M12 16.6v2.4"/>'
_TICK = '<path class="mark" d="M6.5 12.5l4 4 7-8"/>'


def draw_marker(number: int, reference: bool, crossed: bool) -> str:
    """
    Return the marker of a sensor as SVG.

    Parameters
    ----------
    number
        Which one of the sensors it is, from 0.
    reference
        The reference is filled, other sensors are open.
    crossed
        It is stale, or the vote names it as wrong.

    """
    shape = _SHAPES[number % len(_SHAPES)]
    cross = '<path class="cross" d="M1 1 19 19M19 1 1 19"/>' if crossed else ''
    return (f'<svg class="marker {"filled" if reference else "open"} s{number % len(_SHAPES)}" '
            f'viewBox="0 0 20 20" aria-hidden="true">{shape}{cross}</svg>')


def draw_symbol(priority: str, acknowledged: bool) -> str:
    """Return the symbol of an alert as SVG: with a tick if somebody has acknowledged it."""
    shape = _SYMBOLS.get(priority, _SYMBOLS['caution'])
    return (f'<svg class="symbol" viewBox="0 0 24 24" aria-hidden="true">{shape}'
            f'{_TICK if acknowledged else _MARK}</svg>')
