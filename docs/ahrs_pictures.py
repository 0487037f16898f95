#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""
Draw the pictures of docs/ahrs.md: levelling, alignment, a day of the gyrocompass.

They show the true state of the platform, which no sensor sees. It takes a minute:

    python docs/ahrs_pictures.py
    python docs/ahrs_pictures.py levelling
"""

from __future__ import annotations

from pathlib import Path
import sys
from typing import Callable, NamedTuple

import numpy as np

from heading_intercompare.ahrs.gimballed.gimballed_ahrs import GimballedAhrs
from heading_intercompare.ahrs.gimballed.modes import Mode, Validity
from heading_intercompare.ahrs.plans import parse_legs
from heading_intercompare.ahrs.sensor_presets import errors_of
from heading_intercompare.ahrs.settings import Ahrs, Errors
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.report.svg import Plot

DOCS = Path(__file__).resolve().parent
LATITUDE_DEG = 45.0
ARCMIN = 60.0 * np.degrees(1.0)
BLOCK_S, STEP_S = 10.0, 0.1


class Track(NamedTuple):
    """True state and claims of an AHRS, a row for each control step of 0.1 s."""

    t_s: np.ndarray
    error_arcmin: np.ndarray
    tilt_arcmin: np.ndarray
    sigma_arcmin: np.ndarray
    mode: np.ndarray
    validity: np.ndarray

    def begins(self, mode: Mode) -> float:
        """Return when a mode begins, seconds."""
        return float(self.t_s[np.argmax(self.mode == mode)])


def track(span_s: float, model: str, *, seed: int = 1, seaway: str = 'moored',
          legs: str = '0 30 0', **settings) -> Track:
    """Run an AHRS."""
    ship = ShipTruth(parse_legs(legs), LATITUDE_DEG, 0.0, seaway, seed)
    ahrs = GimballedAhrs(Ahrs(**settings), errors_of(model, Errors()), ship, seed, 'ts')
    blocks = [ahrs.block() for _ in range(round(span_s / BLOCK_S))]
    rows = [np.concatenate([getattr(block, name)[:100] for block in blocks]) for name in (
        'error_rad', 'alpha_rad', 'beta_rad', 'sigma_rad', 'mode', 'validity')]
    error, alpha, beta, sigma, mode, validity = rows
    return Track(STEP_S * np.arange(error.size), ARCMIN * error, ARCMIN * np.hypot(alpha, beta),
                 ARCMIN * sigma, mode, validity)


def points(x: np.ndarray, y: np.ndarray, every: int) -> list[tuple[float, float]]:
    """Return the points of a line, each the mean of so many samples."""
    n = x.size // every * every
    means = (column[:n].reshape(-1, every).mean(axis=1) for column in (x, y))
    return list(zip(*(column.tolist() for column in means)))


def levelling() -> Plot:
    """Draw the tilt from the start of coarse levelling to the calibration of the gyro."""
    calm = track(600.0, 'dtg_precision', initial_state='warm', seaway='calm', noise=False)
    moored = track(600.0, 'dtg_precision', initial_state='warm')
    hold_s = moored.begins(Mode.GYRO_CALIBRATION)
    plot = Plot((0.0, 600.0), (0.0, 8.0), title='Levelling after 2 degrees of tilt, 45 degrees',
                x_label='time since the start of coarse levelling [s]', y_label="tilt [']",
                x_step=60.0)
    plot.line(points(moored.t_s, moored.tilt_arcmin, 8), color='#888888',
              legend='tilt of the platform, moored ship')
    plot.line(points(calm.t_s, calm.tilt_arcmin, 20), width=2.2,
              legend='the same without sea, noise and drifts')
    plot.horizontal(1.773, (0.0, hold_s), dash='6 4',
                    legend="what coarse levelling cannot take away: 1.773'")
    plot.vertical(hold_s, dash='2 3', legend=f'the integrators take over, {hold_s:.0f} s')
    return plot


def alignment() -> Plot:
    """Draw the error of the heading from the slew to the settled gyrocompass."""
    plot = Plot((0.0, 150.0), (-6.0, 6.0), x_step=15.0, x_label='time since the slew [min]',
                y_label="error of the heading [']",
                title='Six alignments and what follows: precision gyros, alongside, 45 degrees')
    for seed in range(1, 7):
        run = track(11200.0, 'dtg_precision', seed=seed, initial_state='warm')
        begin_s = run.begins(Mode.FINE_LEVELLING)
        late = run.t_s >= begin_s
        minutes = (run.t_s[late] - begin_s) / 60.0
        plot.line(points(minutes, run.error_arcmin[late], 300), width=1.0,
                  legend='error in six trials' if seed == 1 else '')
        if seed == 1:
            sigma = points(minutes, run.sigma_arcmin[late], 300)
            plot.line(sigma, dash='6 4', color='#666666', width=1.8,
                      legend='standard deviation that is claimed, plus and minus')
            plot.line([(x, -y) for x, y in sigma], dash='6 4', color='#666666', width=1.8)
            settled_s = float(run.t_s[np.argmax(run.validity == Validity.VALID)])
            plot.vertical((run.begins(Mode.GYROCOMPASS) - begin_s) / 60.0, dash='2 3',
                          legend='gyrocompass begins')
            plot.vertical((settled_s - begin_s) / 60.0, dash='10 3 2 3', legend='called valid')
    return plot


def day() -> Plot:
    """Draw the error of three classes of gyrocompasses over a day at sea."""
    legs = '; '.join(f'{7200 * i} {(30, 120, 210, 300)[i % 4]} 12' for i in range(12))
    plot = Plot((0.0, 24.0), (-0.7, 0.5), x_step=2.0, x_label='time [h]',
                y_label='error of the heading [deg]', title='A day of three gyrocompasses, 12 '
                'kn in sea state 3, a turn each 2 h, 45 degrees')
    for model, style, words in (
            ('imo', {'color': '#999999', 'width': 2.2}, 'imo'),
            ('marine_0p1', {'dash': '7 3'}, 'marine_0p1'),
            ('dtg_precision', {'width': 1.8}, 'dtg_precision')):
        run = track(86400.0, model, seaway='ss3', legs=legs, initial_state='aligned', seed=3)
        plot.line(points(run.t_s / 3600.0, run.error_arcmin / 60.0, 1200), **style,
                  legend=f'{words}: rms {np.sqrt(np.mean((run.error_arcmin / 60.0)**2)):.3f} deg')
    return plot


PICTURES: dict[str, Callable[[], Plot]] = {
    'levelling': levelling, 'alignment': alignment, 'day': day}


if __name__ == '__main__':
    for name in sys.argv[1:] or PICTURES:
        path = DOCS / f'ahrs_{name}.svg'
        path.write_text(PICTURES[name]().svg() + '\n', encoding='utf-8')
        print(f'wrote {path.name}')
