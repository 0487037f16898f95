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

"""Foreign text made safe to show: names and notes from recordings of others."""

from __future__ import annotations

#: Bytes that the name of a file may have, with some left for a number before it.
_NAME_BYTES = 200


def escape(text: str) -> str:
    r"""
    Return a text in one line, with everything escaped that does not print.

    A topic name may hold a line end and forge a line of output. It may hold commands of a
    terminal, or characters that turn the direction of what follows.

    Examples
    --------
    >>> escape('a\nVERDICT: COMPLIANT \x1b[2J \u202e Ørsted')
    'a\\u000aVERDICT: COMPLIANT \\u001b[2J \\u202e Ørsted'

    """
    if text.isprintable():
        return text
    return ''.join(letter if letter.isprintable() or _is_space(letter) else _code(letter)
                   for letter in text)


def escape_lines(text: str) -> str:
    """Return a text with everything escaped that does not print, except line ends and tabs."""
    return '\n'.join(line if line.isprintable() else ''.join(
        letter if letter.isprintable() or letter == '\t' or _is_space(letter) else _code(letter)
        for letter in line) for line in text.split('\n'))


def safe_name(name: str, number: int) -> str:
    r"""
    Return a name that is safe for a file, from the name of an attachment.

    It has no folder, nothing that does not print, and no sign that a shell or another system
    treats in its own way. It does not begin like an option or a hidden file.

    Examples
    --------
    >>> safe_name('../a\nb: 1.csv', 3), safe_name('..', 3), safe_name('--help', 1)
    ('a_b_ 1.csv', 'attachment_3', 'help')

    """
    last = name.replace('\\', '/').rpartition('/')[2]
    shown = ''.join('_' if not letter.isprintable() or letter in ':*?"<>|$`\'' else letter
                    for letter in last).lstrip('-.~ ').rstrip(' .')
    short = shown.encode()[-_NAME_BYTES:].decode(errors='ignore')
    return short or f'attachment_{number}'


def _is_space(letter: str) -> bool:
    """Tell whether a letter is a space of another width, as between digits."""
    return letter.isspace() and '\u2000' <= letter <= '\u200a' or letter in '\xa0\u202f\u3000'


def _code(letter: str) -> str:
    number = ord(letter)
    return f'\\u{number:04x}' if number < 0x10000 else f'\\U{number:08x}'
