# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
# PYTHON_ARGCOMPLETE_OK
"""``python -m heading_intercompare``: the command line."""

import sys

from heading_intercompare.cli import main

if __name__ == '__main__':
    sys.exit(main())
