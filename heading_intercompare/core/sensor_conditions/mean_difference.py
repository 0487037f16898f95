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

"""The condition that the mean difference is small enough for sensors mounted parallel."""

from __future__ import annotations

from heading_intercompare.core.conditions.conventions import estimate_mean_difference
from heading_intercompare.core.conditions.partings import cut_spans
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined

LARGE_SIGMAS = 3.0
"""A mean difference above this multiple of sigma_max is doubtful."""

COVERED_SIGMAS = 3.0
"""A stated installation angle explains a mean difference within this many of its standard
uncertainties."""


def _judge(e: Examined) -> Finding:
    # Sensors that part for a while have a finding of their own.
    spans_ns = [(parting.start_ns, parting.end_ns) for parting in e.columns.partings]
    _, x_deg = cut_spans(e.columns.stamp_ns, e.columns.x_deg, spans_ns)
    mean, settings = estimate_mean_difference(x_deg), e.settings
    if mean.mean_deg is None:
        return MEAN_DIFFERENCE.find(NOT_TESTABLE, '', 'there is no mean difference')
    words = f'the mean difference is {mean.mean_deg:.2f} deg'
    most = settings.detectors.mean_max_deg
    u_offset = settings.installation_offset_u_deg
    if abs(mean.mean_deg) > max(most, COVERED_SIGMAS * u_offset):
        return MEAN_DIFFERENCE.find(
            VOID, words, f'{words}, above {most:g} deg, and the stated '
            f'installation angle, {settings.installation_offset_deg:g} deg with a '
            f'standard uncertainty of {u_offset:g} deg, does not explain it')
    large_deg = LARGE_SIGMAS * e.limits.sigma_max_deg
    if mean.surely_exceeds(large_deg):
        return MEAN_DIFFERENCE.find(DOUBTFUL, words, f'{words}, significantly above '
                                    f'{LARGE_SIGMAS:g} sigma_max = {large_deg:.3g} deg')
    return MEAN_DIFFERENCE.find(HOLDS, '', words)


MEAN_DIFFERENCE = Condition(
    name='mean_difference',
    holds='the mean difference is small enough for sensors mounted parallel',
    void='void: the mean difference is too large for sensors mounted parallel, and the stated '
         'installation angle does not explain it',
    void_when='the part that the stated installation angle does not explain exceeds '
              '`detectors.mean_max_deg` (15°) and 3 standard uncertainties of that angle',
    void_why='the sensors do not point along one axis',
    doubtful_when='it significantly exceeds 3 σ_max',
    judge=_judge, is_permanent=True)
