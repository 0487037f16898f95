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
from typing import cast

from heading_intercompare.core.declared_settings import SettingsError
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
    content
        The main requirements of the document.
    status
        'verified' against the document, or 'unverified': from secondary sources or a draft.
    systematic_deg
        Norm of the systematic error: of the settle point, or the static error; degrees.

    """

    title: str
    rms_deg: float | None
    limit_deg: float | None
    probability: float | None
    secant: bool
    content: str
    status: str
    systematic_deg: float | None = None


PRESETS = {
    'imo_a424': Preset(
        title='gyro-compass, IMO A.424(XI), ISO 8728 class A', rms_deg=0.25, limit_deg=None,
        probability=None, secant=True, content=(
            'settle-point error 0.75 sec(lat); rms of ten readings 0.25 sec(lat); dynamic 1.0 '
            'sec(lat)'), status='unverified', systematic_deg=0.75),
    'imo_a821': Preset(
        title='gyro-compass for high-speed craft, IMO A.821(19)', rms_deg=0.25, limit_deg=None,
        probability=None, secant=True, content=(
            'settles within 6 h up to 70 deg; settle-point error 0.75 sec(lat); '
            'rms 0.25 sec(lat); repeatability 0.25 sec(lat)'),
        status='verified', systematic_deg=0.75),
    'imo_msc116': Preset(
        title='transmitting heading device, IMO MSC.116(73)', rms_deg=None, limit_deg=1.0,
        probability=None, secant=False,
        content='static error 1.0; dynamic amplitude 1.5; follow-up 0.5 up to 10 deg/s',
        status='verified', systematic_deg=1.0),
    'iso22090_1': Preset(title='gyro transmitting heading device, ISO 22090-1', rms_deg=None,
                         limit_deg=1.5, probability=None, secant=True,
                         content='dynamic error 1.5 sec(lat)', status='unverified'),
    'iso22090_2': Preset(title='magnetic transmitting heading device, ISO 22090-2', rms_deg=None,
                         limit_deg=1.0, probability=0.95, secant=False,
                         content='static error 1.0 (95 %), at four headings or more',
                         status='verified', systematic_deg=1.0),
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
        The preset gives the norm; without one, or if it has none, it is `systematic_max_deg`,
        which may be None.

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
    preset = _find_preset(norms)
    if preset is None or preset.systematic_deg is None:
        return norms.systematic_max_deg
    return preset.systematic_deg / _divisor(preset, norms)


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
