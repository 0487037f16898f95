# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Marks as messages."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.marks import decode_marks, encode_mark, MARKS


@pytest.mark.parametrize('kind', MARKS)
def test_a_mark_arrives_with_its_stamp(kind):
    assert decode_marks(encode_mark(kind, 123_456_789_012)) == [(kind, 123_456_789_012)]


def test_a_mark_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_marks(encode_mark('start', 1)[:-1])
