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

"""Comparison of verdicts: counts and words exactly, figures closely, sources not at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Norms, Settings
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.core.verdict.verdict_document import Input


@pytest.fixture(scope='module')
def verdict():
    """Return a verdict on one run."""
    rng = np.random.default_rng(1)
    stamps = np.arange(1, 601) * 10 ** 9
    return analyze(Headings.as_sent(stamps, 90.0 + 0.1 * rng.standard_normal(600)),
                   Headings.as_sent(stamps, np.full(600, 90.0)),
                   Settings(norms=Norms(sigma_max_deg=0.2, sigma_ref_max_deg=0.1)))


def test_where_the_data_came_from_makes_no_difference(verdict):
    run = verdict.runs[0]
    other = replace(verdict, inputs=[Input('there')], runs=[
        replace(run, source='there', mean_deg=run.mean_deg * (1.0 + 1e-13))])
    assert list(find_differences(verdict, other)) == []


def test_every_difference_is_named(verdict):
    run = verdict.runs[0]
    assert list(find_differences(verdict, replace(verdict, headline='x', runs=[
        replace(run, n=3, duration_s=599.5, warnings=('y',))]))) == [
            f"headline: {verdict.headline!r} and 'x'", 'runs[0].duration_s: 599.0 and 599.5',
            'runs[0].n: 600 and 3', f"runs[0].warnings: {[*run.warnings]!r} and ['y']"]
    (found,) = find_differences(verdict, replace(verdict, runs=[]))
    assert found.startswith("runs: [{'run': 1, ")
