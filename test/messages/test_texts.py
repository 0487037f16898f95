# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Texts as messages."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.errors import MessageError
from heading_intercompare.messages.texts import decode_text, encode_text


@pytest.mark.parametrize('text', ['', 'all fast', 'Länge 54°\n'])
def test_a_text_arrives_as_it_was(text):
    assert decode_text(encode_text(text)) == text


def test_a_text_that_is_cut_is_refused():
    with pytest.raises(MessageError, match='ends early'):
        decode_text(encode_text('all fast')[:-1])
