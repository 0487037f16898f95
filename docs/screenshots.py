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
Take the pictures in the docs: the live page as the demo runs, a protocol, and differences.

It needs the extras `web`, `report` and `test`, ROS, and Chromium. Run it after a change of either:
``python docs/screenshots.py``, or with ``page``, ``faults`` or ``protocol`` for a part of them.
The differences need the folder with the real logs of the tutorial:
``python docs/screenshots.py differences FOLDER``.
"""

from __future__ import annotations

from concurrent.futures import Future
from pathlib import Path
import re
import shutil
import subprocess
import sys
import tempfile
from typing import Iterator
import warnings

from page_cases import make_cases, SEEN_S
from playwright.sync_api import Browser, Page, Playwright, sync_playwright

from heading_intercompare import analyze_bag, analyze_logs, Settings
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer

DOCS = Path(__file__).resolve().parent
BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
PICTURES = (('day', 1280, 800), ('night', 1280, 800), ('dusk', 768, 1024))
FAULTS = {'sound': ('day', 1280, 800), 'frozen': ('day', 1280, 800),
          'silent': ('dusk', 390, 844), 'turned': ('night', 1280, 800),
          'clock': ('dusk', 1024, 768), 'disk': ('day', 1920, 1080),
          'stopped': ('night', 390, 844), 'four': ('dusk', 1280, 800)}
MOST_BYTES = 150_000
_SPEED, _LEAST_PAIRS = '30', 4000
_TRIAL = ('norms.sigma_max_deg=0.3', 'norms.sigma_ref_max_deg=0.1', 'trial.ship=MV Example',
          'trial.place=German Bight', 'trial.ts_type=Gyro 7', 'trial.ts_serial=007-1234')


def serve(folder: str) -> Iterator[str]:
    """Run the demo; yield the address of its page, and end the demo afterwards."""
    demo = subprocess.Popen(
        [sys.executable, '-u', '-m', 'heading_intercompare', 'demo', '--web', '127.0.0.1:0',
         '--speed', _SPEED, '--out', str(Path(folder, 'demo'))], cwd=folder, text=True,
        stdout=subprocess.PIPE)
    assert demo.stdout is not None
    try:
        for line in demo.stdout:
            if match := re.match(r'page: (\S+)', line):
                yield match[1]
                return
        raise SystemExit('screenshots: error: the demo served no page; it said why above')
    finally:
        demo.terminate()
        demo.wait(60.0)


def keep(page: Page, name: str, where: str | None = None) -> None:
    """Write a picture of a page, or of the element that a selector names."""
    path = DOCS / f'{name}.png'
    if where is None:
        page.screenshot(path=path)
    else:
        page.locator(where).screenshot(path=path)
    size = path.stat().st_size
    print(f'wrote docs/{path.name}, {size} bytes')
    if size > MOST_BYTES:
        raise SystemExit(f'screenshots: error: {path.name} has more than {MOST_BYTES} bytes')


def open_browser(play: Playwright) -> Browser:
    """Start Chromium."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit('screenshots: error: no Chromium is here: apt-get install chromium')
    return play.chromium.launch(executable_path=browser, args=['--no-sandbox'])


def take_live_page() -> None:
    """Take the pictures of the live page while the demo runs."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        for url in serve(folder):
            browser = open_browser(play)
            page = browser.new_page(viewport={'width': 1280, 'height': 800})
            page.goto(url)
            page.wait_for_function(
                'least => parseInt((document.querySelector(".k-ledger")?.textContent ?? "")'
                '.replaceAll(",", "")) > least', arg=_LEAST_PAIRS, timeout=60_000)
            for name, width, height in PICTURES:
                page.set_viewport_size({'width': width, 'height': height})
                page.click(f'.k-{name}')
                page.wait_for_function(f'document.documentElement.dataset.palette === "{name}"')
                keep(page, f'live_page_{name}')
            browser.close()


def take_faults() -> None:
    """Take a picture of the live page for each fault of `page_cases`."""
    cases = make_cases()
    shown = [cases['sound']]
    # A process can serve one page.
    controls = Controls(lambda: (shown[0].view(SEEN_S), 0.0), lambda what, text: Future())
    server = PageServer(controls, port=0)
    with sync_playwright() as play:
        browser = open_browser(play)
        for name, bridge in cases.items():
            shown[0] = bridge
            palette, width, height = FAULTS[name]
            page = browser.new_page(viewport={'width': width, 'height': height})
            page.goto(server.url)
            page.wait_for_selector('.picture')
            page.add_style_tag(content='* { animation: none !important; }')
            page.evaluate(f'choosePalette("{palette}")')
            page.wait_for_timeout(1500.0)
            keep(page, f'page_{name}')
            page.close()
        browser.close()
    server.close()


def take_protocol() -> None:
    """Take the picture of the first page of a protocol, as it is printed."""
    program = [sys.executable, '-m', 'heading_intercompare']
    settings = [word for setting in _TRIAL for word in ('--set', setting)]
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        for words in (['simulate', '--scenario', 'demo', '-o', 'trial'],
                      ['report', 'trial', *settings, '-o', 'report.html']):
            subprocess.run([*program, *words], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        browser = open_browser(play)
        page = browser.new_page(viewport={'width': 794, 'height': 1123})
        page.emulate_media(media='print')
        page.goto(Path(folder, 'report.html').as_uri())
        keep(page, 'protocol_first_page', 'section.first')
        browser.close()


def draw_differences(logs: Path) -> None:
    """Draw the differences of the simulated trial and of the real logs of the tutorials."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter('ignore')
        trial = str(Path(folder, 'trial'))
        subprocess.run([sys.executable, '-m', 'heading_intercompare', 'simulate', '--scenario',
                        'demo', '-o', trial], check=True, stdout=subprocess.DEVNULL)
        verdicts = {
            'demo': analyze_bag(trial, Settings.of(sigma_max_deg=0.3, sigma_ref_max_deg=0.1)),
            'palmer': analyze_logs(
                logs / 'NBP1406_gyr1-2014-08-01', logs / 'NBP1406_s330-2014-08-01',
                Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, m_low=0.9))}
    for name, verdict in verdicts.items():
        verdict.plot('differences').savefig(DOCS / f'{name}_differences.png', dpi=120)


_PARTS = {'page': take_live_page, 'faults': take_faults, 'protocol': take_protocol}

if __name__ == '__main__':
    if sys.argv[1:2] == ['differences']:
        draw_differences(Path(sys.argv[2]))
    else:
        for part in sys.argv[1:] or _PARTS:
            _PARTS[part]()
