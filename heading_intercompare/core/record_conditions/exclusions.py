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

"""The condition that nothing that a person took out decides; judged from two judgements."""

from __future__ import annotations

from heading_intercompare.core.validity.condition import Condition

__all__ = ['EXCLUSIONS']

EXCLUSIONS = Condition(
    name='exclusions',
    holds='nothing that was taken out by hand decides',
    doubtful_when='the verdict with nothing taken out by hand differs, or has a graver doubt; the '
                  'headline gives both')
