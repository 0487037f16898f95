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

"""The nodes `synchronizer` and `compliance` in one process: one fate, and one journal."""

from __future__ import annotations

from typing import Sequence

from rclpy.context import Context

from heading_intercompare.nodes.launching.process import run

from .compliance import Compliance
from .synchronizer import Synchronizer


def main(args: Sequence[str] | None = None) -> int:
    """Run both nodes; the synchronizer ends first, and has then given all its pairs."""
    def make(context: Context) -> Synchronizer:
        return Synchronizer(Compliance(pairs_here=True, context=context), context=context)
    return run('intercompare', make, args, beside=lambda synchronizer, context: synchronizer.judge)
