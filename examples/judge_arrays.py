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

"""Judge a tested sensor from arrays, without ROS and without files."""

import numpy as np

from heading_intercompare import analyze, Headings, Settings

rng = np.random.default_rng(1)
t_s = np.arange(0.0, 1800.0, 0.1)
heading_deg = 350.0 + 20.0 * np.sin(t_s / 60.0)
stamp_ns = 1_400_000_000_000_000_000 + np.round(t_s * 1e9).astype(np.int64)

ts = Headings.of(stamp_ns, (heading_deg + 0.15 * rng.standard_normal(t_s.size)) % 360.0)
rs = Headings.of(stamp_ns, (heading_deg + 0.05 * rng.standard_normal(t_s.size)) % 360.0)
settings = Settings.from_mapping({'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}})

verdict = analyze(ts, rs, settings)
(run,) = verdict.runs
print(f'{verdict.outcome}: {run.reason}')
print(f'standard deviation {run.std_deg:.4f} deg from {run.n} pairs, worth {run.guarded.nu:.0f} '
      'independent ones')
for assumption in run.assumptions:
    print(f'({assumption.id}) {assumption.state}: {assumption.evidence}')
