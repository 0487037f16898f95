# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
The live page: what people on the bridge see of a running graph.

The room `bridge` turns decoded messages into one record of what to show, without ROS and without
web; the terminal shows the same record.
"""
