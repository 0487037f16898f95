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


"""The norms and the method as the protocol lists them."""

from heading_intercompare.core.settings import Settings
from heading_intercompare.report.contents.decision_rule import describe_norms


def test_what_nobody_stated_is_said_to_be_the_default():
    told = dict(describe_norms(Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1, m_low=0.5)))
    assert told['confidence probability P [1]'] == '0.997, default'
    assert told['variant of GK Table I'].endswith(', default')
    assert not told['bounds of M = sigma_ref / sigma_ref_max, as set [1]'].endswith('default')
