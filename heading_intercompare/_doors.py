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

"""The doors of rooms: they offer names from modules that are loaded at first use."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Callable, Mapping, Sequence

__all__ = ['door']


def door(room: str, modules: Mapping[str, Sequence[str]]
         ) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """
    Return the functions with which a package offers names without loading their modules.

    Parameters
    ----------
    room : str
        Full name of the package.
    modules : mapping of str to sequence of str
        The names offered, by the module of the package that defines them.

    Returns
    -------
    tuple
        `__getattr__`, `__dir__` and `__all__` of the package. `__dir__` also lists names that the
        package adds to `__all__`.

    """
    where = {name: module for module, names in modules.items() for name in names}
    offered = sorted(where)

    def get(name: str) -> Any:
        if name not in where:
            raise AttributeError(f'module {room!r} has no attribute {name!r}')
        return getattr(import_module(f'{room}.{where[name]}'), name)

    return get, lambda: offered, offered
