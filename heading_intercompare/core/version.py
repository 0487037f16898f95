# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The version of the software, as verdicts and bags state it; setup.py reads it from here."""

__all__ = ['VERSION']

VERSION = '0.1.0'
