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

"""Errors of the sensor models by name: gimballed AHRS, strapdown gyros, satellite compasses."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
import math
from typing import Any

from .settings import Errors, Sensor

_SENSORS: dict[str, dict[str, float]] = {
    'ideal': {},
    'gnss_compass': {'white_deg': 0.05, 'markov_deg': 0.08, 'markov_tau_s': 200.0},
    'gnss_0p5m': {'white_deg': 0.2, 'markov_deg': 0.3, 'markov_tau_s': 200.0},
    'gnss_5m': {'white_deg': 0.02, 'markov_deg': 0.03, 'markov_tau_s': 200.0},
    'gnss_harbour': {'white_deg': 0.05, 'markov_deg': 0.25, 'markov_tau_s': 60.0,
                     'outage_every_s': 600.0, 'outage_s': 20.0},
    'fog_strapdown': {'white_deg': 0.01, 'markov_deg': 0.13, 'markov_tau_s': 3600.0,
                      'tone_deg': 0.07},
    'rlg_strapdown': {'white_deg': 0.002, 'markov_deg': 0.06, 'markov_tau_s': 7200.0,
                      'tone_deg': 0.05},
    'dtg_precision': {},
    'marine_0p1': {},
    'imo': {},
}
"""Error terms added to the heading: satellite compasses with bases of 2 m, 0.5 m and 5 m, one of
2 m between cranes and bridges, and strapdown gyros. An AHRS has none, because its errors come from
the model. docs/ahrs.md says where the figures come from."""

_OWN_FIRST = ('markov_tau_s', 'outage_every_s', 'outage_s')


@dataclass(frozen=True, slots=True)
class ModelErrors:
    """
    Errors of the instruments of one model of AHRS, all known: see `settings.Errors`.

    The defaults are those of the model dtg_precision.
    """

    turn_on_deg_h: float = 0.03
    markov_deg_h: float = 0.003
    markov_tau_s: float = 7200.0
    random_walk_deg_sqrt_h: float = 0.001
    temperature_deg_h_k: float = 0.02
    soak_deg_h: float = 0.02
    soak_tau_s: float = 5400.0
    torquer_ppm: float = 0.0
    spin_axis_arcsec: float = 1.0
    residual_xy_deg_h: float = 0.008
    residual_z_deg_h: float = 0.005
    accelerometer_bias_ug: float = 50.0
    accelerometer_markov_ug: float = 5.0
    accelerometer_markov_tau_s: float = 3600.0
    accelerometer_white_ug: float = 5.0
    accelerometer_temperature_ug_k: float = 5.0
    accelerometer_step_m_s: float = 1e-4
    log_scale: float = 0.005
    log_markov_m_s: float = 0.01
    log_markov_tau_s: float = 600.0
    gps_deg: float = 0.1
    gps_tau_s: float = 100.0
    follow_up_s: float = 0.02
    harmonic_arcsec: float = 20.0
    harmonic2_arcsec: float = 10.0
    coupling: float = 0.005
    flexure_deg: float = 0.005
    flexure_tau_s: float = 600.0
    output_deg: float = 0.003


ERRORS = {
    'dtg_precision': ModelErrors(),
    'marine_0p1': ModelErrors(
        markov_deg_h=0.015, markov_tau_s=3600.0, random_walk_deg_sqrt_h=0.002,
        torquer_ppm=50.0, residual_xy_deg_h=0.021, residual_z_deg_h=0.010,
        accelerometer_bias_ug=100.0, accelerometer_markov_ug=10.0, accelerometer_white_ug=10.0),
    'imo': ModelErrors(
        turn_on_deg_h=0.1, markov_deg_h=0.035, markov_tau_s=3600.0,
        random_walk_deg_sqrt_h=0.006, temperature_deg_h_k=0.05, soak_deg_h=0.10,
        torquer_ppm=200.0, spin_axis_arcsec=3.0, residual_xy_deg_h=0.045,
        residual_z_deg_h=0.030, accelerometer_bias_ug=300.0, accelerometer_markov_ug=30.0,
        accelerometer_white_ug=30.0, accelerometer_temperature_ug_k=10.0,
        accelerometer_step_m_s=1e-3),
}
"""Errors of the three classes of gimballed AHRS."""


def errors_of(model: str, overrides: Errors) -> ModelErrors:
    """
    Return the errors of a model, with those in `overrides` replaced.

    Parameters
    ----------
    model
        A name of `ERRORS`.
    overrides
        Errors that are not None replace those of the model.

    """
    replacements = {f.name: getattr(overrides, f.name) for f in fields(overrides)
                    if getattr(overrides, f.name) is not None}
    return replace(ERRORS[model], **replacements)


def terms_of(sensor: Sensor) -> Sensor:
    """Return the settings with the error terms of the model added to those given."""
    terms: dict[str, Any] = {}
    for name, value in _SENSORS[sensor.model].items():
        if name in _OWN_FIRST:
            own_term = sensor.markov_deg if name == 'markov_tau_s' else sensor.outage_every_s
            terms[name] = getattr(sensor, name) if own_term else value
        else:
            terms[name] = math.hypot(getattr(sensor, name), value)
    return replace(sensor, **terms)
