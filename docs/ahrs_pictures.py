#!/usr/bin/env python3
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

"""
Draw the pictures of docs/ahrs.md: levelling, alignment, a day of the gyrocompass.

They show the true state of the platform, which no sensor sees. The script takes a minute:

    python docs/ahrs_pictures.py
    python docs/ahrs_pictures.py levelling
"""

from __future__ import annotations

from pathlib import Path
import sys
from typing import Callable, NamedTuple

from matplotlib.axes import Axes
import numpy as np

from heading_intercompare.ahrs.gimballed.gimballed_ahrs import GimballedAhrs
from heading_intercompare.ahrs.gimballed.modes import Mode, Validity
from heading_intercompare.ahrs.plans import parse_legs
from heading_intercompare.ahrs.sensor_presets import errors_of
from heading_intercompare.ahrs.settings import Ahrs, Errors
from heading_intercompare.ahrs.ship.ship_motion import ShipTruth
from heading_intercompare.report.figures.style import ACCENT, draw, GREY, INK

DOCS = Path(__file__).resolve().parent
LATITUDE_DEG = 45.0
ARCMIN = 60.0 * np.degrees(1.0)
BLOCK_S, STEP_S = 10.0, 0.1
DASHED, DOTTED, DASH_DOTTED = (0, (7, 3)), (0, (2, 3)), (0, (10, 3, 2, 3))


class Track(NamedTuple):
    """True state and claims of an AHRS, one row per control step of 0.1 s."""

    t_s: np.ndarray
    error_arcmin: np.ndarray
    tilt_arcmin: np.ndarray
    sigma_arcmin: np.ndarray
    mode: np.ndarray
    validity: np.ndarray

    def begins(self, mode: Mode) -> float:
        """Return the time at which a mode begins, seconds."""
        return float(self.t_s[np.argmax(self.mode == mode)])


def track(span_s: float, model: str, *, seed: int = 1, seaway: str = 'moored',
          legs: str = '0 30 0', **settings) -> Track:
    """Run an AHRS and return its track."""
    ship = ShipTruth(parse_legs(legs), LATITUDE_DEG, 0.0, seaway, seed)
    ahrs = GimballedAhrs(Ahrs(**settings), errors_of(model, Errors()), ship, seed, 'ts')
    blocks = [ahrs.block() for _ in range(round(span_s / BLOCK_S))]
    rows = [np.concatenate([getattr(block, name)[:100] for block in blocks]) for name in (
        'error_rad', 'alpha_rad', 'beta_rad', 'sigma_rad', 'mode', 'validity')]
    error, alpha, beta, sigma, mode, validity = rows
    return Track(STEP_S * np.arange(error.size), ARCMIN * error, ARCMIN * np.hypot(alpha, beta),
                 ARCMIN * sigma, mode, validity)


