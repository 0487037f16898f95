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

"""Rows of a logbook with made-up figures."""

from __future__ import annotations

from heading_intercompare.logbook.run_row import RunRow

DAY_NS = 86_400_000_000_000
T0_NS = 20_000 * DAY_NS


def make_row(day: int = 0, **given) -> RunRow:
    """Return the row of a run of a day."""
    figures = {
        'ship': 'MV Example', 'start_ns': T0_NS + day * DAY_NS,
        'end_ns': T0_NS + (day + 1) * DAY_NS - 1_000_000_000, 'n': 86400,
        'outcome': 'compliant', 'reason': 'upper_bound_within_acceptance_limit',
        'headline': 'COMPLIANT', 'validity_effect': 'holds', 'conditions': '', 'mean_deg': 0.1,
        'mean_u_deg': 0.01, 'sd_deg': 0.2, 'nu': 400.0, 'lower_bound_deg2': 0.03,
        'upper_bound_deg2': 0.05, 'acceptance_limit_deg2': 0.09, 'rejection_limit_deg2': 0.1,
        'skew_s': None, 'paired': 86400, 'ts_received': 86400, 'ts_unpaired': 0,
        'ts_rejected': 0, 'rs_received': 86400, 'rs_unused': 0, 'rs_rejected': 0,
        'source': 'live', 'bag': None, 'settings_sha256': 'a' * 64, 'rule_version': 2,
        'software_version': '0.1.0'}
    return RunRow(**{**figures, **given})
