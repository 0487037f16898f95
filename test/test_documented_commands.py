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

"""Each command line that a page shows is one that the program takes."""

from __future__ import annotations

from pathlib import Path
import re
import shlex

import pytest

from heading_intercompare.cli.program import _build_parser, UsageError

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted([ROOT / 'README.md', ROOT / 'CONTRIBUTING.md', *(ROOT / 'docs').rglob('*.md')])
_LINE = re.compile(r'^ *(?:\$ )?(heading-intercompare .*)$', re.MULTILINE)
_INLINE = re.compile(r'`(heading-intercompare [^`]+)`')


def read_commands(text):
    """Return the command lines of a page, each a list of arguments."""
    found = []
    whole = text.replace('\\\n', ' ')
    for line in _LINE.findall(whole) + _INLINE.findall(whole):
        words = shlex.split(line, comments=True)[1:]
        for end in ('|', '||', '>', '&&', ';', '&'):
            words = words[:words.index(end)] if end in words else words
        found.append(words)
    return found


@pytest.mark.parametrize('page', PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_the_program_takes_each_command_of_a_page(page):
    for words in read_commands(page.read_text('utf-8')):
        # Not those that stand for any command, nor the output of one.
        if 'COMMAND' in words or words[0].endswith(':'):
            continue
        try:
            _build_parser(words).parse_args(words)
        except UsageError as error:
            # Within a sentence a command may stand without its input.
            assert 'the following arguments are required' in str(error), words
        except SystemExit:
            assert words[-1] in ('--version', '--help')


def test_commands_are_found_in_all_forms_of_a_block():
    text = ('```\nheading-intercompare info a --x\n```\n\n    heading-intercompare info b \\\n'
            '        --y  # why\n\n```console\n$ heading-intercompare info c | less\n```\n')
    assert read_commands(text) == [['info', 'a', '--x'], ['info', 'b', '--y'], ['info', 'c']]
    assert sum(len(read_commands(page.read_text('utf-8'))) for page in PAGES) > 50
