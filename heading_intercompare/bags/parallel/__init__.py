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

"""Decoding of headings minute by minute, in several processes."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'by_minute': ('Window',),
    'decode_workers': ('can_fork', 'decode_stretches', 'Task'),
    'decoding': ('Decoded', 'Decoder', 'Kind'),
    'prefetch': ('run_ahead',),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .by_minute import Window as Window
    from .decode_workers import (
        can_fork as can_fork,
        decode_stretches as decode_stretches,
        Task as Task,
    )
    from .decoding import Decoded as Decoded, Decoder as Decoder, Kind as Kind
    from .prefetch import run_ahead as run_ahead
