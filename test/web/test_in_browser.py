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

"""The live page in Chromium, on the running graph: live values, actions, restarts, palettes."""

from __future__ import annotations

import os
from pathlib import Path
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from checksums import with_checksum
from deadlines import DEADLINE_S
import pytest
from web.page_process import serve_page

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_notes
from heading_intercompare.web.guard import HEADERS

pytestmark = [pytest.mark.slow, pytest.mark.process]

ROOT = Path(__file__).resolve().parents[2]
BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
IN_CI = os.environ.get('CI', '').lower() not in ('', '0', 'false')
TOKEN = 'choose-your-own'


def need(module):
    """Import a module; without it skip, or fail if CI is set."""
    try:
        return pytest.importorskip(module)
    except pytest.skip.Exception:
        if IN_CI:
            pytest.fail(f'{module} is not installed')
        raise


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(type=kind) as found:
        found.bind(('127.0.0.1', 0))
        return found.getsockname()[1]


class Ship:
    """Sends the headings of both sensors by UDP, ten times a second, until it is closed."""

    def __init__(self):
        self.ports = [free_port(socket.SOCK_DGRAM) for _ in range(2)]
        self.silent, self._over = False, threading.Event()
        self._thread = threading.Thread(target=self._send)
        self._thread.start()

    def _send(self):
        with socket.socket(type=socket.SOCK_DGRAM) as out:
            heading_deg = 20.0
            while not self._over.wait(0.1):
                heading_deg = (heading_deg + 0.1) % 360.0
                for port, off_deg in zip(self.ports, (0.3, 0.0)):
                    if self.silent and port == self.ports[0]:
                        continue
                    text = f'HEHDT,{(heading_deg + off_deg) % 360.0:.2f},T'
                    line = f'{with_checksum(text)}\r\n'
                    out.sendto(line.encode(), ('127.0.0.1', port))

    def close(self):
        self._over.set()
        self._thread.join()


class Graph:
    """The command `live` with the page, as a process."""

    def __init__(self, folder, ship, host, port):
        self.url = f'http://127.0.0.1:{port}/'
        self.folder, self._web = folder, f'{host}:{port}'
        self._config = folder / 'live.yaml'
        sections = [f'{role}_driver: {{ros__parameters: {{source: "udp://127.0.0.1:{number}"}}}}'
                    for role, number in zip(('ts', 'rs'), ship.ports)]
        self._config.write_text('\n'.join([
            '/**: {ros__parameters: {norms: {sigma_max_deg: 0.2, sigma_ref_max_deg: 0.1}, '
            'pairing: {method: interpolate}}}',
            f'dashboard: {{ros__parameters: {{token_file: {folder / "tokens"}}}}}', *sections]))
        tokens = folder / 'tokens'
        tokens.touch(0o600)
        tokens.write_text(f'Mate {TOKEN}\n')
        self._process = None

    def start(self):
        self.said = self.folder / 'said.txt'
        with self.said.open('w') as out:
            self._process = subprocess.Popen(
                [sys.executable, '-m', 'heading_intercompare', 'live', '--config',
                 str(self._config), '--web', self._web, '--quiet'], cwd=self.folder, stdout=out,
                stderr=subprocess.STDOUT, env={**os.environ, 'PYTHONPATH': os.pathsep.join(
                    [str(ROOT), os.environ.get('PYTHONPATH', '')])})
        deadline_s = time.monotonic() + DEADLINE_S
        while 'page: ' not in self.said.read_text():
            assert self._process.poll() is None, self.said.read_text()
            assert time.monotonic() < deadline_s
            self._process.poll()
        return self

    def stop(self):
        if self._process is not None:
            self._process.send_signal(signal.SIGINT)
            self._process.wait(DEADLINE_S)
            self._process = None


@pytest.fixture(scope='module')
def browser():
    for module in ('rclpy', 'nicegui', 'playwright'):
        need(module)
    from playwright.sync_api import sync_playwright
    found = next(filter(None, map(shutil.which, BROWSERS)), None)
    if found is None:
        (pytest.fail if IN_CI else pytest.skip)('no Chromium is here: apt-get install chromium')
    with sync_playwright() as play:
        made = play.chromium.launch(executable_path=found, args=['--no-sandbox'])
        yield made
        made.close()


@pytest.fixture(scope='module')
def ship():
    made = Ship()
    yield made
    made.close()


@pytest.fixture(scope='module')
def graph(browser, ship, tmp_path_factory):
    """Return the graph; its page needs a token."""
    made = Graph(tmp_path_factory.mktemp('graph'), ship, '127.0.0.1', free_port()).start()
    yield made
    made.stop()


