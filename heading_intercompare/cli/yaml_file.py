# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""YAML files, their mistakes told in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from heading_intercompare.core.settings import SettingsError

__all__ = ['parse_yaml']


def parse_yaml(data: bytes, path: str | Path) -> Any:
    """
    Return what a YAML file holds.

    Raises
    ------
    SettingsError
        If it is not YAML: the file, the line, the problem.

    """
    try:
        return yaml.safe_load(data.decode())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'not text'
        raise SettingsError(f'{path}{where}: not YAML: {problem}') from error
