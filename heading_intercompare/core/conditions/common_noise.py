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

"""Whether the TS also shows the noise of the RS, which means that both have one source."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
import math
from typing import Sequence

import numpy as np
from numpy.typing import ArrayLike

from heading_intercompare.core.angles import unwrap_deg
from heading_intercompare.core.pairing.interpolation_kernel import interpolated_response
from heading_intercompare.core.timing.bracketing_readings import (
    pairs_per_reading,
    readings_per_pair,
)
from heading_intercompare.core.timing.cubic_spline import CubicSpline

# Spectra. Segments of two minutes resolve a swell, and half an hour gives 28 of them at half
# overlap; more than 160, or a quarter of a million samples, tell nothing new.
_SEGMENT_S = 128.0
_MOST_SEGMENTS, _LEAST_SEGMENTS = 160, 6
_MOST_SAMPLES = 1 << 18
_LEAST_LENGTH = 64
#: Readings further apart fold the motion of a ship into all frequencies, seconds.
_LONGEST_STEP_S = 1.25
#: Stamps further from even times than this share of a step are interpolated there.
_UNEVEN = 1e-3
#: A sensor is slower than the pairs from this ratio of the rates on.
_SLOWER = 1.1
#: Segments with this multiple of the usual power at high frequencies are turns, those with this
#: kurtosis of their fourth differences are glitches: both are left out.
_QUIET, _KURTOSIS = 4.0, 8.0

# The floor. The spectrum is seen in 24 groups of frequencies, of which 8 must be usable. Where
# interpolation leaves less than 0.15 of the power, dividing by that would only raise noise.
_GROUPS, _LEAST_GROUPS = 24, 8
_RESPONSE = 0.15
#: Groups within twice the lowest three are flat: chi-square of 12 degrees of freedom stays there.
_FLAT, _BEST = 2.0, 3
#: Noise is flat over 0.6 of the frequencies, or over a quarter above a fall by 50, which motion
#: folded once does not show; above its lowest frequency 0.8 of the groups are flat.
_SHARE, _SHARE_STEEP, _STEEP = 0.6, 0.25, 50.0
_NEARLY_ALL = 0.8
#: Noise below that of rounding, in squares of the step, and a thousandth of a degree are shared
#: by sensors that round the same motion. A twelfth, and as much again at three standard errors.
_ROUNDING = 1.0 / 12.0 + 0.09
_LEAST_NOISE_DEG = 0.001

# The share. Independent pairs have an excess coherence of -0.13 to 0.03 (benchmark
# `same_source`); a floor that may hold as much motion as noise allows for 0.75.
_COMMON, _COMMON_STEEP = 0.15, 0.75
#: A smaller excess from here on is a doubt.
_DOUBT = 0.06
#: Six standard deviations of chance; the motion is seen with three standard errors.
_CHANCE, _UNSURE = 6.0, 3.0
#: Fewest frequencies in a group of the fine grid, an eighth of its start.
_FEWEST = 6
_INTERPOLATED = 1e-6
#: Exponents of the noise spectrum, and the frequency above which no ship moves like that, Hz.
_COLOURS = (0, 0.0), (2, 1.0)


@dataclass(frozen=True, slots=True)
class FollowedNoise:
    """
    How much of the noise of one sensor shows in the other.

    Attributes
    ----------
    kind : {'common', 'unsure', 'independent', 'not_testable'}
        'common': the other sensor follows it. 'unsure': that sensor does so significantly, but
        less than a copy would. 'not_testable': the sensor shows no noise of its own, above its
        rounding and over most of the frequencies.
    band_hz : pair of float or None
        Frequencies at which the sensor shows its noise rather than the motion of the ship.
    noise_deg
        Standard deviation of that noise, as if it were white, degrees.
    coherence
        Share that follows linearly there, minus the part that the motion explains: the largest
        mean of three neighbouring groups of frequencies.

    """

    kind: str = 'not_testable'
    band_hz: tuple[float, float] | None = None
    noise_deg: float | None = None
    coherence: float | None = None


@dataclass(frozen=True, slots=True)
class CommonNoise:
    """
    How much of their noise the sensors share.

    Attributes
    ----------
    reason
        Why nothing is testable: 'too_short'; 'too_slow' if readings more than 1.25 s apart fold
        the motion. Empty otherwise.
    segments
        Number of time segments that the spectra average.
    of_rs, of_ts
        The noise of the RS in the TS, and the noise of the TS in the RS.

    """

    reason: str = ''
    segments: int = 0
    of_rs: FollowedNoise = FollowedNoise()
    of_ts: FollowedNoise = FollowedNoise()

    @property
    def kind(self) -> str:
        """
        Return the conclusion from both directions.

        'common' or 'unsure' if one direction is. 'independent' only if both directions are: a
        repeater of a TS without noise may add noise of its own. Otherwise 'not_testable'.
        """
        kinds = self.of_rs.kind, self.of_ts.kind
        for kind in ('common', 'unsure'):
            if kind in kinds:
                return kind
        return 'independent' if kinds == ('independent', 'independent') else 'not_testable'

    @property
    def strongest(self) -> FollowedNoise:
        """Return the direction with the largest coherence."""
        return max(self.of_rs, self.of_ts, key=lambda noise: noise.coherence or -math.inf)


def find_common_noise(stamp_ns: ArrayLike, x_deg: ArrayLike, rs_deg: ArrayLike, *,
                      factor: ArrayLike | None = None, interpolates_ts: bool = False,
                      rs_step_deg: float | None = None,
                      ts_step_deg: float | None = None) -> CommonNoise:
    """
    Look for the noise of each sensor in the other.

    Parameters
    ----------
    stamp_ns : array_like of int, shape (n,)
        Stamps of the pairs in increasing order, nanoseconds.
    x_deg, rs_deg : array_like, shape (n,)
        Differences and headings of the RS, finite, degrees.
    factor : array_like, shape (n,), optional
        Factor by which interpolation reduces the variance of white noise; default 1.
    interpolates_ts
        Whether the TS is interpolated, not the RS.
    rs_step_deg, ts_step_deg
        Steps in which RS and TS report, degrees. Noise below that of rounding does not count,
        because sensors that round the same motion make the same errors. The step of an
        interpolated sensor is unknown; the step of the other sensor replaces it.

    Returns
    -------
    CommonNoise

    Notes
    -----
    The motion of a ship dies away at high frequencies; white noise does not. Two sensors share
    the motion. A sensor that copies the other, even late, filtered, rounded or with noise added,
    also shares its noise.

    If the spectrum of a sensor is flat over 60 % of the frequencies, the squared coherence of two
    separate sensors is at most the share of the motion, 1 - floor/spectrum. An excess above 0.15
    and above six standard deviations of chance indicates one source, one above 0.06 is a doubt.
    A quarter of the frequencies suffices if the spectrum falls by a factor of 50 or more from the
    middle of the band to the floor, which folded motion does not. Motion may still be half of the
    floor, so the excess must then be above 0.75. Above 1 Hz the noise may also fall with the
    square of the frequency, which no ship's motion does.

    A copy with noise of its own shows little of it in the other, so both directions are tested. A
    sensor slower than the pairs is used at its own rate. Segments with turns are left out.

    References
    ----------
    Welch 1967 on segments of about 128 s of second differences, window cos^4; E.20 of
    ``docs/diagnostics.md``.

    """
    stamps = np.asarray(stamp_ns)
    rs, x = (np.asarray(v, dtype=np.float64) for v in (rs_deg, x_deg))
    cut = _segments(stamps, x, rs, factor)
    if cut is None:
        return CommonNoise('too_short')
    step_s, ts, rs, mean_factor = cut
    if step_s > _LONGEST_STEP_S:
        return CommonNoise('too_slow')
    frequency, power, whole, cross, segments = _spectra(step_s, ts, rs)
    if segments < _LEAST_SEGMENTS:
        return CommonNoise('too_short', segments)
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        coherence = np.where((power > 0.0) & (whole > 0.0),
                             np.abs(cross / np.sqrt(power) / np.sqrt(whole)) ** 2, 0.0)
    coherence = (coherence - 1.0 / segments) / (1.0 - 1.0 / segments)
    steps = {'rs': rs_step_deg, 'ts': ts_step_deg}
    factors = {'rs': 1.0, 'ts': 1.0, 'ts' if interpolates_ts else 'rs': mean_factor}
    noises = []
    for sensor, partner, spectrum in (('rs', 'ts', power), ('ts', 'rs', whole)):
        step_deg = steps[sensor]
        if step_deg is None and factors[sensor] < 1.0 - _INTERPOLATED:
            step_deg = steps[partner]
        # A sensor faster than the pairs folds its noise, which is then as white as it was.
        responses = [interpolated_response(factors[sensor], round(1e9 * step_s),
                                           frequency / frequency[-1])]
        if factors[sensor] < 1.0 - _INTERPOLATED:
            responses.append(np.ones(frequency.size))
        noises.append(_follow(frequency, spectrum, coherence, responses, step_deg or 0.0,
                              segments))
    return CommonNoise('', segments, *noises)


def _follow(frequency: np.ndarray, power: np.ndarray, coherence: np.ndarray,
            responses: Sequence[np.ndarray], step_deg: float, segments: int) -> FollowedNoise:
    """Judge how much of the noise of the sensor with this spectrum shows in the other."""
    edges = np.unique(np.linspace(1, frequency.size, _GROUPS + 1).astype(np.int64))
    grouped = _Groups(edges)
    middle = grouped(frequency)
    sine = np.sin(0.5 * np.pi * middle / frequency[-1])
    for response, (exponent, lowest_hz) in product(responses, _COLOURS):
        level = grouped(power) / np.maximum(grouped(response), _RESPONSE)
        usable = (grouped(response) >= _RESPONSE) & (middle >= lowest_hz)
        if np.count_nonzero(usable) < _LEAST_GROUPS:
            continue
        # Noise of this colour is flat once multiplied by the power of the sine.
        flattened = level * sine ** exponent
        lowest = float(np.sort(flattened[usable])[:_BEST].mean())
        flat = _select_flat(usable, flattened <= _FLAT * lowest)
        floor = float(np.median(flattened[flat])) if flat.any() else 0.0
        share = np.count_nonzero(flat) / np.count_nonzero(usable)
        steep = exponent == 0 and level[_GROUPS // 2 - 1] >= _STEEP * floor
        if share < (_SHARE_STEEP if steep else _SHARE) \
                or floor <= max(_ROUNDING * step_deg ** 2, _LEAST_NOISE_DEG ** 2):
            continue
        noise_deg = math.sqrt(float(level[flat].mean()))
        where = np.flatnonzero(flat)
        band_hz = (float(frequency[edges[where[0]]]), float(frequency[edges[where[-1] + 1] - 1]))
        fine = _Groups(_make_growing_groups(frequency.size))
        spectrum = fine(power) * fine(np.sin(0.5 * np.pi * frequency / frequency[-1])) ** exponent
        # A sensor faster than the pairs has a flat response, which the pairs cannot show.
        unshaped = float(np.median((grouped(power) * sine ** exponent)[flat])) / spectrum
        spectrum /= np.maximum(fine(response), _RESPONSE)
        inside = (fine(response) >= _RESPONSE) & (fine(frequency) >= lowest_hz)
        inside = _select_flat(inside, spectrum <= _FLAT * floor)
        if exponent:
            # Over a narrow band, white noise plus motion also looks like that colour.
            white = fine(power) / np.maximum(fine(response), _RESPONSE)
            unshaped = np.minimum(unshaped, float(np.sort(level[usable])[:_BEST].mean()) / white)
        motion = np.maximum(0.0, 1.0 - floor / spectrum)
        if share >= _SHARE:
            # The spectrum that shows the motion is itself uncertain by some standard errors.
            unsure = 1.0 + _UNSURE * np.sqrt(2.0 / (_BEST * segments * fine.width))
            motion = np.minimum(1.0, np.maximum(motion, 1.0 - unshaped) * unsure)
        excess = (fine(coherence) - motion)[inside]
        if not excess.size:
            continue
        wide = min(_BEST, excess.size)
        best = float(np.convolve(excess, np.full(wide, 1.0 / wide), 'valid').max())
        chance = _CHANCE / segments / math.sqrt(wide * _FEWEST)
        kind = 'independent'
        if best > max(_COMMON if share >= _SHARE else _COMMON_STEEP, chance):
            kind = 'common'
        elif share >= _SHARE and best > max(_DOUBT, chance):
            kind = 'unsure'
        return FollowedNoise(kind, band_hz, noise_deg, best)
    return FollowedNoise()


def _select_flat(usable: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Select the usable groups from the lowest frequency above which nearly all are low."""
    count = np.cumsum(usable[::-1])[::-1]
    share = np.cumsum((usable & low)[::-1])[::-1] / np.maximum(count, 1)
    begins = np.flatnonzero(usable & low & (share >= _NEARLY_ALL))
    good: np.ndarray = low
    if begins.size:
        good = np.arange(usable.size) >= begins[0]
    return np.asarray(usable & good)


