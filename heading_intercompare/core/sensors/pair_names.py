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

"""The names of two sensors that are compared."""

from __future__ import annotations

from typing import Iterable

#: The names of the sensors of a pair; the reference is the second one.
Names = tuple[str, str]

TWO: Names = ('ts', 'rs')
"""The names of two sensors without the setting `sensors`."""


def list_names(pairs: Iterable[Names]) -> list[str]:
    """Return the names of the sensors in some pairs, each once."""
    return [*dict.fromkeys(name for names in pairs for name in names)]
