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

"""The tests that a norm requires: what each one asks, its limit, and the clause that says so."""

from __future__ import annotations

from dataclasses import dataclass
import math
import re
from typing import Mapping

from .text_rows import split_rows

VERIFIED, UNVERIFIED, OWN = 'verified', 'unverified', 'own'
"""Whether the clause was read: in the document itself, or only elsewhere; or it is the user's."""


@dataclass(frozen=True, slots=True)
class TestKind:
    """
    A kind of test.

    Attributes
    ----------
    words
        What is limited, as in a sentence.
    manoeuvre
        What to sail, or to wait for, so that a record can decide it.
    least_s
        How long that takes at least, seconds.
    unit : {'deg', 'h'}
        Of its figure and of its limit.
    is_judged
        Whether a record of headings can decide it at all.

    """

    __test__ = False  # No test of pytest.

    words: str
    manoeuvre: str
    least_s: float = 0.0
    unit: str = 'deg'
    is_judged: bool = True


_SWELL = ('30 min on straight legs in a swell that yaws the ship by 1 deg or more, read every 5 s '
          'or more often')
_MOUNTING = 'installation_offset_deg and installation_offset_u_deg'

KINDS: Mapping[str, TestKind] = {
    'resolution': TestKind(
        'transmission and resolution error',
        'any turn through 5 deg: 30 changes of the reading show its step', 60.0),
    'static_error': TestKind(
        'static error',
        'eight steady headings, 45 deg apart, 10 min each, and the mounting angle stated with '
        f'{_MOUNTING}', 4800.0),
    'dynamic_error': TestKind('amplitude of the dynamic error', _SWELL, 1800.0),
    'fast_dynamic_error': TestKind(
        'amplitude of the dynamic error of periods below 30 s', _SWELL, 1800.0),
    'follow_up': TestKind(
        'follow-up error',
        'a zigzag or full circles, to port and to starboard, as fast as the ship turns', 600.0),
    'settling_time': TestKind(
        'settling time', 'record from switching the sensor on, for 8 h or more', 28800.0, 'h'),
    'settle_point': TestKind(
        'settle-point error',
        '3 h on one heading after settling, and the mounting angle of the RS stated with '
        f'{_MOUNTING}; or alongside, with a bearing of the quay or of a mark (observe)', 10800.0),
    'rms_of_ten': TestKind(
        'rms of ten readings, every 20 min, about their mean',
        'sets of ten readings every 20 min on one heading after settling, 3 h each; four sets '
        'bound the rms to 1.3 times', 43200.0),
    'repeatability': TestKind(
        'repeatability of the settle point from start to start',
        'three runs or more, each 3 h after settling, the sensor switched off between them',
        32400.0),
    'speed_error': TestKind(
        'residual speed error', 'a type test, or legs to the north and to the south at full speed',
        is_judged=False),
    'speed_change': TestKind(
        'error after a rapid change of speed', 'a type test', is_judged=False),
    'course_change': TestKind(
        'error after a rapid change of course by 180 deg', 'a type test', is_judged=False),
}
"""The kinds of tests by their names."""


LEAST_SHARE_OF_RATES = 0.1
"""Share of the fastest rate of a follow-up error at which a record says something of it."""

SYSTEMATIC = 'static_error', 'settle_point'
"""The kinds that limit the systematic error."""


