# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The words for outcomes, reasons and states, wherever people read them."""

from __future__ import annotations

from heading_intercompare.core.campaign import CAMPAIGN_REASONS
from heading_intercompare.core.early import ALL_REASONS

__all__ = ['CAMPAIGN_WORDS', 'OUTCOME_WORDS', 'REASON_WORDS', 'STATE_WORDS']

OUTCOME_WORDS = {'compliant': 'COMPLIANT', 'indeterminate': 'INDETERMINATE',
                 'non_compliant': 'NON-COMPLIANT'}

CAMPAIGN_WORDS = CAMPAIGN_REASONS

REASON_WORDS = ALL_REASONS

STATE_WORDS = {'met': 'met', 'violated': 'VIOLATED', 'not_testable': 'not testable'}
