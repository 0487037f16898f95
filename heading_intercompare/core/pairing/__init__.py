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

"""Pairs and differences from the headings of two sensors, with every reading accounted for."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'difference': ('subtract',),
    'direction': ('typical_step_ns',),
    'ensembles': ('Ensembles', 'Ensembling'),
    'ledger': ('Ledger',),
    'ledger_keys': ('LedgerKey', 'LedgerSegment', 'REASONS'),
    'pairer': ('pair', 'Pairer'),
    'pairing_watch': ('PairingState', 'PairingWatch'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .difference import subtract as subtract
    from .direction import typical_step_ns as typical_step_ns
    from .ensembles import Ensembles as Ensembles, Ensembling as Ensembling
    from .ledger import Ledger as Ledger
    from .ledger_keys import (
        LedgerKey as LedgerKey,
        LedgerSegment as LedgerSegment,
        REASONS as REASONS,
    )
    from .pairer import pair as pair, Pairer as Pairer
    from .pairing_watch import PairingState as PairingState, PairingWatch as PairingWatch
