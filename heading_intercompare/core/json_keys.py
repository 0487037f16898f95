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

"""Which fields of a dataclass are keys of the JSON of a verdict."""

from __future__ import annotations

from dataclasses import field, fields
from typing import Any

__all__ = ['is_left_out', 'leave_out_none', 'list_keys', 'no_key']

_LEFT_OUT = 'left_out'
_NO_KEY = 'no_key'


def leave_out_none() -> Any:
    """Declare a field of a dataclass whose key is left out if its value is None."""
    return field(default=None, metadata={_LEFT_OUT: True})


def no_key() -> Any:
    """Declare a field of a dataclass that is no key of the JSON, and None when read."""
    return field(default=None, compare=False, repr=False, metadata={_NO_KEY: True})


def list_keys(kind: Any) -> list[Any]:
    """Return the fields of a dataclass, or of an instance, that are keys of the JSON."""
    return [f for f in fields(kind) if not f.metadata.get(_NO_KEY, False)]


def is_left_out(declared: Any, value: Any) -> bool:
    """Tell whether the key of a field, from `dataclasses.fields`, is left out."""
    return value is None and declared.metadata.get(_LEFT_OUT, False)