@pytest.fixture
def page(browser, graph):
    """Return the page in a browser of its own; an error on its console fails the test."""
    context = browser.new_context(viewport={'width': 1280, 'height': 800})
    made, wrong = context.new_page(), []
    made.on('console', lambda said: wrong.append(said.text) if said.type == 'error' else None)
    made.on('pageerror', lambda error: wrong.append(str(error)))
    made.on('request', lambda asked: wrong.append(asked.url)
            if '//127.0.0.1' not in asked.url and not asked.url.startswith('data:') else None)
    made.wrong = wrong
    made.goto(graph.url)
    made.wait_for_selector('.k-ts_heading')
    yield made
    context.close()
    assert wrong == []


def await_text(page, selector, pattern):
    """Wait until an element has a text; return it."""
    page.wait_for_function(
        '([selector, pattern]) => new RegExp(pattern).test('
        'document.querySelector(selector)?.textContent ?? "")',
        arg=[selector, pattern], timeout=1000.0 * DEADLINE_S)
    return page.text_content(selector)


def test_values_are_live_and_the_page_shows_its_age(page):
    first = await_text(page, '.k-ts_heading', r'^\d{3}\.\d°$')
    page.wait_for_function(
        'first => document.querySelector(".k-ts_heading").textContent !== first', arg=first)
    assert await_text(page, '.k-ts_difference', r'^\+0\.\d\d°$')
    assert await_text(page, '.k-ts_state', '^sound$')
    assert await_text(page, '.k-alert', '^No alerts$')
    assert 'COMPLIANT' not in page.text_content('.k-lamp')
    await_text(page, '.k-nodes', 'compliance.*dashboard.*recorder.*synchronizer')
    # The trend is drawn once a second.
    page.wait_for_function('document.querySelector("svg path.trace")?.getAttribute("d")')
    page.wait_for_function('document.querySelectorAll(".strip .place").length === 2')


@pytest.mark.parametrize('size', [(1920, 1080), (1280, 800), (1024, 768), (390, 844)])
def test_the_page_fits_and_its_numerals_are_big(page, size):
    page.set_viewport_size({'width': size[0], 'height': size[1]})
    await_text(page, '.k-ts_heading', r'^\d{3}')
    found = page.evaluate("""() => ({
      wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,
      size: parseFloat(getComputedStyle(document.querySelector('.k-ts_heading')).fontSize),
      cut: [...document.querySelectorAll('.heading, .lamp, .k-alert')].filter(
        shown => shown.scrollWidth > shown.parentElement.clientWidth).length,
      alerts: document.querySelector('.alerts').getBoundingClientRect(),
      trend: document.querySelector('.picture').getBoundingClientRect().bottom})""")
    assert found['wide'] <= 0 and found['cut'] == 0
    assert found['size'] >= (96.0 if size[0] >= 1280 else 56.0)
    assert found['alerts']['top'] == 0.0
    # Whoever stands at a wide screen sees the trend without scrolling.
    assert size[0] < 1280 or found['trend'] < size[1]


@pytest.mark.parametrize('palette', ['day', 'dusk', 'night'])
@pytest.mark.parametrize('size', [(1280, 800), (390, 844)])
def test_axe_finds_nothing(page, palette, size):
    need('axe_playwright_python')
    from axe_playwright_python.sync_playwright import Axe
    page.set_viewport_size({'width': size[0], 'height': size[1]})
    await_text(page, '.k-ts_heading', r'^\d{3}')
    page.click(f'.k-{palette}')
    page.click('.k-history summary')
    page.click('.k-details summary')
    found = Axe().run(page)
    assert found.violations_count == 0, found.generate_report()


def test_the_keyboard_alone_reaches_every_button_with_a_visible_focus(page):
    await_text(page, '.k-ts_heading', r'^\d{3}')
    buttons = page.evaluate("""() => [...document.querySelectorAll('button, summary, input')]
      .filter(shown => shown.offsetParent).length""")
    reached = set()
    for _ in range(buttons + 3):
        page.keyboard.press('Tab')
        name, frame = page.evaluate("""() => [document.activeElement.className
          + document.activeElement.id + document.activeElement.textContent,
          getComputedStyle(document.activeElement).boxShadow]""")
        reached.add(name)
        assert frame != 'none' or 'q-page' in name or not name.strip(), name
    assert len(reached) >= buttons


