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

"""Stamps in the cells of a csv file, to integer nanoseconds without floats."""

from __future__ import annotations

from datetime import datetime, timezone
from decimal import Decimal, localcontext
import re
from typing import Callable, Mapping, NamedTuple, Sequence

from heading_intercompare.core.units.given_stamps import find_unit
from heading_intercompare.core.utc_text import DAY_NS, utc

_SECOND_NS = 1_000_000_000
_DIGITS = 60
_FIRST_BEYOND = 2**63
_ISO = re.compile(r'(\d{4}-\d\d-\d\d)[T ](\d\d:\d\d:\d\d)(?:[.,](\d{1,9})\d*)?\s?'
                  r'(?:Z|UTC|([+-]\d\d):?(\d\d))?', re.ASCII)
_NUMBER = re.compile(r'\d+(?:\.\d*)?', re.ASCII)
#: Days of a spreadsheet count from 30 December 1899; these are 1954 to 2119.
DAY_ZERO_NS = -25569 * DAY_NS
_FIRST_DAY, _LAST_DAY = 20_000, 80_000
#: No sensor reports at a kilohertz; a day number of seconds differs by 1.2e-5.
_LEAST_STEP_NS = 1_000_000


def nanoseconds(text: str) -> int:
    """
    Return decimal seconds as nanoseconds, rounded from the tenth decimal on.

    Raises
    ------
    ValueError, ArithmeticError
        If it is no number, or does not fit into 64 bits.

    """
    whole, _, decimals = text.partition('.')
    if whole.isdecimal() and len(decimals) <= 9 and (decimals.isdecimal() or not decimals):
        return int(whole) * _SECOND_NS + int(decimals.ljust(9, '0'))
    return scale(text, _SECOND_NS)


def scale(text: str, unit_ns: int) -> int:
    """Return a decimal number of a unit as nanoseconds; ArithmeticError as `nanoseconds`."""
    with localcontext() as context:
        context.prec = _DIGITS
        stamp_ns = Decimal(text) * unit_ns
        if not abs(stamp_ns) < _FIRST_BEYOND:
            raise OverflowError
        return int(stamp_ns.to_integral_value())


def utc_nanoseconds(text: str) -> int:
    """Return an ISO time, or a day number of a spreadsheet, as nanoseconds."""
    match = _ISO.fullmatch(text)
    if match is None:
        if not (_NUMBER.fullmatch(text) and _FIRST_DAY <= float(text) < _LAST_DAY):
            raise ValueError(text)
        return DAY_ZERO_NS + scale(text, DAY_NS)
    day, clock, decimals, hours, minutes = match.groups()
    moment = datetime.fromisoformat(f'{day}T{clock}').replace(tzinfo=timezone.utc)
    offset_s = 0
    if hours:
        offset_s = int(hours) * 3600 + int(hours[0] + minutes) * 60
    return ((int(moment.timestamp()) - offset_s) * _SECOND_NS
            + int((decimals or '').ljust(9, '0')))


class StampColumn(NamedTuple):
    """How a column of stamps is read, and what it must hold."""

    convert: Callable[[str], int]
    allowed: str
    decimal: bool


STAMP_COLUMNS: Mapping[str, StampColumn] = {
    'stamp_ns': StampColumn(int, 'a whole number of nanoseconds since 1970', False),
    'stamp_s': StampColumn(nanoseconds, 'a decimal number of seconds since 1970', True),
    'stamp_utc': StampColumn(utc_nanoseconds, 'a time such as 2014-08-01T00:00:00.183Z', False),
}
"""The columns that give the stamps; a file with several is read by the first of them."""

_HINTS = (
    (re.compile(r'\d{4}-\d\d-\d\d.*'), '; name the column stamp_utc for such times'),
    (re.compile(r'\d[\d.,]*[eE]\+?\d+'), '; a spreadsheet has rounded it: give it as text, or '
     'as stamp_s'),
    (re.compile(r'\d{1,4}[./]\d{1,2}[./]\d{1,4}.*|\d{1,2}:\d\d.*'), '; a spreadsheet has '
     'rewritten it: format the column as yyyy-mm-dd hh:mm:ss.000 and name it stamp_utc'),
)


def explain_stamp(name: str, text: str) -> str:
    """Return a hint for a cell that the column of this name does not allow; '' without one."""
    if name == 'stamp_utc' and _NUMBER.fullmatch(text):
        return '; name the column stamp_s or stamp_ns for numbers'
    return next((hint for form, hint in _HINTS if form.fullmatch(text)
                 and f'name the column {name}' not in hint), '')


def looks_like_unit(stamp_ns: Sequence[int]) -> str:
    """
    Tell whether stamps read as nanoseconds are UTC in a larger unit.

    Parameters
    ----------
    stamp_ns
        The first stamps of a file, n >= 0.

    Returns
    -------
    str
        Why they are, in words; '' if they are not. The stamps of a clock that began at zero may
        have the size of such numbers, but lie further apart.

    """
    if len(stamp_ns) < 3:
        return ''
    first, last = min(stamp_ns), max(stamp_ns)
    if (last - first) / (len(stamp_ns) - 1) > _LEAST_STEP_NS:
        return ''
    unit, factor = find_unit(first, last) or ('', 1)
    if factor == 1:
        return ''
    instead = 'name the column stamp_s' if factor == _SECOND_NS else f'multiply by {factor}'
    return (f'stamp_ns = {stamp_ns[0]} looks like {unit} since 1970 '
            f'({utc(stamp_ns[0] * factor)} UTC), not nanoseconds: {instead}')


def looks_like_days(stamp_ns: Sequence[int]) -> str:
    """
    Tell whether stamps read as seconds are day numbers of a spreadsheet.

    Parameters
    ----------
    stamp_ns
        The first stamps of a file, nanoseconds, n >= 0.

    Returns
    -------
    str
        Why they are, in words; '' if they are not.

    """
    if len(stamp_ns) < 3 or not (_FIRST_DAY <= min(stamp_ns) / _SECOND_NS
                                 and max(stamp_ns) / _SECOND_NS < _LAST_DAY):
        return ''
    if (max(stamp_ns) - min(stamp_ns)) / (len(stamp_ns) - 1) >= _LEAST_STEP_NS:
        return ''
    first = stamp_ns[0] / _SECOND_NS
    at_ns = DAY_ZERO_NS + round(first * DAY_NS)
    return (f'stamp_s = {first!r} looks like a day number of a spreadsheet '
            f'({utc(at_ns)} UTC): name the column stamp_utc, which reads such numbers')
