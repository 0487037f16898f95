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

"""Changes of alerts as JSON to an address of HTTP, in a thread that waits for the network."""

from __future__ import annotations

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from queue import Empty, Full, Queue
import threading
import time
from typing import Any, Iterable

from heading_intercompare.core.alarms.alarm import AlarmState
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.drivers.settings import DriverError

from .alert_list import name_alerts, ReportedAlert
from .alert_settings import AlertSettings

_MOST_WAITING, _MOST_KNOWN = 1000, 1000
_TIMEOUT_S = 5.0
_FIRST_WAIT_S, _LONGEST_WAIT_S = 1.0, 60.0
#: How long the end waits for the last changes.
_END_S = 2.0


class AlertPush:
    """
    Posts each change of an alert, in order, until the address has taken it.

    Parameters
    ----------
    settings
        With `push_url` set.
    first_wait_s
        Time before the second attempt, seconds; it doubles up to a minute.

    Attributes
    ----------
    counts
        `sent`; `refused`, which the address rejected for good; `given_up`, which did not fit into
        the 1000 that wait.
    status
        How the last attempt ended, in words; '' before the first.
    failing : bool
        Whether the address does not take what is sent.

    Raises
    ------
    DriverError
        If httpx is not installed.
    SettingsError
        If the address cannot be one.

    """

    def __init__(self, settings: AlertSettings, first_wait_s: float = _FIRST_WAIT_S) -> None:
        try:
            import httpx
        except ImportError:
            raise DriverError("push_url needs httpx: pip install 'heading_intercompare[push]'"
                              ) from None
        self._httpx, self._url, self._system = httpx, settings.push_url or '', settings.system
        try:
            httpx.URL(self._url)
        except httpx.InvalidURL as error:
            raise SettingsError(f'push_url: {error}') from None
        self._first_wait_s = first_wait_s
        self._reported: dict[str, ReportedAlert] = {}
        self._waiting: Queue[dict[str, Any]] = Queue(_MOST_WAITING)
        self._ending, self._over = threading.Event(), threading.Event()
        self.counts: Counter[str] = Counter()
        self.status, self.failing = '', False
        self._pool = ThreadPoolExecutor(1)
        self._work = self._pool.submit(self._run)

    def update(self, alerts: Iterable[ReportedAlert]) -> None:
        """Take the alarms of a node; what has changed will be posted."""
        for name, alert in name_alerts(alerts, self._reported.values()).items():
            former = self._reported.get(name)
            if former is None and (alert.state is AlarmState.NORMAL
                                   or len(self._reported) >= _MOST_KNOWN):
                continue
            self._reported[name] = alert
            if former is not None and (former.state, former.raised_ns) == (
                    alert.state, alert.raised_ns):
                continue
            change = {'alert': name, 'state': str(alert.state), 'priority': str(alert.priority),
                      'words': alert.words, 'raised_ns': alert.raised_ns,
                      'changed_ns': alert.changed_ns, 'system': self._system}
            try:
                self._waiting.put_nowait(change)
            except Full:
                self.counts['given_up'] += 1

    def close(self) -> None:
        """End; what the address does not take within two seconds is given up."""
        self._ending.set()
        deadline_s = time.monotonic() + _END_S
        while not self._work.done() and time.monotonic() < deadline_s:
            self._over.wait(0.02)
        self._over.set()
        self._pool.shutdown(wait=False)

    def _run(self) -> None:
        with self._httpx.Client(timeout=_TIMEOUT_S) as client:
            while not self._over.is_set():
                try:
                    change = self._waiting.get(timeout=0.1)
                except Empty:
                    if self._ending.is_set():
                        return
                    continue
                self._post(client, change)

    def _post(self, client: Any, change: dict[str, Any]) -> None:
        """Post a change until it is taken, refused for good, or all is over."""
        wait_s = self._first_wait_s
        while not self._over.is_set():
            try:
                answer = client.post(self._url, json=change)
            except (self._httpx.HTTPError, OSError) as error:
                self.status = f'not reached: {type(error).__name__}'
            else:
                self.status = f'answered {answer.status_code}'
                if answer.is_success:
                    self.failing = False
                    self.counts['sent'] += 1
                    return
                # The others are of the network or of the moment.
                if answer.is_client_error and answer.status_code not in (408, 425, 429):
                    self.failing = True
                    self.counts['refused'] += 1
                    return
            self.failing = True
            self._over.wait(wait_s)
            wait_s = min(2.0 * wait_s, _LONGEST_WAIT_S)
