# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A node as a command of the program."""

from __future__ import annotations

from functools import partial
from importlib import import_module
from typing import Any

__all__ = ['program_node']


def program_node(module: str, node: str, config: str | None, **parameters: Any) -> int:
    """
    Run a node until its work is over or Ctrl-C.

    Parameters
    ----------
    module, node : str
        Module in ``nodes`` and class in it.
    config : str or None
        ROS parameter file.
    parameters : object
        Of the node; None is not given.

    Returns
    -------
    int
        The exit code.

    """
    from heading_intercompare.nodes.parameters import overrides
    from heading_intercompare.nodes.process import run

    make = getattr(import_module(f'heading_intercompare.nodes.{module}'), node)
    files = ['--ros-args', '--params-file', config] if config else []
    return run('heading-intercompare', partial(make, parameter_overrides=overrides(parameters)),
               files)
