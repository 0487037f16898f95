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

"""The words for outcomes, reasons and states that people read."""

from __future__ import annotations

NO_RUN = 'No run: there are no pairs, or none in a run of sufficient length.'

EFFECT_WORDS = {'holds': 'holds', 'doubtful': 'DOUBTFUL', 'void': 'VOID',
                'not_testable': 'not testable'}

STATE_WORDS = {'met': 'met', 'violated': 'VIOLATED', 'not_testable': 'not testable'}

_LAWS = {'N': 'normal', 'U': 'uniform'}


def law_words(model: str) -> tuple[str, str]:
    """Return the error distributions of TS and RS in words, for a model such as 'UN'."""
    ts_law, rs_law = (_LAWS[letter] for letter in model)
    return ts_law, rs_law
