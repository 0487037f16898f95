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

"""What a launch file does when one of its nodes ends."""

from __future__ import annotations

from typing import Any, Callable

#: Exit codes of a node: its work is done; a mistake of the user, told in one line.
_DONE, _REFUSED = 0, 2


class NodeFailure(RuntimeError):
    """A node that is needed cannot run: `launch` ends all nodes, and itself with exit code 1."""


class NodeEnd:
    """
    Decides what follows when a node ends: nothing, the end of all, or their end as a failure.

    A node that is refused at its start (exit code 2) is a failure, whatever it does: an address
    that is taken, a second graph. Later, one that starts again may be refused for a while, because
    its device is gone; the others then go on.

    Parameters
    ----------
    name
        The node, for the message.
    over
        Makes the action that ends all when the node has done its work; None: the others go on
        without it.
    respawn
        Whether it starts again when it was killed.

    """

    def __init__(self, name: str, over: Callable[[], Any] | None = None, *,
                 respawn: bool = False) -> None:
        self._name, self._over, self._respawn = name, over, respawn
        self._ends = 0

    def __call__(self, event: Any, context: Any) -> Any:
        """
        Return the action that follows, or None.

        Parameters
        ----------
        event, context
            As `launch` hands them over: the end of the process, and what is known of all.

        Raises
        ------
        NodeFailure
            If all must end with a failure.

        """
        self._ends += 1
        code, is_needed = event.returncode, self._over is not None
        if context.is_shutdown:
            return None
        if code == _REFUSED and (is_needed or self._ends == 1):
            raise NodeFailure(f'{self._name} was refused; its line above says why')
        if code not in (_DONE, _REFUSED) and is_needed and not self._respawn:
            raise NodeFailure(f'{self._name} died with exit code {code}')
        return self._over() if self._over is not None and code == _DONE else None
