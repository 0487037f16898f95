# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""A run judged at its end, and the verdict on all runs."""

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'conclusion': ('ALL_REASONS',),
    'headline': ('OUTCOME_WORDS',),
    'judge': ('compare_runs', 'conclude_campaign', 'judge_run', 'look_at', 'RunResult'),
    'validity': ('DOUBTFUL', 'VOID'),
    'verdict_document': ('Input', 'make_plain', 'OperatorNote', 'RunVerdict', 'SCHEMA', 'Verdict',
                         'VerdictError'),
    'verdict_table': ('summary_text', 'verdict_html', 'verdict_text'),
})
