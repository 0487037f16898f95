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

"""Verdicts and sketches made by the package from simulated readings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, pair, Settings, Verdict
from heading_intercompare.report import SeriesSketch

BASE = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}


@pytest.fixture
def made(rng):
    """Return a function that makes a verdict on some runs, and their sketches."""
    def make(runs: int, n: int = 600, noise_deg: float = 0.2,
             **settings: Any) -> tuple[Verdict, list[SeriesSketch]]:
        taken = Settings.from_mapping(
            {**BASE, **{k.replace('__', '.'): v for k, v in settings.items()}})
        ts, rs, sketches = [], [], []
        for run in range(runs):
            stamps = (np.arange(n) + 10_000 * run + 1_700_000_000) * 10 ** 9
            true = 180.0 + 170.0 * np.sin(np.arange(n) / 40.0)
            ts.append(Headings.of(stamps, true + 0.05 + rng.normal(0.0, noise_deg, n)))
            rs.append(Headings.of(stamps, true))
            sketches.append(SeriesSketch())
            sketches[-1].update(pair(ts[-1], rs[-1], taken)[0], taken)
        return analyze(ts, rs, taken), sketches
    return make