class _Groups:
    """Means over groups of frequencies."""

    def __init__(self, edges: np.ndarray) -> None:
        self._first, self.width = edges[:-1], np.diff(edges)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values, self._first) / self.width


def _make_growing_groups(n: int) -> np.ndarray:
    """Return edges of groups of at least six frequencies, each about an eighth of its start."""
    edges = [1]
    while edges[-1] < n:
        edges.append(edges[-1] + max(_FEWEST, edges[-1] // 8))
    return np.array([*(e for e in edges if e <= n - _FEWEST), n])


def _segments(stamps: np.ndarray, x: np.ndarray, rs: np.ndarray, factor: ArrayLike | None,
              ) -> tuple[float, np.ndarray, np.ndarray, float] | None:
    """Return step, segments of TS and RS at even times, and the mean factor of those used."""
    n = stamps.size
    if n < _LEAST_LENGTH * _LEAST_SEGMENTS // 2:
        return None
    ts_deg = (x[:100_000] + rs[:100_000]) % 360.0
    every = max(readings_per_pair(stamps, rs), readings_per_pair(stamps, ts_deg))
    step = float(np.median(np.diff(stamps[:100_001]))) / 1e9
    if step <= 0.0:
        return None
    step *= every
    f = None if factor is None else np.asarray(factor, dtype=np.float64)
    # With 7 pairs and 5 RS readings per second, the ratio is no whole number.
    slower = pairs_per_reading(f) if f is not None and every == 1 else 1.0
    longest = 2.0 * n / every / (_LEAST_SEGMENTS + 3)
    length = 1 << round(math.log2(max(_SEGMENT_S / step, _LEAST_LENGTH)))
    while length > longest and length > _LEAST_LENGTH:
        length //= 2
    span = length * every
    if span > n:
        return None
    ts_segments, rs_segments, factors = [], [], []
    for lo in _choose_begins(n, span, length):
        pick = _pick_readings(stamps, f, lo, length, every, step)
        if pick is None:
            continue
        t = (stamps[pick] - stamps[lo]) / 1e9
        heading = unwrap_deg(rs[pick])
        both = np.stack((heading + unwrap_deg(x[pick]), heading), axis=1)
        both = _make_even(t, both, step, slower)
        ts_segments.append(both[:, 0])
        rs_segments.append(both[:, 1])
        if f is not None:
            factors.append(float(f[pick].mean()))
    if not ts_segments:
        return None
    step *= slower if slower > _SLOWER else 1.0
    return (step, np.array(ts_segments), np.array(rs_segments),
            float(np.mean(factors)) if factors else 1.0)


def _choose_begins(n: int, span: int, length: int) -> list[int]:
    """Return where segments begin, overlapping by half; of very many an even choice."""
    begins = np.arange(0, n - span + 1, span // 2)
    most = min(_MOST_SEGMENTS, _MOST_SAMPLES // length)
    if begins.size > most:
        begins = begins[np.linspace(0, begins.size - 1, most).astype(np.int64)]
    return [int(begin) for begin in begins]


def _pick_readings(stamps: np.ndarray, factor: np.ndarray | None, lo: int, length: int,
                   every: int, step_s: float) -> slice | None:
    """Return one pair of each reading of a segment; None across a gap or a step back."""
    span = length * every
    t = (stamps[lo:lo + span] - stamps[lo]) / 1e9
    if t[-1] > 1.25 * span / every * step_s:
        return None
    at = 0 if factor is None or every == 1 else int(np.argmax(
        factor[lo:lo + span].reshape(length, every).mean(axis=0)))
    return slice(lo + at, lo + span, every) if (np.diff(t[at::every]) > 0.0).all() else None


def _make_even(t: np.ndarray, both: np.ndarray, step_s: float, slower: float) -> np.ndarray:
    """Return both headings at even times: uneven ones would put the same false noise on both."""
    length = t.size
    even = np.linspace(t[0], t[-1], length)
    if slower > _SLOWER:
        even = t[0] + (t[-1] - t[0]) / (length - 1) * slower * np.arange(
            int((length - 1) / slower) + 1)
    if slower > _SLOWER or np.abs(t - even).max() > _UNEVEN * step_s:
        return CubicSpline(t, both)(even)
    return both


def _spectra(step_s: float, ts: np.ndarray, rs: np.ndarray,
             ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    """Return frequencies, spectra of RS and TS, their cross-spectrum, and the segments used."""
    rs, ts = np.diff(rs, 2, axis=1), np.diff(ts, 2, axis=1)
    # Glitches, and wave impacts faster than the readings, are not noise.
    square = np.diff(rs, 2, axis=1) ** 2
    quiet = (square ** 2).mean(axis=1) <= _KURTOSIS * square.mean(axis=1) ** 2
    m = rs.shape[1]
    window = np.sin(np.pi * (np.arange(m) + 0.5) / m) ** 4
    phase = 2.0 * np.pi * np.fft.rfftfreq(m)
    # Second differences of unit white noise have the spectrum 4 (1 - cos)^2, zero at first.
    gain = np.maximum(4.0 * (1.0 - np.cos(phase)) ** 2, 1e-300) * float(window @ window)
    rs, ts = (np.fft.rfft(h * window, axis=1) for h in (rs, ts))
    rs2, ts2 = np.abs(rs) ** 2, np.abs(ts) ** 2
    for square in (rs2, ts2):
        high = square[:, m // 4:].sum(axis=1)
        quiet &= high <= _QUIET * np.median(high)
    if not quiet.any():
        quiet[:1] = True
    rs, ts = rs[quiet], ts[quiet]
    return (phase / (2.0 * np.pi * step_s), rs2[quiet].mean(axis=0) / gain,
            ts2[quiet].mean(axis=0) / gain, (rs.conj() * ts).mean(axis=0) / gain, rs.shape[0])
