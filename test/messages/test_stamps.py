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
