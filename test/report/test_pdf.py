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

"""The protocol as PDF: pages of A4 with numbers, made from the HTML without a network."""

from __future__ import annotations

from dataclasses import replace
import logging
from pathlib import Path

import pytest

from heading_intercompare.core.verdict.verdict_document import Input, OperatorNote
from heading_intercompare.report import write

pytest.importorskip('jinja2')
pytest.importorskip('matplotlib')
try:
    import weasyprint
except (ImportError, OSError) as error:
    pytest.skip(f'WeasyPrint or Pango is not here: {error}', allow_module_level=True)

from heading_intercompare.report import html, pdf  # noqa: E402

pytestmark = pytest.mark.slow


def text_of(box):
    """Return the text of a box of WeasyPrint and of those in it."""
    return getattr(box, 'text', '') + ' '.join(
        text_of(child) for child in getattr(box, 'children', ()))


def test_write_makes_a_pdf_by_the_suffix(made, tmp_path):
    path = tmp_path / 'r.PDF'
    write(*made(1)[:1], path)
    data = path.read_bytes()
    assert data.startswith(b'%PDF-') and data.rstrip().endswith(b'%%EOF')


def test_each_page_is_a4_and_carries_the_trial_the_verdict_and_its_number(made):
    verdict, sketches = made(1, trial__ship='MV "Exämple" \\ <1>', trial__ts_serial='12-3')
    document = weasyprint.HTML(string=html.render(verdict, sketches)).render()
    pages = document.pages
    assert 5 <= len(pages) <= 20
    number = html.verdict_id(verdict)
    for at, page in enumerate(pages, 1):
        assert (page.width, page.height) == pytest.approx((793.7, 1122.5), abs=0.1)
        text = ' '.join(text_of(page._page_box).split())
        assert f'page {at} of {len(pages)}' in text
        assert 'MV "Exämple" \\ <1>, no. 12-3' in text and f'verdict {number}' in text


@pytest.mark.parametrize('runs, settings', [
    (0, {}), (1, {}), (7, {'campaign__rule': 'sensor'})])
def test_with_the_annexes_apart_it_has_at_most_eight_pages_and_nothing_is_lost(
        made, tmp_path, runs, settings):
    verdict, sketches = made(runs, **settings)
    notes = tuple(OperatorNote(at * 10 ** 9, f'note {at}.') for at in range(30))
    inputs = [Input(f'bag{at}.mcap', 'a' * 64, 'ts', 'rs', notes) for at in range(12)]
    verdict = replace(verdict, inputs=inputs, runs=[
        replace(run, warnings=['a warning of many words ' * 8] * 3) for run in verdict.runs])
    main, annexes = tmp_path / 'p.pdf', tmp_path / 'p-annexes.pdf'
    shown = {}
    for place, page in html.compose_files(verdict, main, sketches[:2], print, False, annexes):
        pages = weasyprint.HTML(string=page).render().pages
        shown[place] = [' '.join(text_of(page._page_box).split()) for page in pages]
    assert 3 <= len(shown[main]) <= 8
    protocol, rest = ' '.join(shown[main]), ' '.join(shown[annexes])
    assert 'p-annexes.pdf' in protocol and 'the protocol is p.pdf' in rest
    number = html.verdict_id(verdict)
    assert all(f'verdict {number}' in page for pages in shown.values() for page in pages)
    assert f'End of the annexes to the protocol of the verdict {number}' in shown[annexes][-1]
    assert '352 more: see the annexes' in protocol and rest.count('note 29.') == 12
    assert 'bag11.mcap' in rest and 'Annex A. Figures' in rest and 'approved by' not in rest
    for run in verdict.runs:
        assert f'Budget of run {run.run}' in protocol + rest
    assert protocol.count('Budget of run') == min(runs, 1)


@pytest.mark.parametrize('runs', [0, 1, 3, 12])
def test_the_first_page_alone_can_be_signed(made, runs):
    verdict = replace(made(runs)[0], headline='a headline of many words ' * 20)
    protocol, _ = html.compose_files(verdict, 'p.pdf', (), print, False, Path('a.pdf'))
    pages = weasyprint.HTML(string=protocol[1]).render().pages
    first, *rest = (' '.join(text_of(page._page_box).split()) for page in pages)
    for words in ('date of issue', 'measured by: name, date', 'approved by: name, date',
                  f'hold for all pages that name the verdict {html.verdict_id(verdict)}'):
        assert words in first
    assert not any('approved by' in page for page in rest)
    assert 'at most 0.' in first and rest[-1].count('End of the protocol of the verdict') == 1


def test_the_first_page_holds_the_verdict_its_facts_and_its_figure(made):
    verdict, sketches = made(3)
    first, second = (' '.join(text_of(page._page_box).split()) for page in weasyprint.HTML(
        string=html.render(verdict, sketches)).render().pages[:2])
    for words in ('INDETERMINATE', 'rests on', 'covers', 'validity', 'why', 'measure 10 min'):
        assert words in first
    assert 'Contents' not in first and 'Contents' in second


def test_it_says_how_much_of_the_pages_is_laid_out(made, tmp_path):
    """A terminal shows the time left from that."""
    told = []
    verdict, sketches = made(1)
    write(verdict, tmp_path / 'r.pdf', sketches, told.append)
    assert [text for text in told if 'figures' in text][-1] == '12 of 12 figures drawn'
    shares = [int(text.partition('%')[0]) for text in told if '%' in text]
    assert shares == sorted(shares) and len(set(shares)) > 8 and 75 <= shares[-1] <= 100
    assert logging.getLogger('weasyprint.progress').handlers == []


def test_nothing_is_fetched():
    with pytest.raises(ValueError, match='needs nothing from elsewhere'):
        pdf._refuse('http://example.com/a.png')
