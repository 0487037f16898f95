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

"""Errors and notes as a caller in Python reads them: parameters instead of options."""

from __future__ import annotations

from contextlib import contextmanager
import re
from typing import Iterator

from heading_intercompare.core.declared_settings import list_settings
from heading_intercompare.drivers.settings import DriverSettings

_DRIVER = frozenset(rule.name for rule in list_settings(DriverSettings))
_OPTION = re.compile(r'(?<![\w-])--(?:(ts|rs)(?:-([a-z-]+))?|([a-z][a-z-]*))(?![\w-])')


def speak_python(text: str) -> str:
    """
    Return a message with the parameters of Python instead of the options of the command line.

    Examples
    --------
    >>> speak_python('apart with --ts-talker; shift with --set alignment.skew_s=2.0')
    'apart with ts_driver.talker; shift with settings alignment.skew_s=2.0'
    >>> speak_python('name it with --time-column; choose with --ts and --rs')
    'name it with ts_driver.time_column or rs_driver.time_column; choose with settings ts_topic \
and settings rs_topic'

    """
    return _OPTION.sub(_name_parameter, text)


def _name_parameter(match: re.Match[str]) -> str:
    role, own, shared = match.groups()
    name = (own or shared or 'topic').replace('-', '_')
    if role:
        return f'{role}_driver.{name}' if name in _DRIVER and own else f'settings {role}_{name}'
    if name in _DRIVER:
        return f'ts_driver.{name} or rs_driver.{name}'
    return 'settings' if name in ('set', 'config') else name


@contextmanager
def python_words() -> Iterator[None]:
    """Let a ValueError that passes name parameters of Python."""
    try:
        yield
    except ValueError as error:
        error.args = tuple(speak_python(part) if isinstance(part, str) else part
                           for part in error.args)
        raise
