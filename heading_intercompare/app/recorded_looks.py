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

"""The looks by which recordings were judged live, so that they are judged by the same again."""

from __future__ import annotations

import os
from typing import Any, Mapping, Sequence

from heading_intercompare.bags.rosbag2.bag_reader import BagReader
from heading_intercompare.bags.rosbag2.provenance import read_settings
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.journal.journal_file import is_journal
from heading_intercompare.yaml_file import load_settings

from .config import Config, unstated
from .inputs import read_settings_of_journal

_PLAN, _LOOKS = 'sequential.plan_s', 'sequential.looks'


def find_looks(config: Config, assignments: Sequence[str],
               inputs: Sequence[str]) -> dict[str, Any]:
    """
    Return the looks by which inputs were judged live, by setting, as far as none are stated.

    Parameters
    ----------
    config, assignments
        What the user states; see `settings_for`.
    inputs
        Recordings and others, of which only bags and journals of this program were judged live.

    Returns
    -------
    dict
        Empty if a plan is stated, or if no input was judged with looks. One that was judged
        without them does not count: looks keep the risks of a single decision, too.

    Raises
    ------
    SettingsError
        If the looks of two inputs differ.

    """
    if not unstated({_PLAN: None}, config, assignments):
        return {}
    first = ''
    looks: dict[str, Any] = {}
    for path in inputs:
        recorded = _read_looks(path)
        if recorded.get(_PLAN) is None:
            continue
        if looks and recorded != looks:
            raise SettingsError(
                f'{path}: was judged live with other looks than {first}: {_PLAN} = '
                f'{recorded[_PLAN]}, {_LOOKS} = {recorded[_LOOKS]}, not {looks[_PLAN]}, '
                f'{looks[_LOOKS]}; choose those for all with --set {_PLAN}=...')
        first, looks = path, recorded
    return unstated(looks, config, assignments)


def _read_looks(path: str) -> dict[str, Any]:
    """Return the looks that an input holds; the judging names an input that cannot be read."""
    if not os.path.isfile(path) and not os.path.isdir(path):
        # A pipe can be read only once, by the judging.
        return {}
    try:
        stored: Mapping[str, Any] = {}
        if is_journal(path):
            stored = read_settings_of_journal(path)
        else:
            # What is no bag of MCAP says so by its first bytes.
            stored = {name: load_settings(value) for name, value in
                      read_settings(BagReader(path)).items() if name in (_PLAN, _LOOKS)}
    except (OSError, ValueError):
        return {}
    looks = {name: stored.get(name) for name in (_PLAN, _LOOKS)}
    return {name: None if value == 'none' else value for name, value in looks.items()}
