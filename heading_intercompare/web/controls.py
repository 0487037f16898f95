# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a person at the page can do, and where the page gets what it shows."""

from __future__ import annotations

from concurrent.futures import Future
from dataclasses import dataclass
from typing import Callable

from heading_intercompare.web.bridge.bridge_view import BridgeView

__all__ = ['Controls']


@dataclass(frozen=True, slots=True)
class Controls:
    """
    The graph as the page sees it; every function may be called from any thread.

    Attributes
    ----------
    look : callable
        Returns the newest view, and its age in seconds.
    act : callable
        ``act(what, text)`` begins an action and returns a future with the answer in words.
        `what` is 'start', 'stop', 'acknowledge' (of the alarm `text`, all if empty) or 'note'
        (`text`).

    """

    look: Callable[[], tuple[BridgeView, float]]
    act: Callable[[str, str], 'Future[str]']
