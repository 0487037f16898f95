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

"""The first page has the id of the verdict as a QR code, or the id alone without segno."""

import re
import sys

import pytest

from heading_intercompare.report.contents.identification import verdict_id
from heading_intercompare.report.contents.verdict_code import draw_code

segno = pytest.importorskip('segno')


def dark_modules(svg):
    """Return the dark squares of a code of segno as (row, column), read from its one path."""
    squares, row, column = set(), 0, 0
    for command, numbers in re.findall(r'([Mmh])([-\d. ]+)', re.search(r' d="([^"]+)"', svg)[1]):
        steps = [float(number) for number in re.findall(r'-?[\d.]+', numbers)]
        if command == 'h':
            squares |= {(row, column + at) for at in range(int(steps[0]))}
            column += int(steps[0])
        else:
            right, down = steps
            column, row = ((int(right), int(down)) if command == 'M'
                           else (column + int(right), row + int(down)))
    return squares


@pytest.mark.parametrize('text', ['0' * 32, '9f86d081884c7d659a2feaa0c55ad015'])
def test_the_code_holds_the_id_with_a_quiet_zone_of_four_modules(text):
    code = draw_code(text)
    modules = segno.make(text, error='m').matrix
    expected = {(row + 4, column + 4) for row, line in enumerate(modules)
                for column, dark in enumerate(line) if dark}
    assert dark_modules(code) == expected


@pytest.mark.parametrize('installed', [True, False])
def test_the_first_page_has_the_code_once_where_segno_is_installed(made, installed, monkeypatch):
    html = pytest.importorskip('heading_intercompare.report.html')
    verdict = made(1)[0]
    if not installed:
        monkeypatch.setitem(sys.modules, 'segno', None)
    page = html.render(verdict)
    assert page.count('aria-label="QR code of the verdict id"') == installed
    assert f'name the verdict {verdict_id(verdict)}' in page
