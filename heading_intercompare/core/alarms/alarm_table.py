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

"""The alarms of one node by name, and what changed at each look."""

from __future__ import annotations

from typing import Iterable, Mapping

from .alarm import Alarm, Rule, Sign


class AlarmTable:
    """
    Alarms by name.

    Parameters
    ----------
    rules
        One for each alarm.

    """

    def __init__(self, rules: Iterable[Rule]) -> None:
        self._alarms = {rule.name: Alarm(rule) for rule in rules}

    def __len__(self) -> int:
        return len(self._alarms)

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """All alarms, in the order of their rules."""
        return tuple(self._alarms.values())

    def __getitem__(self, name: str) -> Alarm:
        return self._alarms[name]

    def update(self, signs: Mapping[str, Sign], now_ns: int) -> list[Alarm]:
        """
        Take what the detectors say at a time; alarms without a sign stay as they are.

        Returns
        -------
        list of Alarm
            Those whose state changed.

        """
        return self._change({name: self._alarms[name].see(sign, now_ns)
                             for name, sign in signs.items()})

    def acknowledge(self, name: str | None, now_ns: int) -> list[Alarm]:
        """Acknowledge one alarm by its name, or all; return those whose state changed."""
        return self._change({key: alarm.acknowledge(now_ns) for key, alarm in self._alarms.items()
                             if name in (None, key)})

    def _change(self, new: Mapping[str, Alarm]) -> list[Alarm]:
        changed = [alarm for name, alarm in new.items()
                   if alarm.state is not self._alarms[name].state]
        self._alarms.update(new)
        return changed
