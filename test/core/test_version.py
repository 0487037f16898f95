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

"""The version of the decision rule increases when the rule decides differently."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.version import RULE_VERSION

S = 1_000_000_000


def differences(kind: str, n: int = 6000) -> np.ndarray:
    """Return differences of one kind, degrees."""
    rng = np.random.default_rng(5)
    if kind == 'white':
        return rng.normal(0.0, 0.2, n)
    if kind == 'loud':
        return rng.normal(0.0, 0.6, n)
    if kind == 'slow':
        return lfilter([np.sqrt(1.0 - 0.98 ** 2)], [1.0, -0.98], rng.normal(0.0, 0.25, n))
    return rng.standard_t(8.0, n) * 0.25


# To be renewed together with RULE_VERSION, of which the first column tells.
@pytest.mark.parametrize('rule, kind, outcome, reason, nu, lower_deg2, upper_deg2', [
    (1, 'white', 'compliant', 'upper_bound_within_acceptance_limit', 3684.0697118618336,
     0.03857881846602693, 0.04453915200022388),
    (1, 'loud', 'non_compliant', 'lower_bound_above_rejection_limit', 3684.0697118619,
     0.3472093661942422, 0.40085236800201923),
    (1, 'slow', 'compliant', 'upper_bound_within_acceptance_limit', 189.25875653419513,
     0.046591742661007365, 0.07354393812085472),
    (1, 'heavy', 'indeterminate', 'data_limited', 1637.6761250291897,
     0.08070667152514643, 0.09731121947150415),
])
def test_the_rule_of_this_version_decides_so(rule, kind, outcome, reason, nu, lower_deg2,
                                             upper_deg2):
    assert rule == RULE_VERSION, 'renew the table together with RULE_VERSION'
    stamps = (np.arange(6000) + 1_700_000_000) * S
    true = 180.0 + 120.0 * np.sin(np.arange(6000) / 90.0)
    settings = Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'alignment.skew': 'off'})
    run = analyze(Headings.of(stamps, true + differences(kind)), Headings.of(stamps, true),
                  settings).runs[0]
    found = run.guarded
    assert (run.outcome.value, run.reason) == (outcome, reason)
    assert (found.nu, found.lower_bound_deg2, found.upper_bound_deg2) == pytest.approx(
        (nu, lower_deg2, upper_deg2), rel=1e-9)
