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

"""The protocol as a browser shows it: whole, within its page, and without a request to anybody."""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import pytest

from heading_intercompare.report import write

pytestmark = [pytest.mark.slow, pytest.mark.process]

BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
QUIET = ('--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
         '--disable-background-networking', '--disable-component-update', '--disable-sync')
#: Puts what is measured into the title of the page, for `--dump-dom` to print.
PROBE = """<script>
const figures = [...document.querySelectorAll('figure svg')].map(svg =>
  svg.getBoundingClientRect());
document.title = JSON.stringify({
  figures: figures.map(box => [box.width, box.height]),
  overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  requests: performance.getEntriesByType('resource').map(entry => entry.name),
  sections: document.querySelectorAll('h2').length,
});
</script>"""

#: Gives a figure the focus, as a click does, and takes it away.
FOCUS = """<script>
const figure = document.querySelector('figure svg'), widths = [];
const measure = () => widths.push(figure.getBoundingClientRect().width);
measure(); figure.focus(); measure();
const overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
figure.blur(); measure();
document.title = JSON.stringify([...widths, overflow]);
</script>"""


@pytest.fixture(scope='module')
def browser():
    """Return a Chromium, or skip."""
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        pytest.skip('no Chromium is here: apt-get install chromium')
    return found


@pytest.fixture
def page(made, tmp_path):
    """Return the protocol of two runs with figures."""
    pytest.importorskip('jinja2')
    pytest.importorskip('matplotlib')
    path = tmp_path / 'protocol.html'
    verdict, sketches = made(2)
    write(verdict, path, sketches)
    return path


def run(browser, tmp_path, *arguments):
    """Run a browser without a window and with a profile of its own; return what it prints."""
    return subprocess.run([browser, *QUIET, f'--user-data-dir={tmp_path / "profile"}',
                           *arguments], capture_output=True, text=True, timeout=120,
                          check=True).stdout


@pytest.mark.parametrize('width', [1280, 800, 420])
def test_the_protocol_fits_its_window_and_asks_nobody_for_anything(browser, page, tmp_path, width):
    text = page.read_text('utf-8')
    probed = tmp_path / 'probed.html'
    probed.write_text(text.replace('</body>', f'{PROBE}</body>'), 'utf-8')
    shown = run(browser, tmp_path, f'--window-size={width},1000', '--dump-dom', probed.as_uri())
    title = re.search(r'<title>(.*?)</title>', shown, re.DOTALL).group(1)
    found = json.loads(title.replace('&quot;', '"'))
    assert len(found['figures']) == 22
    assert all(w > 250 and h > 80 for w, h in found['figures'])
    assert found['overflow'] <= 0 and found['requests'] == []
    assert found['sections'] >= 10


def test_a_figure_with_the_focus_is_enlarged_and_the_page_still_fits(browser, page, tmp_path):
    probed = tmp_path / 'probed.html'
    probed.write_text(page.read_text('utf-8').replace('</body>', f'{FOCUS}</body>'), 'utf-8')
    shown = run(browser, tmp_path, '--window-size=1280,1000', '--dump-dom', probed.as_uri())
    title = re.search(r'<title>(.*?)</title>', shown, re.DOTALL).group(1)
    before, enlarged, after, overflow = json.loads(title)
    assert enlarged == pytest.approx(2.5 * before, rel=0.05)
    assert after == before and overflow <= 0


def test_the_browser_has_nothing_to_complain_about(browser, page, tmp_path):
    done = subprocess.run(
        [browser, *QUIET, f'--user-data-dir={tmp_path / "profile"}', '--enable-logging=stderr',
         '--v=0', '--dump-dom', page.as_uri()], capture_output=True, text=True, timeout=120,
        check=True)
    assert 'CONSOLE' not in done.stderr


def test_the_protocol_prints(browser, page, tmp_path):
    target = tmp_path / 'protocol.pdf'
    run(browser, tmp_path, '--no-pdf-header-footer', f'--print-to-pdf={target}', page.as_uri())
    pages = len(re.findall(rb'/Type\s*/Page\b', target.read_bytes()))
    assert 3 <= pages <= 30
