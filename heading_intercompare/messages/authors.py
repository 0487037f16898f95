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

"""Who said or did something: the name at the end of a text, ``rough sea [by J. Smith]``."""

from __future__ import annotations

import re

UNKNOWN_OPERATOR = 'unknown operator'
"""The name where none is known: ROS tells neither who calls a service nor who sets a parameter."""

_LONGEST = 60
_SIGNED = re.compile(r'(.*\S)\s*\[by ([^\[\]]+)\]', re.DOTALL)


def clean_name(name: str) -> str:
    """Return a name as it can stand in a text: in one line, without brackets, not too long."""
    plain = ''.join(c if c.isprintable() and c not in '[]' else ' ' for c in name)
    return ' '.join(plain.split())[:_LONGEST].strip() or UNKNOWN_OPERATOR


def sign_text(text: str, operator: str = '') -> str:
    """
    Return a text with the name of its author at its end.

    Examples
    --------
    >>> sign_text('rough sea', 'J. Smith'), sign_text('stop')
    ('rough sea [by J. Smith]', 'stop [by unknown operator]')

    """
    return f'{text} [by {clean_name(operator)}]'


def split_author(text: str) -> tuple[str, str]:
    """
    Return a text without the name at its end, and the name.

    Examples
    --------
    >>> split_author('jump [by J. Smith]'), split_author('jump')
    (('jump', 'J. Smith'), ('jump', 'unknown operator'))

    """
    signed = _SIGNED.fullmatch(text.strip())
    return (text, UNKNOWN_OPERATOR) if signed is None else (
        signed.group(1), clean_name(signed.group(2)))
