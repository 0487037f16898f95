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

"""What sensors say of their readings, as text."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.bags.csv.pairs_account import quality_of_text, text_of_quality
from heading_intercompare.core.records import Quality

ROWS = Quality.of([10 ** 18, 10 ** 18 + 1, 5], [0.1 + 0.2, np.nan, 4.0], [1, 0, 3])


def test_it_comes_back_to_the_bit():
    quality = {'ts': ROWS, 'rs': ROWS[1:]}
    assert quality_of_text(text_of_quality(quality)) == quality


def test_no_quality_is_no_text():
    assert text_of_quality({'rs': Quality.empty()}) is None
    assert quality_of_text(None) == {}


@pytest.mark.parametrize('text, words', [
    ({'rs': '!'}, 'quality.rs is no base64'), ({'rs': 'AAAA'}, 'has 3 bytes'),
    ({'truth': text_of_quality({'rs': ROWS})['rs']}, 'quality.truth has a sensor'),
    (text_of_quality({'ts': Quality.of([1], [0.1], [99])}), 'quality.ts has'),
    (text_of_quality({'ts': Quality.of([1], [0.1], [-1])}), 'quality.ts has'),
    (text_of_quality({'ts': Quality.of([1], [-0.1], [1])}), 'quality.ts has')])
def test_what_is_none_is_refused(text, words):
    with pytest.raises(ValueError, match=words):
        quality_of_text(text)
