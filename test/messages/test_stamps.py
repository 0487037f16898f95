# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps of messages."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.cdr import decode
from heading_intercompare.messages.stamps import (
    CLOCK_TYPE,
    encode_clock,
    stamp_fields,
    stamp_ns,
    TIME_LIMIT_NS,
)


@pytest.mark.parametrize('ns', [0, 1, 10 ** 9 - 1, 10 ** 9, TIME_LIMIT_NS - 1])
def test_a_stamp_comes_back_to_the_nanosecond(ns):
    assert stamp_ns(stamp_fields(ns)) == ns


def test_a_clock_holds_its_time():
    clock = decode(CLOCK_TYPE, encode_clock(1_700_000_000_000_000_007))['clock']
    assert clock == {'sec': 1_700_000_000, 'nanosec': 7}
