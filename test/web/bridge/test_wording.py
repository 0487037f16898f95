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

"""Times, lengths and values as the page says them."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.web.bridge.view_texts import (
    integer,
    lacking_words,
    real,
    shorten,
    size_words,
)


@pytest.mark.parametrize('text, whole, value', [
    (None, None, None), ('x', None, None), ('', None, None), ('nan', None, None),
    ('7', 7, 7.0), ('0.5', None, 0.5), ('inf', None, math.inf)])
def test_values_of_others_are_read_with_care(text, whole, value):
    assert integer(text) == whole and real(text) == value


@pytest.mark.parametrize('needed_s, words', [
    (None, 'too few differences to tell (40)'), (math.inf, 'more time alone does not decide'),
    (0.0, 'enough to accept if it goes on like this'), (30.0, '30 s more if it goes on like this'),
    (5400.0, '90 min more if it goes on like this')])
def test_what_is_missing_is_said_in_words(needed_s, words):
    assert lacking_words(40, needed_s) == words


def test_a_scatter_beyond_the_norm_is_enough_to_reject():
    assert lacking_words(40, 0.0, True) == 'enough to reject if it goes on like this'


def test_a_long_text_is_cut_and_keeps_to_one_line():
    assert shorten('a\nb', 9) == 'a b'
    assert len(shorten('x' * 1000, 300)) == 300


def test_small_sizes():
    assert size_words(5_200_000) == '5 MB'
