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

"""The one error for messages: what is wrong with bytes, fields or definitions, in one line."""

from __future__ import annotations

from typing import Sequence


class MessageError(ValueError):
    """
    A message, or the definition of its type, cannot be read or written.

    Parameters
    ----------
    problem
        What is wrong, and what is allowed.
    offset
        First byte of the message in the data that holds it.
    offsets
        The same of all messages with this problem, if there are several.

    """

    def __init__(self, problem: str, offset: int | None = None,
                 offsets: Sequence[int] = ()) -> None:
        super().__init__(problem + ('' if offset is None else f' (at byte {offset})'))
        self.problem = problem
        self.offset = offset
        self.offsets = offsets
