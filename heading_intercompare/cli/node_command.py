# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A node as a command of the program."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Callable, Mapping

from heading_intercompare.app.config import load_config

__all__ = ['program_node']

_WATCH_S = 0.1


def program_node(module: str, node: str, config: str | None, *,
                 remap: Mapping[str, str] | None = None,
                 watch: Callable[[Any], None] | None = None, **parameters: Any) -> int:
    """
    Run a node until its work is over or Ctrl-C.

    Parameters
    ----------
    module, node : str
        Module in ``nodes`` and class in it.
    config : str or None
        ROS parameter file.
    remap : mapping of str to str, optional
        Topics that go out under other names; the node takes them as `remapped` and refuses those
        that it does not publish.
    watch : callable, optional
        Called with the node, ten times a second.
    **parameters : object
        Of the node; None is not given.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    OSError, SettingsError
        If the file cannot be read, or is no ROS parameter file.

    """
    from heading_intercompare.nodes.ros.parameters import make_overrides
    from heading_intercompare.nodes.ros.process import run
    from heading_intercompare.nodes.ros.steady_timer import every

    # What rcl says of a file that it cannot read is long and unclear; other text it ignores.
    load_config(config)
    kind = getattr(import_module(f'heading_intercompare.nodes.{module}'), node)
    given: dict[str, Any] = {'parameter_overrides': make_overrides(parameters)}
    if remap:
        given['remapped'] = list(remap)

    def make(**kwargs: Any) -> Any:
        made = kind(**given, **kwargs)
        if watch is not None:
            every(made, _WATCH_S, lambda: watch(made))
        return made

    arguments = ['--params-file', config] if config else []
    for old, new in (remap or {}).items():
        arguments += ['-r', f'{old}:={new}']
    return run('heading-intercompare', make, ['--ros-args', *arguments] if arguments else [])
