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

"""Graphs on one page do not disturb each other, and are the same bytes each time."""

from __future__ import annotations

import os
from pathlib import Path
import subprocess
import sys
from xml.etree import ElementTree

import pytest

pytest.importorskip('matplotlib')

import matplotlib  # noqa: E402

from heading_intercompare.report.figures import style  # noqa: E402

SVG, XLINK = '{http://www.w3.org/2000/svg}', '{http://www.w3.org/1999/xlink}'


def curve(axes):
    """Draw a line with a legend, some dots, and a line that is cut at the frame."""
    axes.plot([0.0, 1.0], [0.0, -2.0], 'o-', label='a < b & "c"')
    axes.axhline(-1.0, linestyle=(0, (9.0, 4.0)), label='limit')
    axes.set_ylim(-1.5, 0.0)


def drawn(name='one', **changes):
    """Return a graph."""
    return style.draw(curve, **{'name': name, 'title': 'Run 1: x < y, n = 2',
                                'x_label': 'time [s]', 'y_label': 'x [deg]', **changes})


def words(svg):
    """Return the words in a graph."""
    return [element.text for element in ElementTree.fromstring(svg).iter(f'{SVG}text')]


def test_words_are_text_and_said_as_they_are():
    shown = words(drawn())
    assert {'time [s]', 'x [deg]', 'a < b & "c"', 'limit', 'Run 1: x < y, n = 2'} <= {*shown}
    assert '-1.0' in shown, 'minus is the sign of the page'


def test_a_screen_reader_finds_the_title_of_a_graph():
    root = ElementTree.fromstring(drawn())
    first = next(iter(root))
    assert (first.tag, first.text) == (f'{SVG}title', 'Run 1: x < y, n = 2')
    assert root.get('role') == 'img' and root.get('aria-labelledby') == first.get('id')
    assert root.get('tabindex') == '0'


def ids(svg):
    """Return all ids, and all ids that are referred to."""
    elements = [*ElementTree.fromstring(svg).iter()]
    used = {element.get(f'{XLINK}href')[1:] for element in elements if element.get(f'{XLINK}href')}
    used |= {value[5:-1] for element in elements for value in element.attrib.values()
             if value.startswith('url(#')}
    return [element.get('id') for element in elements if element.get('id')], used


def test_graphs_share_no_id_and_refer_to_their_own():
    one, used = ids(drawn('one'))
    two, _ = ids(drawn('two'))
    assert len({*one, *two}) == len(one) + len(two)
    assert len(used) >= 3 and used <= {*one}


def test_a_graph_brings_no_rule_and_no_link_for_the_page():
    svg = drawn()
    root = ElementTree.fromstring(svg)
    assert {e.tag.removeprefix(SVG) for e in root.iter()} <= {
        'svg', 'title', 'defs', 'g', 'path', 'use', 'text', 'clipPath', 'rect'}
    assert svg.count('http') == 2, 'the two namespaces'
    assert all(element.get(f'{XLINK}href', '#').startswith('#') for element in root.iter())
    assert 'DejaVu' not in svg and 'Helvetica, Arial, sans-serif' in svg


def elsewhere(code):
    """Return the output of another process, which has other string hashes and another date."""
    head = f'import sys; sys.path[:0] = {[str(Path(__file__).parent), *sys.path]}; '
    done = subprocess.run([sys.executable, '-c', f'{head}import test_style; {code}'], check=True,
                          text=True, timeout=120, stdout=subprocess.PIPE,
                          env={**os.environ, 'SOURCE_DATE_EPOCH': '1', 'PYTHONHASHSEED': '7'})
    return done.stdout


@pytest.mark.slow
def test_the_same_graph_has_the_same_bytes_in_any_process():
    assert elsewhere('sys.stdout.write(test_style.drawn())') == drawn() == drawn()


@pytest.mark.slow
def test_the_state_of_pyplot_is_not_touched():
    assert elsewhere('test_style.drawn(); print("matplotlib.pyplot" in sys.modules)') == 'False\n'


def test_what_the_user_has_set_for_plots_is_not_ours_and_stays():
    plain = drawn()
    with matplotlib.rc_context({'font.size': 40.0, 'axes.grid': False, 'lines.linewidth': 9.0}):
        before = dict(matplotlib.rcParams)
        assert drawn() == plain
        assert dict(matplotlib.rcParams) == before


@pytest.mark.slow
def test_each_two_words_of_the_legend_take_a_row():
    def fill(count):
        return lambda axes: [axes.plot([0, 1], [0, 1], label=f'line {k}') for k in range(count)]

    heights = [float(ElementTree.fromstring(style.draw(
        fill(count), name='x', title='', x_label='', y_label='')).get('height')[:-2])
        for count in range(5)]
    assert heights[0] < heights[1] == heights[2] < heights[3] == heights[4]


def test_lines_differ_without_colour():
    """Lightness by the weights of sRGB, 0 to 255."""
    lightness = sorted(
        sum(weight * int(color[at:at + 2], 16) for weight, at in zip(
            (0.2126, 0.7152, 0.0722), (1, 3, 5)))
        for color in (style.INK, style.ACCENT, style.GREY, style.SHADE))
    assert min(up - low for low, up in zip(lightness, lightness[1:])) > 40.0
