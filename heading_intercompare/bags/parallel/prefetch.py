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

"""An iterator that runs in its own thread, a little ahead of its caller."""

from __future__ import annotations

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Iterator, TypeVar

__all__ = ['run_ahead']

#: Items that are ready or in preparation while the caller uses one.
_AHEAD = 2

_Item = TypeVar('_Item')


def run_ahead(items: Iterator[_Item]) -> Iterator[_Item]:
    """
    Yield the items of an iterator that runs in a second thread.

    If the iterator raises, the error follows the items it yielded before.
    """
    # Any, because `is not` tells it from the items.
    end: Any = object()
    with ThreadPoolExecutor(1) as worker:
        coming = deque(worker.submit(next, items, end) for _ in range(_AHEAD))
        while (item := coming.popleft().result()) is not end:
            coming.append(worker.submit(next, items, end))
            yield item
