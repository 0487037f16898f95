# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Three or more heading sensors of one ship: all pairs of them, and which sensor is wrong."""
