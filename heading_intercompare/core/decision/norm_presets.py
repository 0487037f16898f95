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

"""Named norms of heading sensors, and the standard deviation that follows from them."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import cast, Mapping

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.required_tests import (
    KINDS,
    read_required_tests,
    RequiredTest,
    SYSTEMATIC,
    UNVERIFIED,
    VERIFIED,
)
from heading_intercompare.core.settings import Norms

from .error_models import ts_factor


@dataclass(frozen=True, slots=True)
class Preset:
    """
    A published norm.

    Attributes
    ----------
    title
        The instrument and the document.
    rms_deg
        Norm of the standard deviation, degrees; used directly as the TS norm.
    limit_deg
        Norm of the largest error, degrees; divided by K(P) it gives a standard deviation.
    probability
        Probability that belongs to the limit; None for `norms.probability`.
    secant
        Whether the norm grows with the secant of the latitude.
    status
        'verified' against the document, or 'unverified': from secondary sources or a draft.
    tests
        The tests that it requires.

    """

    title: str
    rms_deg: float | None
    limit_deg: float | None
    probability: float | None
    secant: bool
    status: str
    tests: tuple[RequiredTest, ...]

    @property
    def content(self) -> str:
        """Return its requirements in a sentence."""
        return '; '.join(
            f'{test.words} {test.limit:g}{" sec(lat)" if test.secant else ""} '
            f'{KINDS[test.kind].unit}' for test in self.tests)

    @property
    def systematic(self) -> RequiredTest | None:
        """Return the test of the systematic error: of the settle point, or the static error."""
        return next((test for test in self.tests if test.kind in SYSTEMATIC), None)


def _require_of_gyrocompass(clauses: Mapping[str, str], status: str,
                            statuses: Mapping[str, str]) -> tuple[RequiredTest, ...]:
    """Return the tests under static conditions, which A.424, A.821 and ISO 8728 share."""
    limits = {'settling_time': 6.0, 'settle_point': 0.75, 'rms_of_ten': 0.25,
              'repeatability': 0.25}
    return tuple(RequiredTest(kind, limit, clauses[kind], kind != 'settling_time',
                              status=statuses.get(kind, status))
                 for kind, limit in limits.items())


def _require_of_thd(clauses: Mapping[str, str], secant: bool = False,
                    status: str = VERIFIED) -> tuple[RequiredTest, ...]:
    """Return the tests that transmitting heading devices of all kinds share."""
    return (RequiredTest('resolution', 0.2, clauses['resolution'], status=status),
            RequiredTest('dynamic_error', 1.5, clauses['dynamic_error'], secant, status=status),
            RequiredTest('fast_dynamic_error', 0.5, clauses['dynamic_error'], status=status),
            RequiredTest('follow_up', 0.5, clauses['follow_up'].format(1),
                         rates_deg_s=(0.0, 10.0), status=status),
            RequiredTest('follow_up', 1.5, clauses['follow_up'].format(2),
                         rates_deg_s=(10.0, 20.0), status=status))


PRESETS = {
    'imo_a424': Preset(
        title='gyro-compass, IMO A.424(XI), ISO 8728 class A', rms_deg=0.25, limit_deg=None,
        probability=None, secant=True, status=UNVERIFIED, tests=(
            *_require_of_gyrocompass({
                'settling_time': 'A.424(XI), static conditions', 'settle_point':
                'A.424(XI), static conditions', 'rms_of_ten': 'ISO 8728, static conditions',
                'repeatability': 'ISO 8728, static conditions'}, UNVERIFIED,
                {'settle_point': VERIFIED}),
            RequiredTest('dynamic_error', 1.0, 'A.424(XI), operational conditions', True))),
    'imo_a821': Preset(
        title='gyro-compass for high-speed craft, IMO A.821(19)', rms_deg=0.25, limit_deg=None,
        probability=None, secant=True, status=VERIFIED, tests=(
            *_require_of_gyrocompass({
                'settling_time': 'A.821(19) 4.1.1', 'settle_point': 'A.821(19) 4.1.2',
                'rms_of_ten': 'A.821(19) 4.1.2', 'repeatability': 'A.821(19) 4.1.3'},
                VERIFIED, {}),
            RequiredTest('speed_error', 0.25, 'A.821(19) 4.2.3', True),
            RequiredTest('speed_change', 2.0, 'A.821(19) 4.2.3'),
            RequiredTest('course_change', 3.0, 'A.821(19) 4.2.3'))),
    'imo_msc116': Preset(
        title='transmitting heading device, IMO MSC.116(73)', rms_deg=None, limit_deg=1.0,
        probability=None, secant=False, status=VERIFIED, tests=(
            RequiredTest('static_error', 1.0, 'MSC.116(73) 4.3.2.2'),
            *_require_of_thd({'resolution': 'MSC.116(73) 4.3.2.1',
                              'dynamic_error': 'MSC.116(73) 4.3.2.3',
                              'follow_up': 'MSC.116(73) 4.3.2.4.{}'}))),
    'iso22090_1': Preset(
        title='gyro transmitting heading device, ISO 22090-1', rms_deg=None, limit_deg=1.5,
        probability=None, secant=True, status=UNVERIFIED, tests=(
            *_require_of_thd({'resolution': 'draft of ISO 22090-1, 5.1',
                              'dynamic_error': 'draft of ISO 22090-1, 5.3.2',
                              'follow_up': 'draft of ISO 22090-1, 5.3.4'}, True, UNVERIFIED),
            *(RequiredTest(kind, limit, 'draft of ISO 22090-1, 5.3.3', secant, status=UNVERIFIED)
              for kind, limit, secant in (
                  ('speed_error', 0.35, True), ('speed_change', 3.0, False),
                  ('course_change', 4.5, False))))),
    'iso22090_2': Preset(
        title='magnetic transmitting heading device, ISO 22090-2', rms_deg=None,
        limit_deg=1.0, probability=0.95, secant=False, status=VERIFIED, tests=(
            RequiredTest('static_error', 1.0, 'ISO 22090-2, static error at four headings'),)),
}


def sigma_max_deg(norms: Norms, model: str = 'NN') -> float | None:
    """
    Return the norm of the TS standard deviation.

    Parameters
    ----------
    norms
        The preset gives the norm; without a preset it is `sigma_max_deg`, or follows from
        `limiting_error_max_deg`; both may be None.
    model : {'NN', 'UN', 'NU', 'UU'}
        The TS distribution converts a norm of the largest error to a standard deviation.

    Returns
    -------
    float or None
        Degrees.

    Raises
    ------
    SettingsError
        If the preset is unknown, or needs a latitude that is not given.

    References
    ----------
    GK (2) to (2c): a uniform law on ±Delta has the standard deviation Delta / sqrt 3.

    Examples
    --------
    >>> round(sigma_max_deg(Norms(preset='imo_a821', latitude_deg=60.0)), 9)
    0.5
    >>> round(sigma_max_deg(Norms(limiting_error_max_deg=0.6, k_rule='three')), 9)
    0.2

    """
    preset = _find_preset(norms)
    if preset is None:
        limiting_deg = norms.limiting_error_max_deg
        if limiting_deg is None:
            return norms.sigma_max_deg
        if model[0] == 'U':
            return limiting_deg / math.sqrt(3.0)
        if isinstance(norms.k_rule, float):
            return limiting_deg / norms.k_rule
        return limiting_deg / (3.0 if norms.k_rule == 'three'
                               else ts_factor(model, norms.probability))
    sigma = preset.rms_deg
    if sigma is None:
        limit_deg = cast(float, preset.limit_deg)
        sigma = limit_deg / ts_factor(model, preset.probability or norms.probability)
    return sigma / _divisor(preset, norms)


def systematic_max_deg(norms: Norms) -> float | None:
    """
    Return the norm of the systematic error of the TS: settle point, or static error.

    Parameters
    ----------
    norms
        A required test of it gives the norm; without one it is `systematic_max_deg`, which may be
        None.

    Returns
    -------
    float or None
        Degrees.

    Raises
    ------
    SettingsError
        If the preset is unknown, or needs a latitude that is not given.

    Examples
    --------
    >>> round(systematic_max_deg(Norms(preset='imo_a821', latitude_deg=60.0)), 9)
    1.5

    """
    for test in list_required(norms):
        if test.kind in SYSTEMATIC:
            return test.limit_at(norms.latitude_deg)
    return norms.systematic_max_deg


def list_required(norms: Norms) -> tuple[RequiredTest, ...]:
    """
    Return the tests that a norm requires, with those of one's own in place of its own.

    Raises
    ------
    SettingsError
        If the preset is unknown, or a limit needs a latitude that is not given.

    Examples
    --------
    >>> norms = Norms(preset='iso22090_2', tests='static_error 0.5; rms_of_ten 0.2')
    >>> [(test.kind, test.limit) for test in list_required(norms)]
    [('static_error', 0.5), ('rms_of_ten', 0.2)]

    """
    preset = _find_preset(norms)
    own = read_required_tests(norms.tests)
    limited = {(test.kind, test.rates_deg_s) for test in own}
    tests = [test for test in (() if preset is None else preset.tests)
             if (test.kind, test.rates_deg_s) not in limited]
    if norms.latitude_deg is None and any(test.secant for test in (*tests, *own)):
        raise SettingsError('norms.latitude_deg is missing: a limit of the norm grows with the '
                            'secant of the latitude')
    return (*tests, *own)


def _find_preset(norms: Norms) -> Preset | None:
    if norms.preset is None:
        return None
    preset = PRESETS.get(norms.preset)
    if preset is None:
        raise SettingsError(f'norms.preset = {norms.preset!r}: must be one of '
                            f'{", ".join(PRESETS)}')
    return preset


def _divisor(preset: Preset, norms: Norms) -> float:
    """Return the cosine of the latitude if the norms of a preset grow with its secant, or 1."""
    if not preset.secant:
        return 1.0
    if norms.latitude_deg is None:
        raise SettingsError(f'norms.latitude_deg is missing: the norm {norms.preset} grows '
                            'with the secant of the latitude')
    return math.cos(math.radians(norms.latitude_deg))
