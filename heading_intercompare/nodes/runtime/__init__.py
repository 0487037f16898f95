# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The work of running nodes: publish, watch, report."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'health': ('Health',),
    'note_publisher': ('publish_note',),
    'publishing': ('Allowance', 'Audience', 'await_acknowledgement'),
    'source_thread': ('Reading',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .health import Health as Health
    from .note_publisher import publish_note as publish_note
    from .publishing import (
        Allowance as Allowance,
        Audience as Audience,
        await_acknowledgement as await_acknowledgement,
    )
    from .source_thread import Reading as Reading
