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

"""The parts of scipy, which take long to load: each is loaded when one of its names is used."""

from __future__ import annotations

from typing import Any

_PARTS = 'fft', 'linalg', 'optimize', 'signal', 'special'


def __getattr__(name: str) -> Any:
    """Load a part of scipy; it is then found without this call."""
    if name not in _PARTS:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    import scipy
    part = globals()[name] = getattr(scipy, name)
    return part
