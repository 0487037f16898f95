# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The commands that run nodes, which need ROS 2."""
