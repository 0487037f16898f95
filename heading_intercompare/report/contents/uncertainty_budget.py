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

"""The uncertainty budget of a run: each source, and what it adds to mean and variance."""

from __future__ import annotations

import math

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import RunVerdict
from heading_intercompare.report.formatting import ABSENT, bounds, number, rounded, with_unit

from .defaults import mark_default
from .holding import is_sound, upper_bound_holds, worth_of
from .tables import Table

#: Coverage factor of the expanded uncertainty, some 95 % of a normal distribution.
_COVERAGE = 2

_HEAD = ('source', 'what is known', 'type', 'standard uncertainty of the mean [deg]',
         'effect on the variance [deg²]')


def budget_of(run: RunVerdict, settings: Settings) -> Table:
    """
    Return the budget of a run.

    Every standard uncertainty has two significant digits. A dash says that a source adds nothing
    that is known. Type A is evaluated from the readings, type B from other knowledge.

    Parameters
    ----------
    run
        The judged run.
    settings
        With the norm of the RS.

    """
    guarded, pairing = run.guarded, run.pairing
    u_offset = settings.installation_offset_u_deg
    u_mean = guarded.bias_u_deg
    sampling = None if u_mean is None else math.sqrt(max(0.0, u_mean ** 2 - u_offset ** 2))
    low, up = _reference(settings)
    rounding = run.normality.rounding_variance_deg2
    rows = [
        ['sampling', _sampling(run), 'A',
         _two(sampling), f'the variance is {_bounds_of(run)}'],
        ['reference sensor, sigma_ref',
         f'from {number(low, 4)} to {number(up, 4)} deg' if low != up
         else f'known, {number(low, 4)} deg', 'B', ABSENT,
         f'{number(low ** 2, 4)} to {number(up ** 2, 4)}' if low != up else number(low ** 2, 4)],
        ['resolution of both sensors',
         f'steps of the TS: {_step(run.normality.ts_step_deg)}; of the RS: '
         f'{_step(run.normality.rs_step_deg)}', 'B', ABSENT, _two(rounding)],
        ['timing', _timing(run), 'A', ABSENT, _two(_added_by_skew(run))],
        ['interpolation',
         f'white noise keeps {number(pairing.ts_variance_factor, 3)} (TS) and '
         f'{number(pairing.rs_variance_factor, 3)} (RS) of its variance', 'A', ABSENT,
         'in the acceptance limit'],
        ['installation angle',
         mark_default(f'{number(settings.installation_offset_deg, 6)} deg', settings,
                      'installation_offset_deg', 'installation_offset_u_deg'), 'B',
         _two(u_offset), ABSENT],
        ['together', 'root of the sum of squares', '', _two(u_mean), ABSENT],
        ['expanded uncertainty', f'{_COVERAGE} times that: k = {_COVERAGE}', '',
         _two(None if u_mean is None else _COVERAGE * u_mean), ABSENT]]
    return Table(_HEAD, rows)


def _sampling(run: RunVerdict) -> str:
    worth = worth_of(run)
    return (f'{run.n} differences are worth '
            f'{"an unknown number of" if worth is None else _two(worth)} independent ones for the '
            'variance')


def _step(step_deg: float | None) -> str:
    return 'none seen' if step_deg is None else f'{number(step_deg, 4)} deg'


def _two(u: float | None) -> str:
    """Return a figure with two significant digits; zero is a dash."""
    return rounded(u, u) if u else ABSENT


def _reference(settings: Settings) -> tuple[float, float]:
    """Return the bounds of the RS standard deviation, degrees."""
    limits = Limits.of(settings.norms, settings.model)
    return (limits.m_low * limits.sigma_ref_max_deg, limits.m_up * limits.sigma_ref_max_deg)


def _bounds_of(run: RunVerdict) -> str:
    guarded = run.guarded
    if not is_sound(run) or guarded.lower_bound_deg2 is None:
        return 'not bounded'
    if not upper_bound_holds(run):
        return f'at least {number(guarded.lower_bound_deg2, 2)}'
    return bounds(guarded.lower_bound_deg2, guarded.upper_bound_deg2)


def _timing(run: RunVerdict) -> str:
    skew = run.skew.estimate
    if skew.skew_s is None or skew.u_s is None:
        return 'latency and clock offset of the stamps are not known'
    return (f'latency or clock offset {rounded(skew.skew_s, skew.u_s)} s, standard uncertainty '
            f'{_two(skew.u_s)} s; rate of turn '
            f'{with_unit(number(skew.rate_std_deg_s, 2), "deg/s")}')


def _added_by_skew(run: RunVerdict) -> float | None:
    """Return what the skew adds to the variance: skew times rate of turn, squared."""
    skew = run.skew.estimate
    if skew.skew_s is None or skew.u_s is None or skew.rate_std_deg_s is None:
        return None
    return (skew.skew_s ** 2 + skew.u_s ** 2) * skew.rate_std_deg_s ** 2
