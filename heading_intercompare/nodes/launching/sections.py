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

"""The sections of a parameter file, checked before the launch files start any node."""

from __future__ import annotations

from typing import Any, Iterable, Mapping

from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.declared_settings import (
    explain_unknown,
    from_mapping,
    list_settings,
    SettingsError,
)
from heading_intercompare.core.settings import Settings
from heading_intercompare.drivers.settings import Address, DriverSettings
from heading_intercompare.nodes.ros.parameters import OF_ROS
from heading_intercompare.nodes.settings import (
    ComplianceNode,
    DashboardNode,
    DriverNode,
    HeadingTypes,
    RecorderNode,
    ReplayerNode,
    Sending,
    SensorsNode,
    SynchronizerNode,
    Taking,
)

_DRIVER = (DriverSettings, Sending, Taking, DriverNode)
OWN_SETTINGS: dict[str, tuple[type, ...]] = {
    'nmea_driver': _DRIVER,
    'motion_driver': _DRIVER,
    'synchronizer': (Taking, HeadingTypes, SynchronizerNode),
    'compliance': (Taking, ComplianceNode),
    'sensors_watch': (Taking, HeadingTypes, SensorsNode),
    'recorder': (Taking, HeadingTypes, BagSettings, RecorderNode),
    'replayer': (Sending, ReplayerNode),
    'dashboard': (Taking, DashboardNode),
}
"""By executable, the settings that its nodes declare beside those of the analysis."""


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
