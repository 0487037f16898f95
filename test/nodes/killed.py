# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Nodes that end as by `kill -9`, for tests."""

from __future__ import annotations

import os


def kill(ros, node, *journals):
    """End a node that keeps these journals: nothing is published or written any more."""
    ros.executor.remove_node(node)
    for trial in journals:
        journal = trial._journal._journal
        journal._syncing.close()
        os.close(journal._file)
    node.destroy_node()
    ros.nodes.remove(node)
