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

"""The versions of the software and of its decision rule, as verdicts state them."""

__all__ = ['RULE_VERSION', 'VERSION']

#: setup.py reads it here, and bags state it.
VERSION = '0.1.0'

RULE_VERSION = 6
"""
Increased whenever the same readings and settings may give another outcome, bound or limit.

Version 1 had a gate and a choice of estimators (``risk.method``); version 2 has the spectrum of
the squares and binding findings; version 3 judges the readings lost on the way and at the
source, rejects single stamps that jump, and names clocks that were set back; version 4 searches
for clocks that lie minutes apart, and doubts a run with a skew beyond the range of the search;
version 5 compares the headings with the motion of the ship, if it is known; version 6 judges the
norm of the RS, sensors that part for a while, and the assumptions of GK that the data refute.
``docs/risk.md`` describes the current version.
"""
