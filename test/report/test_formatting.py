# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
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
