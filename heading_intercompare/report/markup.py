# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Markup of XML and HTML, escaped where it is made; no other module writes an angle bracket."""

from __future__ import annotations

from html import escape
import re
from typing import Iterable

__all__ = ['element', 'join', 'Markup', 'text']

_UNPRINTABLE = re.compile('[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]')


class Markup(str):
    """Text that is markup already and goes into a document as it is."""

    __slots__ = ()


def text(words: object) -> Markup:
    """
    Return words as markup that shows them literally.

    What neither XML nor UTF-8 can hold (control characters, undecodable bytes of a file name)
    becomes U+FFFD. Markup stays as it is.
    """
    if isinstance(words, Markup):
        return words
    return Markup(escape(_UNPRINTABLE.sub('\ufffd', str(words)), quote=True))


def join(parts: Iterable[object], between: str = '') -> Markup:
    """Return parts, each as markup, one after the other."""
    return Markup(between.join(text(part) for part in parts))


def element(name: str, *children: object, **attributes: object) -> Markup:
    """
    Return an element.

    Parameters
    ----------
    name : str
        Of the element.
    *children : object
        Markup, or words, which are escaped.
    **attributes : object
        An underscore within the name stands for a hyphen, one at the end is left out (`class_`);
        an attribute that is None is left out.

    Examples
    --------
    >>> element('td', 'a < b', class_='number')
    '<td class="number">a &lt; b</td>'
    >>> element('line', stroke_width=2)
    '<line stroke-width="2"/>'

    """
    given = ''.join(f' {key.rstrip("_").replace("_", "-")}="{text(value)}"'
                    for key, value in attributes.items() if value is not None)
    if not children:
        return Markup(f'<{name}{given}/>')
    return Markup(f'<{name}{given}>{join(children)}</{name}>')
