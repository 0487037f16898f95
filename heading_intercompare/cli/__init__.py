# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
# PYTHON_ARGCOMPLETE_OK
"""The command line: ``heading-intercompare COMMAND``."""

from .program import main

__all__ = ['main']
