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

"""Signs that a comparison means nothing: one source, different conventions, standstill."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'conventions': ('Convention', 'estimate_mean_difference', 'find_convention', 'MeanDifference'),
    'one_source': ('find_one_source', 'OneSource'),
    'outliers': ('find_outliers', 'Outliers'),
    'standstill': ('find_frozen', 'find_standstill', 'Frozen', 'Standstill'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .conventions import (
        Convention as Convention,
        estimate_mean_difference as estimate_mean_difference,
        find_convention as find_convention,
        MeanDifference as MeanDifference,
    )
    from .one_source import find_one_source as find_one_source, OneSource as OneSource
    from .outliers import find_outliers as find_outliers, Outliers as Outliers
    from .standstill import (
        find_frozen as find_frozen,
        find_standstill as find_standstill,
        Frozen as Frozen,
        Standstill as Standstill,
    )
