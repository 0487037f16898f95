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

"""The alarms of the synchronizer, and its health: silence, clocks, pairing, rejected readings."""

from __future__ import annotations

import time
from typing import Sequence

from rclpy.node import Node

from heading_intercompare.core.alarms.stream_watch import STREAM_RULES, StreamWatch
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pairing.pairing_watch import PairingWatch
from heading_intercompare.core.settings import Pairing
from heading_intercompare.core.statistics.recent_count import RecentCount
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.interface.parameters import follow
from heading_intercompare.nodes.presence.health import Health
from heading_intercompare.nodes.settings import Taking
from heading_intercompare.nodes.taking.intake import Intake

from .alarm_panel import AlarmPanel


class StreamAlarms:
    """
    Watches the streams of a synchronizer and their pairing.

    Parameters
    ----------
    health
        Shows the parts `pairing` and `rejected`.
    taking
        Says how long silence is allowed, and how long losses are shown.

    Attributes
    ----------
    panel : AlarmPanel
        The alarms.

    """

    def __init__(self, node: Node, health: Health, rule: Pairing, taking: Taking) -> None:
        self._health = health
        self._pairing = PairingWatch(rule)
        self._streams = StreamWatch(taking.stale_s, rule.max_wait_s)
        follow(node, 'stale_s', self._streams.allow)
        self._rejected, self._set_back = (RecentCount(taking.lost_shown_s) for _ in range(2))
        self.panel = AlarmPanel(node, health, STREAM_RULES)

    def look(self, pairer: Pairer, intakes: Sequence[Intake]) -> None:
        """Look at both streams and the ledger; call it once a second."""
        now_s, heard_ns, ledger = time.monotonic(), pairer.heard_ns, pairer.ledger
        self.panel.update(self._streams.look([intake.received for intake in intakes], heard_ns,
                                             now_s), time.time_ns())
        state = self._pairing.look(ledger, *heard_ns, now_s)
        set_back = self._set_back.take(len(ledger.all_set_backs), now_s)
        troubles = [words for words in (state.trouble, *(ledger.troubles if set_back else ()))
                    if words]
        self._health.note('pairing', WARN if troubles else OK, '; '.join(troubles) or 'pairing',
                          paired_share=state.paired_share, offset_s=state.offset_s,
                          figures=dict(ledger.total.counts.items()))
        total = ledger.rejected
        recent = self._rejected.take(total, now_s)
        self._health.note('rejected', WARN if recent else OK,
                          f'{recent} readings rejected' if recent else
                          'no reading rejected lately', total=total)
