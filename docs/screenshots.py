# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Take the pictures of the live page in the docs, from the demo as it runs.

It needs the extras `web` and `test`, ROS, and Chromium. Run it after a change of the page:
``python docs/screenshots.py``.
"""

from __future__ import annotations

from pathlib import Path
import re
import shutil
import subprocess
import sys
import tempfile
from typing import Iterator

from playwright.sync_api import sync_playwright

DOCS = Path(__file__).resolve().parent
BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
PICTURES = (('day', 1280, 800), ('night', 1280, 800), ('dusk', 768, 1024))
MOST_BYTES = 150_000
_SPEED, _LEAST_PAIRS = '30', 4000


def serve(folder: str) -> Iterator[str]:
    """Run the demo; yield the address of its page, and end the demo afterwards."""
    demo = subprocess.Popen(
        [sys.executable, '-u', '-m', 'heading_intercompare', 'demo', '--web', '127.0.0.1:0',
         '--speed', _SPEED, '--out', str(Path(folder, 'demo'))], cwd=folder, text=True,
        stdout=subprocess.PIPE)
    assert demo.stdout is not None
    try:
        for line in demo.stdout:
            if found := re.match(r'page: (\S+)', line):
                yield found[1]
                return
        raise SystemExit('screenshots: error: the demo served no page; it said why above')
    finally:
        demo.terminate()
        demo.wait(60.0)


def take() -> None:
    """Take all pictures while the demo runs."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit('screenshots: error: no Chromium is here: apt-get install chromium')
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as play:
        for url in serve(folder):
            made = play.chromium.launch(executable_path=browser, args=['--no-sandbox'])
            page = made.new_page(viewport={'width': 1280, 'height': 800})
            page.goto(url)
            page.wait_for_function(
                'least => parseInt((document.querySelector(".k-ledger")?.textContent ?? "")'
                '.replaceAll(",", "")) > least', arg=_LEAST_PAIRS, timeout=60_000)
            for name, width, height in PICTURES:
                page.set_viewport_size({'width': width, 'height': height})
                page.click(f'.k-{name}')
                page.wait_for_function(f'document.documentElement.dataset.palette === "{name}"')
                path = DOCS / f'live_page_{name}.png'
                page.screenshot(path=path)
                size = path.stat().st_size
                print(f'wrote docs/{path.name}, {size} bytes')
                if size > MOST_BYTES:
                    raise SystemExit(f'screenshots: error: {path.name} has more than '
                                     f'{MOST_BYTES} bytes')
            made.close()


if __name__ == '__main__':
    take()
