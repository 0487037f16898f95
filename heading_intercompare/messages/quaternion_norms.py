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

"""Whether quaternions are rotations: their norm is 1, or they say that nothing is known."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.records import Integers, Reals

from .byte_columns import refuse_messages

_MOST_OFF = 0.01
"""tf2 and RViz take squares of norms that differ from 1 by less than this, for rounding."""


def find_off_norm(quaternions: Reals) -> np.ndarray:
    """
    Tell which quaternions are no rotations, though they are finite and not zero.

    Parameters
    ----------
    quaternions : ndarray, shape (4, n)
        x, y, z and w.

    Returns
    -------
    ndarray of bool, shape (n,)
        Zero and what is not finite mean that the heading is unknown: False.

    Examples
    --------
    >>> find_off_norm(np.array([[0.0, 0.0, 0.0, 1.004], [0.0, 0.0, 0.0, 0.5], [0.0] * 4]).T)
    array([False,  True, False])

    """
    with np.errstate(over='ignore', invalid='ignore'):
        norm2 = np.einsum('ij,ij->j', quaternions, quaternions)
        off_norm: np.ndarray = (
            (np.abs(norm2 - 1.0) >= _MOST_OFF) & (norm2 > 0.0) & (norm2 < np.inf))
    return off_norm


def check_norms(type_name: str, start: Integers, quaternions: Reals,
                has_orientation: np.ndarray | bool = True) -> None:
    """Raise MessageError for the messages with an orientation whose norm is not 1."""
    off_norm = find_off_norm(quaternions) & has_orientation
    refuse_messages(type_name, start, off_norm, lambda first: (
        f'has a quaternion of norm {np.linalg.norm(quaternions[:, first]):.3g}: must be 1'))