def test_a_drag_over_the_trend_zooms_it(page):
    await_text(page, '.k-ts_heading', r'^\d{3}')
    page.wait_for_selector('.picture')
    box = page.locator('.picture').bounding_box()
    page.mouse.move(box['x'] + 0.6 * box['width'], box['y'] + 20.0)
    page.mouse.down()
    page.mouse.move(box['x'] + 0.9 * box['width'], box['y'] + 20.0)
    page.mouse.up()
    page.wait_for_selector('.k-whole', state='visible')
    page.click('.k-whole')
    page.wait_for_selector('.k-whole', state='hidden')
    page.click('.k-span-21600')
    page.wait_for_function(
        'document.querySelector(".k-span-21600").getAttribute("aria-pressed") === "true"')


@pytest.mark.parametrize('name, ground', [
    ('day', 'rgb(247, 248, 249)'), ('dusk', 'rgb(20, 24, 29)'), ('night', 'rgb(0, 0, 0)')])
def test_the_browser_keeps_the_palette(page, name, ground):
    asked = 'getComputedStyle(document.body).backgroundColor'
    page.click(f'.k-{name}')
    assert page.evaluate(asked) == ground
    page.reload()
    page.wait_for_selector('.k-ts_heading')
    assert page.evaluate(asked) == ground


def test_an_action_needs_the_token(page):
    await_text(page, '.k-run', r'^run \d')
    page.click('.k-start')
    await_text(page, '.k-answer', r'all before it out of the record: run \d+, .* differences')
    await_text(page, '.k-start', '^Tap again: a new run begins$')
    page.click('.k-start')
    assert 'refused: the token is wrong' in await_text(page, '.k-answer', 'refused')
    page.fill('.k-token input', TOKEN)
    page.click('.k-start')
    await_text(page, '.k-start', '^Tap again')
    page.click('.k-start')
    await_text(page, '.k-answer', '^start run waits until')
    page.click('.k-now')
    await_text(page, '.k-answer', 'start after the pair of')
    assert not page.is_visible('.k-name')
    page.fill('.k-note input', 'rough sea')
    page.click('.k-keep')
    await_text(page, '.k-answer', '^the note was sent to the recorder')


def test_every_page_shows_the_action_that_waits_and_can_undo_it(page, graph, browser):
    await_text(page, '.k-run', r'^run \d')
    page.fill('.k-token input', TOKEN)
    page.click('.k-stop')
    await_text(page, '.k-stop', '^Tap again: the run ends$')
    page.click('.k-stop')
    elsewhere = browser.new_context().new_page()
    elsewhere.goto(graph.url)
    words = (r'^The run ends at \d\d:\d\d:\d\d UTC, in [1-5]?\d s, asked by Mate: '
             r'run \d+ would end')
    first = await_text(elsewhere, '.k-waiting', words)
    elsewhere.wait_for_function(
        'first => document.querySelector(".k-waiting").textContent !== first', arg=first)
    page.click('.k-start')
    await_text(page, '.k-start', '^Tap again')
    page.click('.k-start')
    await_text(page, '.k-answer', '^stop run waits already')
    elsewhere.click('.k-undo')
    await_text(elsewhere, '.k-answer', 'refused: the token is wrong')
    await_text(page, '.k-waiting', words)
    elsewhere.fill('.k-token input', TOKEN)
    elsewhere.click('.k-undo')
    for shown in (page, elsewhere):
        await_text(shown, '.k-answer', '^undid: stop run')
        shown.wait_for_selector('.k-undo', state='hidden')
    elsewhere.context.close()
    await_text(page, '.k-run', r'^run \d')


def test_where_tokens_name_the_operators_nobody_types_a_name(page):
    assert not page.is_visible('.k-name') and page.is_visible('.k-token')


def test_without_named_tokens_the_browser_keeps_the_name_of_the_operator(browser):
    """The page of loopback, without a graph: what it asks for has the name that was typed."""
    server = serve_page('')
    context = browser.new_context()
    try:
        page = context.new_page()
        page.goto(server.stdout.readline().strip())
        page.fill('.k-name input', 'J. Smith')
        page.reload()
        page.wait_for_function('document.querySelector(".k-name input")?.value === "J. Smith"')
        page.fill('.k-note input', 'calm sea')
        page.click('.k-keep')
        answer = re.escape("('note', 'calm sea', 'J. Smith')")
        await_text(page, '.k-answer', answer)
    finally:
        context.close()
        server.communicate(timeout=DEADLINE_S)


