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

"""Changes of alerts are posted in order, until the address has taken them."""

from __future__ import annotations

from contextlib import contextmanager
import sys
import time

from drivers.receiving import DEADLINE_S
from office import Office
import pytest

from heading_intercompare.core.alarms.alarm import AlarmState, Priority
from heading_intercompare.drivers.alerts.alert_list import ReportedAlert
from heading_intercompare.drivers.alerts.alert_push import AlertPush
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings
from heading_intercompare.drivers.settings import DriverError

NS = 1_700_000_000_000_000_000
V, A, N = AlarmState.UNACKNOWLEDGED, AlarmState.ACKNOWLEDGED, AlarmState.NORMAL


def report(state, name='jump', raised_ns=NS):
    """Return an alarm in a state."""
    return ReportedAlert('compliance', name, state, Priority.WARNING, 'TS - RS jumped', raised_ns,
                         raised_ns)


@contextmanager
def pushing(*codes):
    """Yield a server and what posts to it."""
    pytest.importorskip('httpx')
    office = Office(*codes)
    push = AlertPush(AlertSettings(push_url=office.url, system='HE0007'), first_wait_s=0.01)
    try:
        yield office, push
    finally:
        push.close()
        office.close()


def wait(condition):
    """Wait until a condition holds."""
    end = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def test_each_change_is_posted_once_and_in_order():
    with pushing(200) as (office, push):
        for state in (N, V, V, A, N, N):
            push.update([report(state)])
        push.update([report(V, raised_ns=NS + 5), report(N, 'rotated')])
        wait(lambda: push.counts['sent'] == 4)
    assert [change['state'] for change in office.posted] == [
        'active_unacknowledged', 'active_acknowledged', 'normal', 'active_unacknowledged']
    assert office.posted[0] == {
        'alert': 'compliance: jump', 'state': 'active_unacknowledged', 'priority': 'warning',
        'words': 'TS - RS jumped', 'raised_ns': NS, 'changed_ns': NS, 'system': 'HE0007'}
    assert push.status == 'answered 200' and not push.failing


def test_an_alert_that_the_newest_message_of_its_node_lacks_is_over():
    with pushing(200) as (office, push):
        push.update([report(V), report(V, 'rotated')])
        push.update([report(V, 'rotated')])
        wait(lambda: push.counts['sent'] == 3)
    assert (office.posted[2]['alert'], office.posted[2]['state']) == ('compliance: jump', 'normal')


def test_what_is_not_taken_now_is_posted_again():
    with pushing(503, 429, 500, 201) as (office, push):
        push.update([report(V)])
        push.update([report(A)])
        wait(lambda: push.counts['sent'] == 2)
    assert [change['state'] for change in office.posted] == 4 * ['active_unacknowledged'] + [
        'active_acknowledged']


def test_what_is_refused_for_good_holds_up_nothing():
    with pushing(400, 200) as (office, push):
        push.update([report(V)])
        push.update([report(A)])
        wait(lambda: push.counts['sent'] == 1)
    assert push.counts == {'refused': 1, 'sent': 1} and len(office.posted) == 2


def test_an_address_that_is_not_there_is_named_without_its_secret_and_ends_in_time():
    pytest.importorskip('httpx')
    office = Office(200)
    office.close()
    push = AlertPush(AlertSettings(push_url=office.url), first_wait_s=0.01)
    push.update([report(V)])
    wait(lambda: push.failing)
    assert push.status == 'not reached: ConnectError'
    began_s = time.monotonic()
    push.close()
    assert time.monotonic() - began_s < DEADLINE_S


def test_what_waits_without_end_is_given_up_and_counted():
    pytest.importorskip('httpx')
    office = Office(200)
    office.close()
    push = AlertPush(AlertSettings(push_url=office.url), first_wait_s=60.0)
    for number in range(1500):
        push.update([report(V, raised_ns=NS + number)])
    push.close()
    # One of them is with the thread.
    assert push.counts['given_up'] in (499, 500)


def test_without_httpx_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, 'httpx', None)
    with pytest.raises(DriverError, match=r"pip install 'heading_intercompare\[push\]'"):
        AlertPush(AlertSettings(push_url='http://127.0.0.1:9/'))
