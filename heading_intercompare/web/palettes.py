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

"""The palettes of the page after IEC 62288, and its style sheet and script."""

from __future__ import annotations

from importlib.resources import files
from typing import Mapping

#: By palette: ground, ink, faint ink, line, the band of the norm; the three tones of a verdict or
#: state; the three priorities of alerts.
PALETTES: Mapping[str, Mapping[str, str]] = {
    'day': {'ground': '#f7f8f9', 'ink': '#101418', 'faint': '#4a5460', 'line': '#b9c2cc',
            'band': '#dfe5ea', 'good': '#0b6b2e', 'doubt': '#8a4b00', 'bad': '#b00020',
            'alarm': '#d4001a', 'warning': '#f07800', 'caution': '#e8c400'},
    'dusk': {'ground': '#14181d', 'ink': '#e6e9ed', 'faint': '#a4adb8', 'line': '#414b57',
             'band': '#252d36', 'good': '#5fd38a', 'doubt': '#ffcf7a', 'bad': '#ff8a80',
             'alarm': '#ff4a3a', 'warning': '#ff9a2e', 'caution': '#ffe04a'},
    'night': {'ground': '#000000', 'ink': '#d9503f', 'faint': '#d84434', 'line': '#4a0f0a',
              'band': '#260705', 'good': '#d9503f', 'doubt': '#f0a028', 'bad': '#ff5a48',
              'alarm': '#ff4a3a', 'warning': '#f0a028', 'caution': '#ffd755'},
}

#: Colours of sensors that the colour-blind tell apart; at night their shapes and dashes do.
_SENSORS: Mapping[str, tuple[str, ...]] = {
    'day': ('#0b5cad', '#00795c', '#8b3fa0', '#6b5400', '#3b4a9c', '#8c2a5a'),
    'dusk': ('#7db8ff', '#5fd3b0', '#d9a0f0', '#d8c48a', '#a9b4ff', '#f2a0c0'),
    'night': ('#d9503f',) * 6,
}


def script() -> str:
    """Return the script of the page."""
    return _read('page.js')


def style() -> str:
    """Return the style sheet of the page, with a block of colours per palette."""
    blocks = []
    for name, colours in PALETTES.items():
        place = f'html[data-palette={name}]'
        values = ' '.join(f'--{key}: {colour};' for key, colour in colours.items())
        blocks.append(f'{place} {{ {values} --hatch: {colours["doubt"]}; }}')
        blocks += [f'{place} .marker.s{number} {{ stroke: {colour}; }} '
                   f'{place} .marker.filled.s{number}, {place} .trace.s{number}:not(.line) '
                   f'{{ fill: {colour}; }} {place} .trace.line.s{number} {{ stroke: {colour}; }}'
                   for number, colour in enumerate(_SENSORS[name])]
    return '\n'.join([_read('page.css'), *blocks])


def _read(name: str) -> str:
    return files('heading_intercompare.web').joinpath('static', name).read_text('utf-8')
