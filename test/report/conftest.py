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

import pytest
from trials import make_settings, make_turning_ship

from heading_intercompare import analyze, pair, Verdict
from heading_intercompare.report import SeriesSketch


@pytest.fixture
def made(rng):
    """Return a function that makes a verdict on some runs, and their sketches."""
    def make(runs: int, n: int = 600, noise_deg: float = 0.2,
             **settings: Any) -> tuple[Verdict, list[SeriesSketch]]:
        rules = make_settings(**settings)
        trials = [make_turning_ship(run, 0.05 + rng.normal(0.0, noise_deg, n))
                  for run in range(runs)]
        sketches = [SeriesSketch() for _ in trials]
        for sketch, trial in zip(sketches, trials):
            sketch.update(pair(*trial, rules)[0], rules)
        return analyze([ts for ts, _ in trials], [rs for _, rs in trials], rules), sketches
    return make
