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

"""A view that is not on a terminal is a line of text, now and then and when something changes."""

from __future__ import annotations

from heading_intercompare.cli.terminal import status_lines
from heading_intercompare.cli.terminal.live_view import LiveView
from heading_intercompare.web.bridge.bridge_records import LampView, Tone
from heading_intercompare.web.bridge.bridge_view import BridgeView


def test_text_comes_every_ten_seconds_and_when_something_changes(capsys, monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(status_lines.time, 'monotonic', lambda: clock[0])

    def lines(view):
        shown.show(view)
        return capsys.readouterr().err.splitlines()
    given = BridgeView(lamp=LampView('COMPLIANT', Tone.GOOD, 1), judged=True)
    with LiveView('live') as shown:
        assert len(lines(BridgeView())) == 1
        clock[0] = 105.0
        assert lines(BridgeView(difference_deg=0.1)) == []
        line, = lines(given)
        assert 'verdict COMPLIANT' in line
        clock[0] = 105.5
        # Not more often than once a second, however much changes.
        assert lines(BridgeView()) == []
        clock[0] = 116.0
        assert len(lines(given)) == 1
        shown.tell('alarm raised')
        assert capsys.readouterr().err == 'alarm raised\n'


def test_a_quiet_view_says_nothing(capsys):
    with LiveView('live', quiet=True) as shown:
        shown.show(BridgeView())
        shown.tell('alarm raised')
    assert capsys.readouterr().err == ''
