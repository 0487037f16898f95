# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The versions of the software and of its decision rule, as verdicts state them."""

__all__ = ['RULE_VERSION', 'VERSION']

#: setup.py reads it here, and bags state it.
VERSION = '0.1.0'

RULE_VERSION = 5
"""
Increased whenever the same readings and settings may give another outcome, bound or limit.

Version 1 had a gate and a choice of estimators (``risk.method``); version 2 has the spectrum of
the squares and binding findings; version 3 judges the readings lost on the way and at the
source, rejects single stamps that jump, and names clocks that were set back; version 4 searches
for clocks that lie minutes apart, and doubts a run with a skew beyond the range of the search;
version 5 compares the headings with the motion of the ship, if it is known.
``docs/risk.md`` describes the current version.
"""
