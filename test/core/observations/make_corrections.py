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

"""Corrections with given values, for the tests of the room."""

from __future__ import annotations

import numpy as np

from heading_intercompare.core.observations.corrections import Corrections


def corrections(c_minus_o_deg, *, u_deg=0.0, rate_deg_s=0.0, step_deg=None, step_s=60.0):
    """Return corrections that follow each other by `step_s`."""
    x = np.asarray(c_minus_o_deg, float)
    n = x.size
    stamps = (1_773_136_800 + step_s * np.arange(n)).astype(np.int64) * 1_000_000_000
    return Corrections(
        row=np.arange(n), stamp_ns=stamps, true_deg=np.full(n, 90.0), ts_deg=90.0 - x,
        c_minus_o_deg=x, rate_deg_s=np.full(n, rate_deg_s), u_deg=np.full(n, u_deg),
        step_deg=step_deg, not_used={})
