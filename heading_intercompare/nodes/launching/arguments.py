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

"""What the launch files read before they start a node: arguments as text, a parameter file."""

from __future__ import annotations

import atexit
import difflib
import json
import math
import os
from pathlib import Path
import re
import tempfile
from typing import Any, Iterable, Mapping

from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.declared_settings import (
    drop_removed,
    explain_unknown,
    from_mapping,
    list_settings,
    SettingsError,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.alerts.alert_settings import AlertSettings
from heading_intercompare.drivers.settings import Address, DriverSettings
from heading_intercompare.nodes.interface.parameters import OF_ROS
from heading_intercompare.nodes.settings import (
    ComplianceNode,
    DashboardNode,
    DriverNode,
    HeadingTypes,
    RecorderNode,
    ReplayerNode,
    Sending,
    SynchronizerNode,
    Taking,
)

_DRIVER = (DriverSettings, Sending, Taking, DriverNode)
OWN_SETTINGS: dict[str, tuple[type, ...]] = {
    'nmea_driver': _DRIVER,
    'motion_driver': _DRIVER,
    'synchronizer': (Taking, HeadingTypes, SynchronizerNode),
    'compliance': (Taking, ComplianceNode),
    'recorder': (Taking, HeadingTypes, BagSettings, RecorderNode),
    'replayer': (Sending, ReplayerNode),
    'dashboard': (Taking, DashboardNode),
    'alert_sender': (AlertSettings,),
}
"""By executable, the settings that its nodes declare beside those of the analysis."""

TOGETHER = ('synchronizer', 'compliance')
"""The nodes of the executable `intercompare`."""


def _need_source(driver: DriverSettings) -> Address:
    return driver.address


def check_sections(path: str, sections: Mapping[str, Mapping[str, Any]],
                   nodes: Iterable[tuple[str, str]]) -> None:
    """
    Raise SettingsError for a mistake in the section of a node, which could not start with it.

    Parameters
    ----------
    path
        The parameter file, for the message.
    sections
        Sections of the file, by the name of the node.
    nodes
        Executable and name of each node.

    Raises
    ------
    SettingsError
        With the file, the section, and what is wrong, in one line.

    """
    for executable, name in nodes:
        parameters = {key: value for key, value in sections.get(name, {}).items()
                      if key not in OF_ROS}
        names = {settings_class: [rule.name for rule in list_settings(settings_class)]
                 for settings_class in (Settings, *OWN_SETTINGS[executable])}
        known_keys = [key for of_class in names.values() for key in of_class]
        try:
            for settings_class in names:
                parameters = drop_removed(settings_class, parameters)
            for key in parameters:
                if key not in known_keys:
                    raise explain_unknown('parameter', key, known_keys)
            node_settings = [
                from_mapping(settings_class,
                             {key: parameters[key] for key in parameters if key in of_class})
                for settings_class, of_class in names.items()]
            for settings in node_settings:
                if isinstance(settings, DriverSettings):
                    _need_source(settings)
        except SettingsError as error:
            raise SettingsError(f'{path}: section {name!r}: {error}') from error


_SWITCHES = {**dict.fromkeys(('true', 'yes', 'on', '1'), True),
             **dict.fromkeys(('false', 'no', 'off', '0'), False)}
# Seconds after Ctrl-C. The recorder ends after the last verdict, and each node waits at most 9 s.
# Without this `ros2 launch` loses patience after 5.
_END_S = '20'
_NAME = '[A-Za-z_][A-Za-z0-9_]*'
_NAMESPACE = re.compile(f'{_NAME}(/{_NAME})*')
_LEVELS = ('debug', 'info', 'warn', 'error', 'fatal')


def check_path(name: str, text: str, what: str, *, folder: bool = False) -> None:
    """
    Raise SettingsError if an argument names no file that can be read.

    Parameters
    ----------
    name, text
        Name of the argument, for the message, and its value.
    what
        What it must name.
    folder
        A folder will do.

    """
    if not text:
        raise SettingsError(f'{name} is missing: give {name}:=PATH of {what}')
    if not os.path.exists(text):
        raise SettingsError(f'{name}:={text}: does not exist; give the path of {what}')
    if folder and os.path.isdir(text):
        return
    try:
        open(text, 'rb').close()
    except OSError as error:
        raise SettingsError(
            f'{name}:={text}: {error.strerror}; give the path of {what}') from error


def find_misspelt(given: Iterable[str], known: Iterable[str]) -> list[str]:
    """
    Return a line for each argument that looks like a misspelt one; ROS would ignore it silently.

    An argument that looks like none may belong to a launch file that includes this one.

    Parameters
    ----------
    given, known
        The names that were given, and those that the launch file has.

    Examples
    --------
    >>> find_misspelt(['recrod', 'record', 'camera'], ['record', 'respawn'])
    ['recrod:= has no effect; did you mean record:=?']

    """
    known = [*known]
    near = {name: difflib.get_close_matches(name, known, 1, 0.75)
            for name in sorted({*given} - {*known})}
    return [f'{name}:= has no effect; did you mean {matches[0]}:=?'
            for name, matches in near.items() if matches]


def read_switch(name: str, text: str) -> bool:
    """
    Return an argument that is true or false, in any case.

    Parameters
    ----------
    name
        Name of the argument, for the message.
    text
        Value of the argument.

    Raises
    ------
    SettingsError
        If the text is neither.

    Examples
    --------
    >>> read_switch('record', 'True'), read_switch('record', 'off')
    (True, False)

    """
    switch = _SWITCHES.get(text.strip().lower())
    if switch is None:
        raise SettingsError(f'{name}:={text}: must be true or false')
    return switch


def read_number(name: str, text: str) -> float:
    """
    Return an argument that is a number of at least 0.

    Parameters
    ----------
    name
        Name of the argument, for the message.
    text
        Value of the argument.

    Raises
    ------
    SettingsError
        If the text is no such number.

    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 <= number < math.inf:
        raise SettingsError(f'{name}:={text}: must be a number of at least 0')
    return number


def read_namespace(text: str) -> str:
    """
    Return a namespace with its leading slash and without others around it.

    Parameters
    ----------
    text
        The argument `namespace`.

    Raises
    ------
    SettingsError
        If ROS allows no such namespace.

    Examples
    --------
    >>> read_namespace('ship1'), read_namespace('/fleet/ship1/'), read_namespace('/')
    ('/ship1', '/fleet/ship1', '/')

    """
    namespace = text.strip().strip('/')
    if namespace and not _NAMESPACE.fullmatch(namespace):
        raise SettingsError(f'namespace:={text}: must be names of letters, digits and _ that do '
                            'not begin with a digit, with a / between them')
    return f'/{namespace}'


def common_arguments(executable: str, log_level: str, use_sim_time: bool,
                     ) -> tuple[dict[str, Any], dict[str, Any]]:
    """
    Return what every node of a launch file gets.

    Parameters
    ----------
    executable
        The executable, whose enclave the security policy names.
    log_level
        Least level that a node logs.
    use_sim_time
        Whether its clock is `/clock`.

    Returns
    -------
    tuple of dict and dict
        Arguments of `launch_ros.actions.Node`; parameters of the node.

    Raises
    ------
    SettingsError
        If there is no such level.

    """
    if log_level.lower() not in _LEVELS:
        raise SettingsError(f'log_level:={log_level}: must be one of {", ".join(_LEVELS)}')
    words = ['--log-level', log_level.lower()]
    if os.environ.get('ROS_SECURITY_ENABLE') == 'true':
        words += ['--enclave', f'/heading_intercompare/{executable}']
    return ({'ros_arguments': words, 'sigterm_timeout': _END_S},
            {'use_sim_time': True} if use_sim_time else {})


def join_nodes(place: str, config: str, sections: Mapping[str, Mapping[str, Any]],
               own: Mapping[str, Mapping[str, Any]], log_level: str,
               use_sim_time: bool) -> dict[str, Any]:
    """
    Return what the process gets that pairs and judges.

    `launch_ros` gives what stands in a launch file to all nodes of a process, and each refuses
    what belongs to another one. So they get a parameter file, which is removed when this process
    ends.

    Parameters
    ----------
    place
        Namespace of its nodes.
    config
        The parameter file of the user.
    sections
        Its sections, by the name of the node.
    own
        What the launch file sets, by the name of the node.
    log_level, use_sim_time
        As for `common_arguments`.

    Returns
    -------
    dict
        Arguments of `launch_ros.actions.Node`.

    """
    common, shared = common_arguments('intercompare', log_level, use_sim_time)
    descriptor, path = tempfile.mkstemp('.yaml', 'heading_intercompare_')
    atexit.register(Path(path).unlink, missing_ok=True)
    values = {name: {**sections.get(name, {}), **own[name], **shared} for name in TOGETHER}
    with os.fdopen(descriptor, 'w', encoding='utf-8') as file:
        # JSON is YAML, too.
        json.dump({f'{place.rstrip("/")}/{name}': {'ros__parameters': parameters}
                   for name, parameters in values.items() if parameters}, file)
    return {'package': 'heading_intercompare', 'executable': 'intercompare', 'namespace': place,
            'parameters': [config, path], 'output': 'screen', **common}