def smooth(x: np.ndarray, y: np.ndarray, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a line, each the mean of `every` samples."""
    n = x.size // every * every
    x, y = (column[:n].reshape(-1, every).mean(axis=1) for column in (x, y))
    return x, y


def levelling() -> str:
    """Draw the tilt from the start of coarse levelling to the calibration of the gyro."""
    calm = track(600.0, 'dtg_precision', initial_state='warm', seaway='calm', noise=False)
    moored = track(600.0, 'dtg_precision', initial_state='warm')
    hold_s = moored.begins(Mode.GYRO_CALIBRATION)

    def fill(axes: Axes) -> None:
        axes.plot(*smooth(moored.t_s, moored.tilt_arcmin, 8), color=GREY, linewidth=0.9,
                  label='tilt of the platform, moored ship')
        axes.plot(*smooth(calm.t_s, calm.tilt_arcmin, 20), color=ACCENT, linewidth=2.2,
                  label='the same without sea, noise and drifts')
        axes.plot([0.0, hold_s], [1.773, 1.773], color=INK, linewidth=1.3, linestyle=DASHED,
                  label="what coarse levelling cannot take away: 1.773'")
        axes.axvline(hold_s, color=INK, linewidth=1.3, linestyle=DOTTED,
                     label=f'the integrators take over, {hold_s:.0f} s')
        axes.set_xlim(0.0, 600.0)
        axes.set_xticks(range(0, 601, 60))
        axes.set_ylim(0.0, 8.0)

    return draw(fill, name='levelling', title='Levelling after 2 degrees of tilt, 45 degrees',
                x_label='time since the start of coarse levelling [s]', y_label="tilt [']")


def alignment() -> str:
    """Draw the error of the heading from the slew to the settled gyrocompass."""
    runs = [track(11200.0, 'dtg_precision', seed=seed, initial_state='warm')
            for seed in range(1, 7)]

    def fill(axes: Axes) -> None:
        for seed, run in enumerate(runs, 1):
            begin_s = run.begins(Mode.FINE_LEVELLING)
            late = run.t_s >= begin_s
            minutes = (run.t_s[late] - begin_s) / 60.0
            axes.plot(*smooth(minutes, run.error_arcmin[late], 300), color=ACCENT, linewidth=1.0,
                      label='error in six trials' if seed == 1 else None)
            if seed == 1:
                x, sigma = smooth(minutes, run.sigma_arcmin[late], 300)
                for sign, words in (
                        (1.0, 'standard deviation that is claimed, plus and minus'), (-1.0, None)):
                    axes.plot(x, sign * sigma, color=INK, linewidth=1.6, linestyle=DASHED,
                              label=words)
                settled_s = float(run.t_s[np.argmax(run.validity == Validity.VALID)])
                axes.axvline((run.begins(Mode.GYROCOMPASS) - begin_s) / 60.0, color=INK,
                             linewidth=1.3, linestyle=DOTTED, label='gyrocompass begins')
                axes.axvline((settled_s - begin_s) / 60.0, color=INK, linewidth=1.3,
                             linestyle=DASH_DOTTED, label='called valid')
        axes.set_xlim(0.0, 150.0)
        axes.set_xticks(range(0, 151, 15))
        axes.set_ylim(-6.0, 6.0)

    return draw(fill, name='alignment', x_label='time since the slew [min]',
                y_label="error of the heading [']",
                title='Six alignments and what follows: precision gyros, alongside, 45 degrees')


def day() -> str:
    """Draw the error of three classes of gyrocompasses over a day at sea."""
    legs = '; '.join(f'{7200 * i} {(30, 120, 210, 300)[i % 4]} 12' for i in range(12))
    runs = {model: track(86400.0, model, seaway='ss3', legs=legs, initial_state='aligned', seed=3)
            for model in ('imo', 'marine_0p1', 'dtg_precision')}
    styles = ({'color': '#9a9a9a', 'linewidth': 2.4}, {'color': ACCENT, 'linewidth': 1.4,
                                                       'linestyle': DASHED},
              {'color': INK, 'linewidth': 1.8})

    def fill(axes: Axes) -> None:
        for (model, run), style in zip(runs.items(), styles):
            rms = np.sqrt(np.mean((run.error_arcmin / 60.0)**2))
            axes.plot(*smooth(run.t_s / 3600.0, run.error_arcmin / 60.0, 1200), **style,
                      label=f'{model}: rms {rms:.3f} deg')
        axes.set_xlim(0.0, 24.0)
        axes.set_xticks(range(0, 25, 2))
        axes.set_ylim(-0.7, 0.5)

    return draw(fill, name='day', x_label='time [h]', y_label='error of the heading [deg]',
                title='A day of three gyrocompasses, 12 kn in sea state 3, a turn each 2 h, '
                '45 degrees')


PICTURES: dict[str, Callable[[], str]] = {
    'levelling': levelling, 'alignment': alignment, 'day': day}


if __name__ == '__main__':
    for name in sys.argv[1:] or PICTURES:
        path = DOCS / f'ahrs_{name}.svg'
        path.write_text(PICTURES[name]() + '\n', encoding='utf-8')
        print(f'wrote {path.name}')
