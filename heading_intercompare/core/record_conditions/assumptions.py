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

"""The condition that no assumption of GK that the data refute decides the outcome."""

from __future__ import annotations

from typing import Callable, Mapping

from heading_intercompare.core.decision.error_models import ERROR_MODELS
from heading_intercompare.core.diagnostics.assumptions import model_kurtosis, VIOLATED
from heading_intercompare.core.diagnostics.deviation import deviation_at
from heading_intercompare.core.diagnostics.run_columns import HIGHEST_ORDER_REMOVED
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.statistics.drift import remove_polynomial
from heading_intercompare.core.validity.condition import Condition, DOUBTFUL, Finding, HOLDS
from heading_intercompare.core.validity.examined import Examined

#: A way in which an assumption is mended: words, and the outcome of the run with it mended.
_Mended = tuple[str, Outcome]


def _mend_mean(e: Examined) -> _Mended | None:
    """Take the mean for what variant B takes it: an offset, or an error that is not judged."""
    interval = e.guarded.bias_interval_deg
    if interval is None:
        return None
    mean_deg = 0.5 * (interval[0] + interval[1])
    return (f'the mean difference is {mean_deg:.2g} deg, and variant A takes it for zero; by '
            'variant B', e.decide(e.columns.stamp_ns, e.columns.x_deg, variant='B'))


def _mend_moments(e: Examined) -> _Mended | None:
    """Remove what depends on the heading, otherwise the drift."""
    c, dependence, order = e.columns, e.diagnostics.heading_dependence, e.diagnostics.drift.order
    if 'depends on the heading' in _evidence_of(e, 'h'):
        rest = e.decide(c.stamp_ns, c.x_deg - deviation_at(dependence, c.rs_deg)[0])
        return (f'the difference depends on the heading, by up to {dependence.amplitude_deg:.2g} '
                'deg, without that', rest)
    if order is None or not order.order or c.residual_deg is not None:
        return None
    drift = remove_polynomial(c.stamp_ns, c.x_deg, min(order.order, HIGHEST_ORDER_REMOVED))
    return (f'the difference drifts, with a drift of order {drift.order} removed (drift_order)',
            e.decide(c.stamp_ns, drift.residual_deg))


def _mend_laws(e: Examined) -> _Mended | None:
    """Take a model of the distributions that fits better, if it gives another outcome."""
    c, model = e.columns, e.settings.model
    kurtosis = e.diagnostics.normality.difference.excess_kurtosis
    if kurtosis is None:
        return None
    share = min(1.0, c.limits.sigma_ref_max_deg ** 2 / c.limits.limit_deg2)
    misfit = {name: abs(kurtosis - model_kurtosis(name, share)) for name in ERROR_MODELS}
    for name in sorted(misfit, key=lambda name: misfit[name]):
        if misfit[name] >= misfit[model]:
            break
        outcome = e.decide(c.stamp_ns, c.x_deg, model=name)
        if outcome is not e.outcome:
            return f'the errors do not follow the model {model}, by model {name}', outcome
    return None


_MENDERS: Mapping[str, Callable[[Examined], _Mended | None]] = {
    'e': _mend_mean, 'h': _mend_moments, 'j': _mend_laws}
"""
Assumptions that can be mended. Conditions of their own have (b), (d) and (i). A warm-up (c) is so
rare an event in its run that it never decides one; the reason of an open run names it.
"""


def _evidence_of(e: Examined, key: str) -> str:
    return next(a.evidence for a in e.diagnostics.assumptions if a.id == key)


def _judge(e: Examined) -> Finding:
    violated = [a.id for a in e.diagnostics.assumptions if a.state == VIOLATED]
    words = []
    if e.outcome is not Outcome.INDETERMINATE:
        for key in violated:
            mended = _MENDERS[key](e) if key in _MENDERS else None
            # A mean beside zero is what variant A certifies away: whatever B says.
            if mended is not None and (mended[1] is not e.outcome
                                       or key == 'e' and e.outcome is Outcome.COMPLIANT):
                words.append(f'{mended[0]} {mended[1].words}')
    listed = ', '.join(f'({key})' for key in violated)
    if words:
        return ASSUMPTIONS.find(DOUBTFUL, '; '.join(words), f'violated: {listed}; '
                                + '; '.join(words))
    return ASSUMPTIONS.find(HOLDS, '', f'violated: {listed}; the outcome is the same with what '
                            'can be mended' if violated else 'no assumption is violated')


ASSUMPTIONS = Condition(
    name='assumptions',
    holds='no assumption of GK that the data refute decides',
    doubtful_when='in variant A the mean is not zero (e), and the run complies or variant B '
                  'decides otherwise; or the outcome would differ with another refuted '
                  'assumption mended: without a drift or a dependence on the heading (h), or with '
                  'a model of the distributions that fits better (j)',
    judge=_judge)
