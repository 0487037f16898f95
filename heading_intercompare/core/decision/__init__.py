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

"""Norms and decision rules: compare the figures of one run, or of several, with limits."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'campaign': ('CAMPAIGN_REASONS', 'conclude_every_run', 'conclude_sensor', 'judge_together',
                 'Together'),
    'coverage': ('Coverage', 'coverage_of', 'least_duration_words', 'SENSOR_CLASSES',
                 'span_words'),
    'criteria': ('apply_variance_criterion', 'CountCriterion', 'Limits', 'TotalError',
                 'VarianceCriterion'),
    'gk': ('apply_gk', 'Printed'),
    'guarded': ('decide', 'Evidence', 'gather_evidence', 'Guarded', 'REASONS'),
    'norm_presets': ('PRESETS', 'sigma_max_deg'),
    'sequential': ('find_rejection', 'find_standing', 'Look', 'Looks', 'LookVerdict',
                   'risk_at_the_end'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .campaign import (
        CAMPAIGN_REASONS as CAMPAIGN_REASONS,
        conclude_every_run as conclude_every_run,
        conclude_sensor as conclude_sensor,
        judge_together as judge_together,
        Together as Together,
    )
    from .coverage import (
        Coverage as Coverage,
        coverage_of as coverage_of,
        least_duration_words as least_duration_words,
        SENSOR_CLASSES as SENSOR_CLASSES,
        span_words as span_words,
    )
    from .criteria import (
        apply_variance_criterion as apply_variance_criterion,
        CountCriterion as CountCriterion,
        Limits as Limits,
        TotalError as TotalError,
        VarianceCriterion as VarianceCriterion,
    )
    from .gk import apply_gk as apply_gk, Printed as Printed
    from .guarded import (
        decide as decide,
        Evidence as Evidence,
        gather_evidence as gather_evidence,
        Guarded as Guarded,
        REASONS as REASONS,
    )
    from .norm_presets import PRESETS as PRESETS, sigma_max_deg as sigma_max_deg
    from .sequential import (
        find_rejection as find_rejection,
        find_standing as find_standing,
        Look as Look,
        Looks as Looks,
        LookVerdict as LookVerdict,
        risk_at_the_end as risk_at_the_end,
    )
