# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The versions of the software and of its decision rule, as verdicts state them."""

__all__ = ['RULE_VERSION', 'VERSION']

#: setup.py reads it from here; bags state it, too.
VERSION = '0.1.0'

RULE_VERSION = 2
"""
Raised whenever the same readings and settings may give another outcome, bound or limit.

1 had a gate and a choice of estimators (``risk.method``); 2 has the spectrum of the squares, and
findings that bind. ``docs/risk.md`` describes the present one.
"""
