# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""How each kind of source other than a bag is judged: a csv of pairs."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'csv_source': ('judge_csv',),
    'found': ('Found',),
})
if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .csv_source import judge_csv as judge_csv
    from .found import Found as Found
