# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
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
