# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""YAML files, their mistakes told in one line."""

from __future__ import annotations

from pathlib import Path
import re
from typing import Any

import yaml

from heading_intercompare.core.settings import SettingsError

__all__ = ['load_yaml', 'parse_yaml']


class _Loader(yaml.SafeLoader):
    """Reads numbers as YAML 1.2 and ROS do: 1e9 is one, and needs no point or sign."""


_Loader.add_implicit_resolver(
    'tag:yaml.org,2002:float', re.compile(r'[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$'),
    list('-+.0123456789'))


def load_yaml(text: str) -> Any:
    """
    Return what YAML text holds.

    Raises
    ------
    yaml.YAMLError
        If it is not YAML.

    Examples
    --------
    >>> load_yaml('[1e9, 2.5E-3, 1e, 7]')
    [1000000000.0, 0.0025, '1e', 7]

    """
    # A loader derived from the safe one makes nothing but plain values.
    return yaml.load(text, Loader=_Loader)


def parse_yaml(data: bytes, path: str | Path) -> Any:
    """
    Return what a YAML file holds.

    Raises
    ------
    SettingsError
        If it is not YAML: the file, the line, the problem.

    """
    try:
        return load_yaml(data.decode())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, 'problem_mark', None)
        where = f', line {mark.line + 1}' if mark else ''
        problem = getattr(error, 'problem', None) or 'not text'
        raise SettingsError(f'{path}{where}: not YAML: {problem}') from error