@dataclass(frozen=True, slots=True)
class RequiredTest:
    """
    A test that a norm requires.

    Attributes
    ----------
    kind
        A name of `KINDS`.
    limit
        Largest permitted figure, in the unit of its kind.
    clause
        Where the norm says so.
    secant
        Whether the limit grows with the secant of the latitude.
    rates_deg_s
        The rates of turn to which a follow-up error belongs, slowest and fastest.
    status : {'verified', 'unverified', 'own'}
        See `VERIFIED`.

    """

    kind: str
    limit: float
    clause: str
    secant: bool = False
    rates_deg_s: tuple[float, float] | None = None
    status: str = VERIFIED

    @property
    def words(self) -> str:
        """Return what is limited, with the rates of turn."""
        words = KINDS[self.kind].words
        if self.rates_deg_s is None:
            return words
        slowest, fastest = self.rates_deg_s
        return (f'{words} up to {fastest:g} deg/s' if slowest == 0.0 else
                f'{words} from {slowest:g} to {fastest:g} deg/s')

    @property
    def manoeuvre(self) -> str:
        """Return what to sail, or to wait for, with the rate of turn."""
        manoeuvre = KINDS[self.kind].manoeuvre
        return manoeuvre if self.least_rate_deg_s is None else (
            f'{manoeuvre}, {self.least_rate_deg_s:g} deg/s or more')

    @property
    def least_rate_deg_s(self) -> float | None:
        """Return the least rate of turn that a record must have, degrees per second."""
        if self.rates_deg_s is None:
            return None
        slowest, fastest = self.rates_deg_s
        return max(slowest, LEAST_SHARE_OF_RATES * fastest)

    def limit_at(self, latitude_deg: float | None) -> float:
        """Return the limit at a latitude, which must be known if the limit grows with it."""
        if not self.secant:
            return self.limit
        if latitude_deg is None:
            raise ValueError(f'{self.kind}: its limit grows with the secant of the latitude')
        return self.limit / math.cos(math.radians(latitude_deg))


_ROW = re.compile(r'(?P<kind>[a-z_]+)\s+(?P<limit>\d+(?:\.\d+)?)(?P<secant>\s*sec)?'
                  r'(?:\s+(?P<slowest>\d+(?:\.\d+)?)-(?P<fastest>\d+(?:\.\d+)?))?', re.ASCII)


def read_required_tests(text: str | None) -> tuple[RequiredTest, ...]:
    """
    Return the tests of a norm of one's own.

    Parameters
    ----------
    text
        Rows ``KIND LIMIT``, separated by line ends or ``;``. ``sec`` after the limit: times the
        secant of the latitude. A follow-up error has its rates of turn: ``follow_up 0.5 0-10``.

    Raises
    ------
    ValueError
        If a row is not of this form, or repeats an earlier one; the message names the row.

    Examples
    --------
    >>> [test.words for test in read_required_tests('settle_point 0.5 sec; follow_up 0.5 0-3')]
    ['settle-point error', 'follow-up error up to 3 deg/s']

    """
    tests: list[RequiredTest] = []
    for number, row in enumerate(split_rows(text), 1):
        test = _read_row(row, number)
        if any((test.kind, test.rates_deg_s) == (other.kind, other.rates_deg_s)
               for other in tests):
            raise ValueError(f'row {number}: {row!r:.80}: an earlier row limits the same')
        tests.append(test)
    return tuple(tests)


def _read_row(row: str, number: int) -> RequiredTest:
    match = _ROW.fullmatch(row)
    judged = [name for name, kind in KINDS.items() if kind.is_judged]
    if match is None or match['kind'] not in judged:
        raise ValueError(f'row {number}: {row!r:.80}: must be a test and its limit, such as '
                         f'"static_error 1.0"; the tests are {", ".join(judged)}')
    rates = None
    if match['kind'] == 'follow_up':
        if match['fastest'] is None:
            raise ValueError(f'row {number}: {row!r:.80}: needs the rates of turn, such as '
                             '"follow_up 0.5 0-10"')
        rates = float(match['slowest']), float(match['fastest'])
        if not rates[0] < rates[1]:
            raise ValueError(f'row {number}: {row!r:.80}: the slowest rate must be below the '
                             'fastest')
    elif match['fastest'] is not None:
        raise ValueError(f'row {number}: {row!r:.80}: only follow_up has rates of turn')
    limit = float(match['limit'])
    if limit <= 0.0:
        raise ValueError(f'row {number}: {row!r:.80}: the limit must be greater than 0')
    return RequiredTest(match['kind'], limit, 'norms.tests', match['secant'] is not None, rates,
                        OWN)
