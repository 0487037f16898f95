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

"""Whether two verdicts on several sensors are the same."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Iterator

from heading_intercompare.core.verdict.compare_verdicts import compare_plain, drop_sources

from .sensors_verdict import SensorsVerdict

__all__ = ['find_sensor_differences']


def find_sensor_differences(a: SensorsVerdict, b: SensorsVerdict) -> Iterator[str]:
    """
    Yield the differences of two verdicts, except those of their sources.

    Yields
    ------
    str
        One difference with the names of the JSON, as `find_differences`.

    """
    yield from compare_plain(_drop_sources(a), _drop_sources(b))


def _drop_sources(verdict: SensorsVerdict) -> dict[str, Any]:
    return replace(verdict, inputs=(), verdicts={
        name: drop_sources(of_pair) for name, of_pair in verdict.verdicts.items()}).to_dict()
