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

"""Nodes and weights of the Gauss-Legendre quadrature."""

from __future__ import annotations

from functools import cache

import numpy as np

from heading_intercompare.core.records import Reals


@cache
def gauss_legendre(n: int) -> tuple[Reals, Reals]:
    """Return n nodes in [-1, 1] and their weights, whose sum is 2; do not change them."""
    # This part of numpy takes milliseconds to load, and nobody needs it before a judgement.
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return nodes, weights
