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

"""The name at the end of a text."""

from __future__ import annotations

import pytest

from heading_intercompare.messages.authors import sign_text, split_author


@pytest.mark.parametrize('name, shown', [
    ('J. Smith', 'J. Smith'), ('', 'unknown operator'), (' \n\x1b', 'unknown operator'),
    ('a\nb]', 'a b'), ('[by Mate]', 'by Mate'),
    ('x' * 100, 'x' * 60), ('Łukasz: 2/O', 'Łukasz: 2/O')])
def test_a_signed_text_gives_text_and_name_back(name, shown):
    for text in ('all', 'ts_driver: checksum', 'two\nlines', 'set [1, 2]', 'seen [by Mate]'):
        assert split_author(sign_text(text, name)) == (text, shown)


@pytest.mark.parametrize('text', ['', 'jump', ' watcher: jump\n', '[by Mate]',
                                  'jump [by ]', 'by Mate]',
                                  'jump [by Mate] now'])
def test_a_text_without_a_name_stays_and_has_an_unknown_author(text):
    assert split_author(text) == (text, 'unknown operator')
