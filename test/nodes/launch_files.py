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

"""What the launch files start, read without the packages `launch` and `launch_ros`."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
import importlib.util
import os
from pathlib import Path
import sys
import types
from typing import Any
from unittest import mock

import yaml

# What the launch files import stays loaded when their stand-ins are taken away again.
import heading_intercompare.nodes.interface.places  # noqa: F401

FOLDER = Path(__file__).resolve().parents[2] / 'launch'
LOOPBACK = Path(__file__).with_name('loopback.xml')


def make_environment(domain: int, transports: str = '') -> dict[str, str]:
    """
    Return the environment of a process of a graph in a ROS domain, within this machine.

    The middleware ignores a choice of transports that comes with ``LOCALHOST``.
    """
    hidden = ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'} if transports != 'UDPv4' else
              {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',
               'FASTRTPS_DEFAULT_PROFILES_FILE': str(LOOPBACK)})
    return {**os.environ, 'ROS_DOMAIN_ID': str(domain), **hidden}


@dataclass
class Node:
    """A node to start, with the arguments of `launch_ros.actions.Node`."""

    package: str
    executable: str
    namespace: str
    parameters: list[Any]
    output: str
    #: Without a name, the process has several nodes, and each keeps its own.
    name: str = ''
    on_exit: Any = None
    respawn: bool = False
    respawn_delay: float = 0.0
    remappings: list[tuple[str, str]] = field(default_factory=list)
    ros_arguments: list[str] = field(default_factory=list)
    sigterm_timeout: str = '5'
    #: The transports that the launch file chooses.
    transports: str = ''
    #: Name of its files, if it is not that of the node.
    file: str = ''

    @property
    def label(self) -> str:
        """Name of the node, or of the executable of several."""
        return self.name or self.executable

    def own(self, node: str = '') -> dict[str, Any]:
        """Return the parameters that the launch file itself sets; of one of several nodes."""
        given = [given for given in self.parameters if isinstance(given, dict)]
        if not self.name:
            sections = yaml.safe_load(Path(self.parameters[-1]).read_text('utf-8'))
            given = [section['ros__parameters'] for name, section in sections.items()
                     if name.endswith(f'/{node}')]
        return {key: value for values in given for key, value in values.items()}

    def arguments(self, folder: Path) -> list[str]:
        """Return the arguments of the process, as `launch_ros` composes them."""
        files = []
        for number, given in enumerate(self.parameters):
            path = given
            if isinstance(given, dict):
                path = folder / f'{self.file or self.name}_{number}.yaml'
                full = f'{self.namespace.rstrip("/")}/{self.name}'
                path.write_text(yaml.dump({full: {'ros__parameters': given}}))
            files += ['--params-file', str(path)]
        rules = [*([('__node', self.name)] if self.name else []), ('__ns', self.namespace),
                 *self.remappings]
        return ['--ros-args', *(word for old, new in rules for word in ('-r', f'{old}:={new}')),
                *files, *self.ros_arguments]


@dataclass
class Argument:
    """An argument of a launch file."""

    name: str
    default_value: str
    description: str


@dataclass
class Configuration:
    """The future value of an argument."""

    name: str

    def perform(self, context: Context) -> str:
        """Return the value."""
        return context.launch_configurations[self.name]


@dataclass
class Context:
    """What is known while a launch file starts."""

    launch_configurations: dict[str, str]


@dataclass
class Function:
    """A function that returns actions."""

    function: Any


@dataclass
class Info:
    """A line on the screen."""

    msg: str


@dataclass
class Include:
    """Another launch file, with what it is given."""

    source: str
    launch_arguments: Any


@dataclass
class EnvironmentVariable:
    """A variable that all nodes get."""

    name: str
    value: str


@dataclass
class Shutdown:
    """The end of everything."""

    reason: str


def description(name: str) -> list[Any]:
    """Return the actions of a launch file."""
    modules = {key: types.ModuleType(key) for key in (
        'launch', 'launch.actions', 'launch.launch_description_sources', 'launch.substitutions',
        'launch_ros', 'launch_ros.actions')}
    modules['launch'].LaunchDescription = list
    modules['launch.actions'].DeclareLaunchArgument = Argument
    modules['launch.actions'].LogInfo = Info
    modules['launch.actions'].OpaqueFunction = Function
    modules['launch.actions'].SetEnvironmentVariable = EnvironmentVariable
    modules['launch.actions'].Shutdown = Shutdown
    modules['launch.actions'].IncludeLaunchDescription = Include
    modules['launch.launch_description_sources'].PythonLaunchDescriptionSource = str
    modules['launch.substitutions'].LaunchConfiguration = Configuration
    modules['launch_ros.actions'].Node = Node
    with mock.patch.dict(sys.modules, modules):
        spec = importlib.util.spec_from_file_location('launch_file', FOLDER / name)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module.generate_launch_description()


def nodes(name: str, **given: str) -> list[Node]:
    """Return the nodes that a launch file starts with these arguments."""
    return [action for action in perform(name, given) if isinstance(action, Node)]


def lines(name: str, **given: str) -> list[str]:
    """Return what a launch file says on the screen before its nodes start."""
    return [action.msg for action in perform(name, given) if isinstance(action, Info)]


def perform(name: str, given: dict[str, str]) -> list[Node | Info]:
    """Return what a launch file does with these arguments."""
    actions = description(name)
    declared = {a.name: a.default_value for a in actions if isinstance(a, Argument)}
    context = Context({**declared, **given})
    made = []
    for action in actions:
        if isinstance(action, Include):
            passed = {key: value.perform(context) if isinstance(value, Configuration) else value
                      for key, value in action.launch_arguments}
            # Its file also sees what was given to this one.
            made += perform(Path(action.source).name, {**context.launch_configurations, **passed})
        elif isinstance(action, Function):
            made += action.function(context)
    variables = {a.name: a.value for a in actions if isinstance(a, EnvironmentVariable)}
    transports = variables.get('FASTDDS_BUILTIN_TRANSPORTS', '')
    return [replace(one, transports=one.transports or transports) if isinstance(one, Node) else one
            for one in made]
