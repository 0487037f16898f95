# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Norms and decision rules: figures of a run, or of several, against limits."""

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
    'sequential': ('find_standing', 'Look', 'Looks', 'LookVerdict', 'rejecting',
                   'risk_at_the_end'),
})
