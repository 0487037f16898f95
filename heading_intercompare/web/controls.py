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

"""What a person at the page can do, and where the page gets what it shows."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from typing import Callable

from heading_intercompare.web.bridge.bridge_view import BridgeView


@dataclass(frozen=True, slots=True)
class Controls:
    """
    The graph as the page sees it; every function may be called from any thread.

    Attributes
    ----------
    look
        Returns the newest view, and its age in seconds.
    act
        ``act(what, text, operator)`` begins an action and returns a future with the answer.
        `what` is 'start', 'stop', 'acknowledge' (of the alarm `text`, all if empty) or 'note'
        (`text`); `operator` is the name of the person, '' if it is not known.

    """

    look: Callable[[], tuple[BridgeView, float]]
    act: Callable[[str, str, str], 'Future[str]']
