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

"""The node `motion_driver`: the motion of the ship from a source of its own."""

from __future__ import annotations

from typing import Any, Sequence

from heading_intercompare.nodes.launching.process import run
from heading_intercompare.nodes.sending.publishing import Audience
from heading_intercompare.nodes.sending.source_thread import ReadingNode


class MotionDriver(ReadingNode):
    """Publish the motion in the sentences of a source, whatever headings they tell."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('motion_driver', 'motion', **kwargs)
        self._open(alone=True)
        if self._reading.from_file:
            self._motion.open()
        publishers = self._motion.publishers
        self._audience = Audience(self, publishers, self._sending.subscribers if publishers else 0,
                                  self.health)
        self._watch()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node."""
    return run('motion_driver', MotionDriver, args)
