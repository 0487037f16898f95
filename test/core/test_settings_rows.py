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

"""Rows of settings: names, values of each kind, and each mistake in one line."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from heading_intercompare.core.declared_settings import Checked, read_rows, setting


@dataclass(frozen=True, slots=True)
class Thing(Checked):
    """A thing."""

    size_m: float = setting(1.0, 'size [m]', 0.0, 10.0)
    colour: str = setting('red', 'colour')
    round: bool = setting(False, 'whether it is round')
    legs: int = setting(4, 'number of legs', 0, 100)


def test_rows_by_line_or_semicolon_with_quotes_and_comments():
    text = """
    # all of them
    chair  size_m=0.9 colour='dark red'   # of the mess
    ball   round=true legs=0; table legs=3
    """
    assert dict(read_rows(text, Thing)) == {
        'chair': Thing(0.9, 'dark red'), 'ball': Thing(round=True, legs=0),
        'table': Thing(legs=3)}
    assert list(read_rows(None, Thing)) == list(read_rows(' ; \n', Thing)) == []


def test_a_word_stands_for_a_setting():
    found = dict(read_rows('ball r; chair', Thing, {'r': ('round', True)}))
    assert found == {'ball': Thing(round=True), 'chair': Thing()}


@pytest.mark.parametrize('text, said', [
    ('chair size_m=11', 'row 1 (chair size_m=11): size_m = 11.0: must be'),
    ('chair; 4legs', "row 2 (4legs): '4legs': a name must begin with a letter"),
    ('chair; Chair', 'row 2 (Chair): the name Chair is given twice'),
    ('chair size_m=1 size_m=2', 'size_m is given twice'),
    ('chair r round=false', 'round is given twice'),
    ('chair size=1', "unknown setting 'size'; did you mean 'size_m'?"),
    ('chair big', "'big': must be setting=value, or r"),
    ('chair size_m=big', "size_m = 'big': must be"),
    ('chair round=maybe', "round = 'maybe': must be"),
    ("chair colour='red", 'No closing quotation'),
])
def test_a_mistake_is_one_line_that_names_the_row(text, said):
    with pytest.raises(ValueError) as error:
        list(read_rows(text, Thing, {'r': ('round', True)}))
    assert said in str(error.value) and '\n' not in str(error.value)
