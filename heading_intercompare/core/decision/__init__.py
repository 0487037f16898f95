# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Norms and decision rules: figures of a run, or of several, against limits."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'campaign': ('CAMPAIGN_REASONS', 'conclude_every_run', 'conclude_sensor', 'Together',
                 'together'),
    'coverage': ('Coverage', 'coverage_of', 'least_duration_words', 'SENSOR_CLASSES',
                 'span_words'),
    'criteria': ('CountCriterion', 'Limits', 'TotalError', 'variance_criterion',
                 'VarianceCriterion'),
    'gk': ('as_printed', 'Printed'),
    'guarded': ('decide', 'Evidence', 'evidence_of', 'Guarded', 'REASONS'),
    'norm_presets': ('PRESETS', 'sigma_max_deg'),
    'sequential': ('Look', 'Looks', 'LookVerdict', 'rejecting', 'risk_at_the_end', 'standing'),
})
