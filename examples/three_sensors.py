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

"""Three sensors on one ship: the error of each, without a reference."""

import numpy as np

from heading_intercompare import Headings, three_cornered_hat
from heading_intercompare.core.diagnostics.three_cornered_hat import at_common_stamps

rng = np.random.default_rng(2)
NAMES, SIGMA_DEG, RATE_HZ = ('gyro', 'seapath', 'gnss'), (0.20, 0.05, 0.10), (10.0, 1.0, 5.0)


def sensor(sigma_deg: float, rate_hz: float) -> Headings:
    """Return an hour of headings with white errors."""
    t_s = np.arange(0.0, 3600.0, 1.0 / rate_hz)
    heading_deg = 100.0 + 10.0 * np.sin(t_s / 300.0) + sigma_deg * rng.standard_normal(t_s.size)
    return Headings.of(10**18 + np.round(t_s * 1e9).astype(np.int64), heading_deg)


stamp_ns, heading_deg = at_common_stamps([sensor(s, r) for s, r in zip(SIGMA_DEG, RATE_HZ)])
hats = three_cornered_hat(heading_deg, stamp_ns)
for name, sigma_deg, (low, high) in zip(NAMES, hats.std_deg, hats.interval_deg2 or ()):
    print(f'{name}: {sigma_deg:.3f} deg, variance {low:.5f} .. {high:.5f} deg2')
print('interpolation reduces the noise of all sensors but the first')
