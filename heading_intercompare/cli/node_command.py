# Copyright 2026 The heading_intercompare authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A node as a command of the program."""

from __future__ import annotations

import argparse
from importlib import import_module
from typing import Any, Callable, Mapping

from heading_intercompare.app.config import load_config
from heading_intercompare.bags.rosbag2.topic_names import clean_namespace

_WATCH_S, _BESIDE_S = 0.1, 0.3


def add_namespace_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--namespace``."""
    parser.add_argument('--namespace', metavar='/NAME', default='/', type=_read_namespace,
                        help='of all nodes and topics: one for each graph in a ROS domain')


def _read_namespace(text: str) -> str:
    return clean_namespace(text) or '/'


def run_node(module: str, node: str, config: str | None, *, namespace: str = '/',
             remap: Mapping[str, str] | None = None,
             watch: Callable[[Any], None] | None = None,
             beside: tuple[str, str, Callable[[Any, Any], None]] | None = None,
             **parameters: Any) -> int:
    """
    Run a node until its work is done or the user presses Ctrl-C.

    Parameters
    ----------
    module, node
        Module in ``nodes`` and the class in it.
    config
        ROS parameter file.
    namespace
        Namespace of the node and its topics, with a leading slash. The sections of the file hold
        there too.
    remap
        Published topics with other names. The node gets them as `remapped` and rejects any that
        it does not publish.
    watch
        Called with the node ten times a second.
    beside
        Module and class of a node that runs beside it, and what is called with both nodes three
        times a second.
    **parameters
        Parameters of the node; those that are None are left out.

    Returns
    -------
    int
        The exit code.

    Raises
    ------
    OSError, SettingsError
        If the file cannot be read, is not a ROS parameter file, or the namespace is none.

    """
    from heading_intercompare.nodes.interface.parameters import make_overrides
    from heading_intercompare.nodes.launching.process import run
    from heading_intercompare.nodes.presence.endpoints import check_namespace
    from heading_intercompare.nodes.spinning.clocks import every

    check_namespace(namespace)
    # rcl's message for an unreadable file is long and unclear, and rcl ignores other text.
    file = load_config(config)
    section = file.sections.get(module, {}) if namespace != '/' else {}
    kind = _find(module, node)
    parameters = {name: value for name, value in parameters.items() if value is not None}
    node_arguments: dict[str, Any] = {
        'parameter_overrides': make_overrides({**section, **parameters})}
    if remap:
        node_arguments['remapped'] = list(remap)

    def make(**kwargs: Any) -> Any:
        main_node = kind(**node_arguments, **kwargs)
        if watch is not None:
            every(main_node, _WATCH_S, lambda: watch(main_node))
        return main_node

    def make_beside(main_node: Any, **kwargs: Any) -> Any:
        assert beside is not None
        other_module, other_node, look = beside
        beside_node = _find(other_module, other_node)(**kwargs)
        every(beside_node, _BESIDE_S, lambda: look(main_node, beside_node))
        return beside_node

    arguments = ['--params-file', config] if config else []
    if namespace != '/':
        arguments += ['-r', f'__ns:={namespace}']
    for old, new in (remap or {}).items():
        arguments += ['-r', f'{old}:={new}']
    return run('heading-intercompare', make, ['--ros-args', *arguments] if arguments else [],
               beside=None if beside is None else make_beside, more=True)


def _find(module: str, node: str) -> Any:
    return getattr(import_module(f'heading_intercompare.nodes.{module}'), node)
