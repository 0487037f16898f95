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

"""Statuses and figures as messages."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare.messages.cdr import encode
from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.status_messages import (
    decode_statuses,
    encode_figures,
    encode_statuses,
    ERROR,
    OK,
    Status,
    STATUS_TYPE,
    WARN,
)

hypothesis = pytest.importorskip('hypothesis')
st = hypothesis.strategies

TEXT = st.text(max_size=8).filter(lambda t: '\0' not in t)


@hypothesis.given(st.dictionaries(TEXT, st.one_of(
    st.none(), st.booleans(), st.integers(-2 ** 63, 2 ** 63), st.floats(allow_nan=False), TEXT),
    max_size=6))
def test_figures_arrive_and_read_back_to_the_bit(figures):
    ns, (one,) = decode_statuses(encode_figures('run', figures, 5))
    assert (ns, one.name, one.level) == (5, 'run', OK)
    assert one.values.keys() == {k for k, v in figures.items() if v is not None}
    for key, text in one.values.items():
        value = figures[key]
        if isinstance(value, bool):
            assert text == str(value).lower()
        elif isinstance(value, float):
            assert float(text) == value
        else:
            assert text == str(value)


@hypothesis.given(st.lists(st.builds(
    Status, TEXT, st.integers(0, 3), TEXT,
    st.dictionaries(TEXT, st.one_of(st.none(), st.integers(), TEXT), max_size=4)), max_size=4))
def test_the_bytes_are_those_of_the_encoder_for_any_message(statuses):
    fields = [{'level': one.level, 'name': one.name, 'message': one.message, 'values': [
        {'key': key, 'value': str(value)} for key, value in one.values.items()
        if value is not None]} for one in statuses]
    assert encode_statuses(10 ** 18 + 7, statuses) == encode(STATUS_TYPE, {
        'header': {'stamp': {'sec': 10 ** 9, 'nanosec': 7}}, 'status': fields})


def test_a_number_of_numpy_is_written_as_a_bare_number():
    data = encode_statuses(1, [Status('x', OK, '', {'mean_deg': np.float64(0.25),
                                                    'n': np.int64(7)})])
    _, (one,) = decode_statuses(data)
    assert one.values == {'mean_deg': '0.25', 'n': '7'}


def test_stamp_and_statuses_arrive_in_their_order():
    statuses = [Status('a', WARN, 'silent', {}), Status('b', ERROR, 'gone', {'n': '1'})]
    assert decode_statuses(encode_statuses(7_000_000_001, statuses)) == (7_000_000_001, statuses)


def test_nothing_to_say_is_a_message_all_the_same():
    assert decode_statuses(encode_statuses(0, [])) == (0, [])


@pytest.mark.parametrize('start', [b'\x00\x07', b'\x00\x03', b'\x00\x0b', b'\x01\x00'])
def test_another_encapsulation_is_refused(start):
    """XCDR2, parameter lists of either version, and no encapsulation at all."""
    data = encode_statuses(1, [Status('a', OK, '', {})])
    with pytest.raises(MessageError, match='does not start as CDR'):
        decode_statuses(start + data[2:])
