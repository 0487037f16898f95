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

"""Figures and stamps as text; a missing value is a dash."""

from __future__ import annotations

from heading_intercompare.core.utc_text import utc
from heading_intercompare.report.formatting import exact, interval, number, value


def test_figures_in_words():
    assert [value(v) for v in (None, '', True, float('nan'), 12, 0.1234567, [1, None], [])] == [
        '-', '-', 'yes', '-', '12', '0.123457', '1, -', '-']
    assert (interval(None, None), interval(1.0, None)) == ('-', '1 .. -')
    assert (exact(0.99999901), exact(None), exact('auto')) == ('0.99999901', '-', 'auto')
    assert number(7_200_000) == '7200000'


def test_stamps_in_words():
    assert utc(1_700_000_000_123_999_999) == '2023-11-14 22:13:20.123'
    assert utc(None) == '-'
