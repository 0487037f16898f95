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

"""Pairs and ensembles as csv files."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'ensembles_csv': ('EnsemblesCsvWriter',),
    'pairs_account': ('PairsAccount', 'read_account', 'write_account'),
    'pairs_csv': ('PairsCsv', 'PairsCsvWriter', 'read_pairs_csv'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .ensembles_csv import EnsemblesCsvWriter as EnsemblesCsvWriter
    from .pairs_account import (
        PairsAccount as PairsAccount,
        read_account as read_account,
        write_account as write_account,
    )
    from .pairs_csv import (
        PairsCsv as PairsCsv,
        PairsCsvWriter as PairsCsvWriter,
        read_pairs_csv as read_pairs_csv,
    )
