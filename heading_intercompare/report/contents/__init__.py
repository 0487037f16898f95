# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""What a protocol says: the words and figures of its first page, sections and tables."""
