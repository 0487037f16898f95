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

"""The condition that both sensors report headings by the same convention."""

from __future__ import annotations

from heading_intercompare.core.conditions.conventions import (
    estimate_mean_difference,
    find_convention,
)
from heading_intercompare.core.validity.condition import (
    Condition,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import Examined

_YAWED_DEG = 5.0


def _judge(e: Examined) -> Finding:
    c, settings = e.columns.at_one_time, e.settings
    convention = find_convention(
        c.x_deg, c.rs_deg, settings.detectors.convention_tolerance_deg, stamp_ns=c.stamp_ns,
        range_s=settings.alignment.skew_range_s,
        tracks=c.tracks if c is e.columns else None)
    angle_deg = convention.angle_deg
    if convention.kind == 'not_testable' or angle_deg is None:
        return CONVENTION.find(NOT_TESTABLE, '', 'there are no differences')
    if convention.kind == 'offset':
        return CONVENTION.find(VOID, f'TS - RS is near {angle_deg:.0f} deg',
                               f'TS - RS is {angle_deg:.2f} deg: does one of them report yaw '
                               '(ENU) as heading, or is one mounted backwards?')
    if convention.kind == 'mirrored':
        # If the ship only yawed, another explanation remains.
        late = (', or is late by half a period of the yaw'
                if convention.turned_deg < _YAWED_DEG else '')
        return CONVENTION.find(VOID, 'TS turns against RS', 'TS turns against RS, and their '
                               f'sum stays at {angle_deg:.1f} deg: one of them counts '
                               f'counter-clockwise{late}')
    mean = estimate_mean_difference(e.columns.x_deg)
    if mean.is_torn(settings.wrap_center_deg):
        return CONVENTION.find(
            VOID, 'the differences lie on the seam of wrap_center_deg',
            'the differences are wrapped to within 180 deg of '
            f'{settings.wrap_center_deg:g} deg, which splits them: they lie '
            f'about {mean.mean_deg:.2f} deg, {100.0 * mean.seam_share:.3g} % of them a '
            'whole turn away from the others')
    if convention.direction == 'not_testable':
        return CONVENTION.find(NOT_TESTABLE, '', 'the ship did not move enough to show '
                               'whether both count clockwise, or only in a swell, in which a '
                               'latency looks the same')
    return CONVENTION.find(HOLDS, '', 'TS turns with RS, by the same axes')


CONVENTION = Condition(
    name='convention',
    holds='both sensors use the same heading convention',
    void='void: the sensors report headings by different conventions, or the wrap splits the '
         'differences',
    void_when='the difference is near 90°, −90° or 180°, or the TS turns opposite to the RS; or '
              'the differences lie on the seam of `wrap_center_deg`',
    void_why='a yaw is treated as a heading, or an axis is reversed; a wrap amid the differences '
             'creates a variance of its own',
    judge=_judge, is_permanent=True, watched_by=('rotated', 'mirrored'))
