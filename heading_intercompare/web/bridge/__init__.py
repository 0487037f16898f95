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

"""What people on the bridge see of a running graph, and its words: for page and terminal alike."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'bridge_view': ('Bridge', 'BridgeView'),
    'view_texts': ('alarm_words', 'node_words', 'Said', 'tell'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .bridge_view import Bridge as Bridge, BridgeView as BridgeView
    from .view_texts import (
        alarm_words as alarm_words,
        node_words as node_words,
        Said as Said,
        tell as tell,
    )
