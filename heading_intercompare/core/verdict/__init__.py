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

"""The judgement of a run at its end, and the verdict on all runs."""

from typing import TYPE_CHECKING

from heading_intercompare._doors import door

__getattr__, __dir__, __all__ = door(__name__, {
    'all_runs': ('compare_runs', 'conclude_campaign', 'join'),
    'compare_verdicts': ('find_differences',),
    'conclusion': ('ALL_REASONS',),
    'headline': ('OUTCOME_WORDS',),
    'judge': ('judge_run', 'look_at', 'RunResult'),
    'verdict_document': ('Input', 'OperatorNote', 'RunVerdict', 'SCHEMA', 'SCHEMA_VERSION',
                         'Verdict', 'VerdictError'),
    'verdict_table': ('summary_text', 'verdict_html', 'verdict_text'),
})

if TYPE_CHECKING:
    # The same names for type checkers, by ``make docs``.
    from .all_runs import (
        compare_runs as compare_runs,
        conclude_campaign as conclude_campaign,
        join as join,
    )
    from .compare_verdicts import find_differences as find_differences
    from .conclusion import ALL_REASONS as ALL_REASONS
    from .headline import OUTCOME_WORDS as OUTCOME_WORDS
    from .judge import judge_run as judge_run, look_at as look_at, RunResult as RunResult
    from .verdict_document import (
        Input as Input,
        OperatorNote as OperatorNote,
        RunVerdict as RunVerdict,
        SCHEMA as SCHEMA,
        SCHEMA_VERSION as SCHEMA_VERSION,
        Verdict as Verdict,
        VerdictError as VerdictError,
    )
    from .verdict_table import (
        summary_text as summary_text,
        verdict_html as verdict_html,
        verdict_text as verdict_text,
    )
