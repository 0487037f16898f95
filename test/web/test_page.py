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

"""The page as it is first sent to a browser."""

from __future__ import annotations

from importlib.util import find_spec
import subprocess
import sys

import pytest

from heading_intercompare.web.bridge.bridge_view import BridgeView

CODE = """
import html, urllib.request
from heading_intercompare.core.settings import Settings
from heading_intercompare.messages.status_messages import ERROR, OK, Status
from heading_intercompare.web.bridge.bridge_view import Bridge
from heading_intercompare.web.controls import Controls
from heading_intercompare.web.server import PageServer
bridge = Bridge(Settings(sensors={rows!r}))
bridge.take_sensors('figures', 5, [Status('gyro1', OK, '', {{
    'heading_deg': '45.0', 'age_s': '0.1', 'stale': 'false'}})], 1.0)
bridge.take_sensors('vote', 5, [Status('now', ERROR, 'gyro1 differs', {{'wrong': 'gyro1'}})], 1.0)
server = PageServer(Controls(lambda: (bridge.view(1.5), 0.0), None), port=0)
print(html.unescape(urllib.request.urlopen(server.url, timeout=120).read().decode()))
server.close()
"""


def fetch(rows):
    """Return the page of a graph; in a process of its own, as NiceGUI is global."""
    if find_spec('nicegui') is None:
        pytest.skip('NiceGUI is not installed')
    done = subprocess.run([sys.executable, '-c', CODE.format(rows=rows)], capture_output=True,
                          text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.process
def test_the_page_of_several_sensors_has_a_row_for_each_and_the_vote():
    page = fetch('gyro1 sigma_max_deg=0.3; gyro2 sigma_max_deg=0.3; gnss sigma_max_deg=0.1 rs')
    for words in ('gyro2', 'the vote names it now', 'now: gyro1 differs', 'the reference',
                  'Start run', 'k-tile-gyro1', 'k-tile-gnss'):
        assert words in page
    assert 'Tested sensor' not in page


@pytest.mark.process
def test_the_page_of_two_sensors_has_their_panels():
    page = fetch(None)
    for words in ('Tested sensor', 'Reference', 'k-tile-ts', 'k-tile-rs', 'No alerts',
                  'Scatter beside the norm', 'Days and runs'):
        assert words in page
    assert 'Vote' not in page


def test_what_all_browsers_see_is_drawn_once_for_each_view():
    """Each browser drew the same trend of its own, and two hundred took the whole processor."""
    pytest.importorskip('nicegui')
    from heading_intercompare.web.page import Drawings
    drawings, drawn = Drawings(), []

    def draw(view, key):
        return drawings.draw(view, key, lambda: drawn.append(key) or f'{view.paired} {key}')
    first, second = BridgeView(paired=1), BridgeView(paired=2)
    assert [draw(first, 'a'), draw(first, 'b'), draw(first, 'a'), draw(second, 'a')] == [
        '1 a', '1 b', '1 a', '2 a']
    assert drawn == ['a', 'b', 'a']


def test_many_pages_are_updated_less_often_but_stay_live():
    pytest.importorskip('nicegui')
    from heading_intercompare.web.page import MOST_PAGES, update_period_s
    periods_s = [update_period_s(pages) for pages in range(MOST_PAGES + 1)]
    assert periods_s[1] == 0.2 and periods_s == sorted(periods_s)
    # The script of the page calls it dead after 2 s.
    assert periods_s[-1] < 1.5
    assert max(pages / period_s for pages, period_s in enumerate(periods_s)) == pytest.approx(250)
