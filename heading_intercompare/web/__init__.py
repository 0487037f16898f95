# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The live page: what people on the bridge see of a running graph.

`bridge_view` turns decoded messages into one record of what to show, without ROS and without web.
"""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bridge_view': ('Bridge', 'BridgeView'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bridge_view import Bridge as Bridge, BridgeView as BridgeView