def test_a_silent_sensor_goes_stale_raises_an_alarm_and_is_acknowledged(page, ship):
    await_text(page, '.k-ts_heading', r'^\d{3}')
    page.fill('.k-token input', TOKEN)
    ship.silent = True
    try:
        page.wait_for_selector('.k-ts_heading.stale', timeout=1000.0 * DEADLINE_S)
        await_text(page, '.k-ts_state', r'^✖ silent \d')
        assert await_text(page, '.k-alert', '^Tested sensor silent')
        page.wait_for_selector('.alert.unacknowledged.p-warning')
        assert page.get_attribute('.alert', 'data-sound') == 'warning'
        page.click('.k-silence')
        await_text(page, '.k-silence', r'^Silent \d+ s$')
        page.click('.k-list')
        await_text(page, '.k-alerts', r'WARNING: Tested sensor silent \(not acknowledged')
        page.click('.k-acknowledge')
        page.wait_for_selector('.k-acknowledge', state='hidden', timeout=1000.0 * DEADLINE_S)
        assert page.get_attribute('.alert', 'data-sound') == ''
    finally:
        ship.silent = False
    await_text(page, '.k-ts_heading', r'^\d{3}')


@pytest.mark.parametrize('headers, method, status', [
    ({'Origin': 'http://evil.example'}, 'GET', 403), ({}, 'POST', 403),
    ({'Host': 'evil.example'}, 'GET', 403), ({}, 'GET', 200)])
def test_requests_of_other_sites_are_refused(graph, headers, method, status):
    assert request_status(graph.url, headers, method)[0] == status


@pytest.mark.parametrize('path', [
    'admin', 'metrics/', '_nicegui', '_nicegui/0.0/static/nicegui.js',
    '_nicegui/{version}/static/none.js', '_nicegui/{version}/libraries/none',
    '_nicegui/{version}/static/../nicegui.py', '_nicegui_ws/none', 'docs', 'openapi.json'])
def test_an_unknown_path_is_not_found(graph, path):
    """Before, the library answered every path with the page."""
    from nicegui import __version__
    status, headers = request_status(f'{graph.url}{path.format(version=__version__)}')
    assert status == 404 and dict(HEADERS).items() <= {
        (name.lower().encode(), value.encode()) for name, value in headers.items()}


def test_a_script_that_is_smuggled_into_the_page_does_not_run(page):
    text = await_text(page, '.k-ts_heading', r'^\d{3}')
    page.evaluate("""() => {
        const place = document.createElement('div');
        place.innerHTML = '<img src="data:," onerror="window.smuggled = true">';
        const script = document.createElement('script');
        script.textContent = 'window.smuggled = true';
        document.body.append(place, script); }""")
    await_text(page, '.k-ts_heading', f'^(?!{text})')
    assert page.evaluate('window.smuggled') is None
    refused = [said for said in page.wrong if 'Content Security Policy' in said]
    assert len(refused) == len(page.wrong) == 2
    page.wrong.clear()


def request_status(url, headers=(), method='GET'):
    """Return the status and the headers of an answer."""
    try:
        request = Request(url, headers=dict(headers), method=method)
        with urlopen(request, timeout=DEADLINE_S) as answer:
            return answer.status, answer.headers
    except HTTPError as error:
        return error.code, error.headers


def test_the_page_says_it_is_not_live_and_goes_on_after_a_restart(page, graph):
    await_text(page, '.k-ts_heading', r'^\d{3}')
    page.fill('.k-token input', TOKEN)
    page.click('.k-start')
    await_text(page, '.k-start', '^Tap again')
    page.click('.k-start')
    await_text(page, '.k-waiting', '^The run starts at ')
    graph.stop()
    not_done = 'not done, because the page ended: start run [by Mate]'
    assert not_done in graph.said.read_text()
    bag, = graph.folder.glob('heading_*')
    assert f'dashboard: {not_done}' in [note.text for note in read_notes(BagReader(bag))]
    page.wait_for_selector('#page-dead', state='visible', timeout=1000.0 * DEADLINE_S)
    assert re.search(r'NOT LIVE, last \d\d:\d\d:\d\d UTC', page.text_content('#page-dead'))
    assert page.evaluate("""() => [...document.querySelectorAll('.nicegui-error-popup')].every(
        box => getComputedStyle(box).display === 'none')""")
    graph.start()
    page.wait_for_selector('#page-dead', state='hidden', timeout=1000.0 * DEADLINE_S)
    await_text(page, '.k-ts_heading', r'^\d{3}\.\d°$')
    # While the server is away, the browser says that it cannot be reached.
    page.wrong[:] = [text for text in page.wrong
                     if not re.search('ERR_CONNECTION_REFUSED|ERR_EMPTY_RESPONSE|WebSocket', text)]
