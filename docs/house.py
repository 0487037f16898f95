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

"""
Draw the house of docs/ARCHITECTURE.md: folders, their rooms, and the way of a datum through them.

Each folder stands above those it imports. The text of a box comes from the sources: names and
module counts from the tree, purposes from the docstrings of the rooms, and the numbered marks
from the ten lines of the page.
"""

from __future__ import annotations

import ast
from pathlib import Path
import re
import textwrap
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

import heading_intercompare

PACKAGE = Path(heading_intercompare.__file__).resolve().parent
DOCS = Path(__file__).resolve().parent

#: Storeys from the roof down: their folders, each with its share of the width.
STOREYS = (
    (('cli', 1.0),),
    (('app', 0.4), ('nodes', 0.6)),
    (('ahrs', 0.2), ('report', 0.11), ('logbook', 0.09), ('web', 0.1), ('journal', 0.09),
     ('readers', 0.41)),
    (('drivers', 0.3), ('bags', 0.7)),
    (('messages', 1.0),),
    (('core', 1.0),),
)
#: Heights of the storeys.
HEIGHTS = (1.4, 1.4, 2.0, 1.6, 0.85, 1.75)
#: Rooms of core in the order in which they build on each other.
CORE = ('units', 'time_rules', 'rows', 'statistics', 'raw_streams', 'pairing', 'timing',
        'decision', 'observations', 'runs', 'conditions', 'motion', 'diagnostics',
        'norm_tests', 'validity', 'sensor_conditions', 'record_conditions', 'verdict', 'alarms',
        'sensors')

WIDTH, GAP, PAD = 15.0, 0.18, 0.12
_FONT = {'svg.fonttype': 'none', 'svg.hashsalt': 'house', 'font.family': 'sans-serif'}


class Box(NamedTuple):
    """A rectangle by its lower left corner, in inches."""

    x: float
    y: float
    width: float
    height: float


def summarize(folder: Path) -> str:
    """Return the first sentence of the docstring of a folder."""
    text = ast.get_docstring(ast.parse((folder / '__init__.py').read_text('utf-8'))) or ''
    return ' '.join(text.partition('\n\n')[0].split()).rstrip('.').replace('`', '')


def count_modules(folder: Path) -> int:
    """Return the number of modules in a folder, not counting those of its rooms."""
    return sum(path.stem != '__init__' for path in folder.glob('*.py'))


def list_rooms(folder: Path) -> list[Path]:
    """Return the rooms of a folder in the order in which they are drawn."""
    rooms = [init.parent for init in sorted(folder.rglob('__init__.py')) if init.parent != folder]
    if folder.name == 'core':
        rooms.sort(key=lambda room: CORE.index(room.name))
    return rooms


def read_marks() -> dict[str, list[int]]:
    """Return the lines on the way of a datum that name each folder or room, as 'core/pairing'."""
    page = (DOCS / 'ARCHITECTURE.md').read_text('utf-8')
    way = page.partition('## The way of a datum')[2].partition('\n## ')[0]
    marks: dict[str, list[int]] = {}
    for number, line in re.findall(r'^(\d+)\. (.*)$', way, re.MULTILINE):
        for name in re.findall(r'`([a-z_/]+)`', line):
            place = PACKAGE / name
            room = place if place.is_dir() else place.parent
            key = room.relative_to(PACKAGE).as_posix()
            if int(number) not in marks.setdefault(key, []):
                marks[key].append(int(number))
    return marks


class _Drawing:
    """The figure, in units of an inch."""

    def __init__(self, height: float) -> None:
        self.figure = Figure(figsize=(WIDTH, height))
        self.axes = self.figure.add_axes((0, 0, 1, 1), xlim=(0, WIDTH), ylim=(0, height))
        self.axes.axis('off')
        self._marks = read_marks()

    def draw_box(self, box: Box, key: str, *, fill: str, size: float, title: str,
                 words: str, count: int, low: bool) -> None:
        """Draw a folder or room; its marks go below its text if `low`, else beside its name."""
        self.axes.add_patch(FancyBboxPatch(
            (box.x, box.y), box.width, box.height, boxstyle='round,pad=0,rounding_size=0.06',
            facecolor=fill, edgecolor='#27466e', linewidth=1.0))
        top, right = box.y + box.height, box.x + box.width
        self.axes.text(box.x + PAD, top - 0.10, title, size=size, va='top', weight='bold',
                       color='#111111')
        letters = max(8, int((box.width - 2 * PAD) / (0.0076 * size * 0.8)))
        self.axes.text(box.x + PAD, top - 0.10 - 0.021 * size, textwrap.fill(words, letters),
                       size=size * 0.78, va='top', color='#333333', linespacing=1.15)
        # In a folder with rooms only the first line is free.
        line = box.y + 0.16 if low else top - 0.19
        self.axes.text(box.x + PAD if low else right - PAD, line, f'{count} modules', size=6.5,
                       va='center', ha='left' if low else 'right', color='#555555')
        for place, number in enumerate(reversed(self._marks.get(key, ()))):
            x, y = right - 0.16 - (0.0 if low else 0.75) - 0.27 * place, line
            self.axes.add_patch(Circle((x, y), 0.115, facecolor='#27466e', edgecolor='none'))
            self.axes.text(x, y, str(number), size=7.5, color='white', ha='center',
                           va='center_baseline')

    def draw_folder(self, box: Box, folder: Path) -> None:
        """Draw a folder and its rooms side by side."""
        rooms = list_rooms(folder)
        self.draw_box(box, folder.name, fill='#eef3fa', size=12, title=folder.name,
                      words=summarize(folder), count=count_modules(folder), low=not rooms)
        if not rooms:
            return
        width = (box.width - PAD * (len(rooms) + 1)) / len(rooms)
        for place, room in enumerate(rooms):
            inner = Box(box.x + PAD + place * (width + PAD), box.y + PAD, width,
                        box.height - 0.66)
            key = room.relative_to(PACKAGE).as_posix()
            self.draw_box(inner, key, fill='white', size=9, title=room.name,
                          words=summarize(room), count=count_modules(room), low=True)


def draw(path: Path) -> None:
    """Write the picture as SVG; the same tree and page give the same bytes."""
    height = sum(HEIGHTS) + GAP * (len(HEIGHTS) + 1)
    with rc_context(_FONT):
        drawing = _Drawing(height)
        top = height - GAP
        for storey, tall in zip(STOREYS, HEIGHTS):
            x, room_for = GAP, WIDTH - GAP * (len(storey) + 1)
            for name, share in storey:
                width = share * room_for
                drawing.draw_folder(Box(x, top - tall, width, tall), PACKAGE / name)
                x += width + GAP
            top -= tall + GAP
        drawing.figure.savefig(path, format='svg', metadata={'Date': None, 'Creator': None})


if __name__ == '__main__':
    draw(DOCS / 'house.svg')
    print('wrote docs/house.svg')
