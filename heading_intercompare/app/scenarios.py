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

"""Scenario files, found by path, or by name if they come with the package."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from heading_intercompare.ahrs.settings import Scenario
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.special_files import read_once
from heading_intercompare.yaml_file import parse_yaml


class ScenarioFile(NamedTuple):
    """
    A scenario and where it comes from.

    Attributes
    ----------
    scenario
        What to simulate.
    name
        Name of the file, without its folder.
    data
        The bytes of the file.
    folder
        Where it is; names of files in it begin there.

    """

    scenario: Scenario
    name: str
    data: bytes
    folder: Path = Path()


def _folders() -> list[Path]:
    """Return the folders where the scenarios of the package may be, checked out or installed."""
    return [folder / below / 'scenarios' for folder in Path(__file__).resolve().parents
            for below in ('config', 'share/heading_intercompare/config')]


def list_scenarios() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    return sorted({file.stem for folder in _folders() for file in folder.glob('*.yaml')})


def _find(scenario: str) -> Path:
    """Return the path of the file; it may not exist."""
    path = Path(scenario)
    if path.is_file() or path.name != scenario or path.suffix:
        return path
    shipped = [folder / f'{scenario}.yaml' for folder in _folders()]
    shipped_path = next((file for file in shipped if file.is_file()), None)
    if shipped_path is None:
        names = ', '.join(list_scenarios()) or 'of the package, which are not installed'
        raise SettingsError(f'--scenario {scenario}: is neither a file nor one of the scenarios '
                            f'{names}')
    return shipped_path


def read_scenario(path_or_name: str, seed: int | None = None) -> ScenarioFile:
    """
    Read a scenario.

    Parameters
    ----------
    path_or_name
        Path of a YAML file, or the name of one that comes with the package ('demo').
    seed
        Replaces the seed in the file.

    Raises
    ------
    OSError
        If the file cannot be read.
    SettingsError
        If the scenario is wrong; one line with the file, what is wrong and what is allowed.

    """
    path = _find(path_or_name)
    data = read_once(path)
    mapping = parse_yaml(data, path)
    if not isinstance(mapping, dict):
        raise SettingsError(f'{path}: is not a scenario: must hold names and values such as '
                            'duration_s: 1200')
    try:
        scenario = Scenario.from_mapping(mapping)
    except SettingsError as error:
        raise SettingsError(f'{path}: {error}') from error
    if seed is not None:
        scenario = replace(scenario, seed=seed)
    return ScenarioFile(scenario, path.name, data, path.parent)
