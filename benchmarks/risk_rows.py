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

"""The rows of the risk tables that judge one run at a time; see `decision_risk`."""

from __future__ import annotations

from dataclasses import dataclass, replace
import math
from typing import Iterator

from error_processes import (
    ar1,
    as_laplace,
    as_student5,
    as_uniform,
    calm_then_rough,
    Errors,
    five_gaps,
    half_missing,
    jittered,
    mixed,
    narrow_band,
    one_in_four,
    one_missing,
    quantised,
    ramp,
    Sampling,
    sea_state,
    seconds_on_and_off,
    some_lost,
    white,
)

AUTO = -1
"""Drift order chosen from the data, at most 3; the bounds are then those of order 3."""

JUDGED_FROM = 20
"""Correlation times from which the risks are promised; shorter rows are only reported."""

PERIODS = 5.0


@dataclass(frozen=True, slots=True)
class Row:
    """
    A process and a length.

    Attributes
    ----------
    name
        Unique in its table, because it is the seed.
    n
        Number of instants at equal steps; all have a sample unless `sampling` says otherwise.
    errors
        Error process of variance 1.
    times
        Correlation (coherence) times in the record; infinite without correlation.
    order
        Order of the polynomial removed; `AUTO` to choose it from the data.
    drift
        Order of a drift of three standard deviations that is added first; 0 for none.
    sampling
        The instants that have a sample.
    rate_hz
        Rate of the instants; 0 for samples without stamps.
    stated
        Slowest error stated to the rule, in correlation times; 0: none.

    """

    name: str
    n: int
    errors: Errors
    times: float = math.inf
    order: int = 0
    drift: int = 0
    sampling: Sampling | None = None
    rate_hz: float = 0.0
    stated: float = 0.0

    @property
    def is_judged(self) -> bool:
        """Whether the row can fail: long enough, and no error slower than stated."""
        return self.times >= JUDGED_FROM and not 0.0 < self.stated < 1.0


def band(coherence: float) -> Errors:
    """Return narrow-band errors: five periods per coherence time, at least four samples each."""
    return narrow_band(coherence, max(coherence / PERIODS, 4.0))


def half(errors: Errors) -> Errors:
    """Return errors half of whose variance is white."""
    return mixed(0.5, white, errors)


def table_a() -> Iterator[Row]:
    """Yield the rows of the risks of one run."""
    for n in (600, 6000, 60_000):
        yield Row(f'white, n = {n}', n, white)
    lengths = ((20, 600), (30, 900), (50, 1000), (100, 2000), (300, 6000), (1000, 20_000))
    for times, n in lengths:
        yield Row(f'AR(1), {times}', n, ar1(n / times), times)
    for times in (20, 50, 100, 300):
        yield Row(f'narrow band, {times}', 60 * times, band(60.0), times)
    for times, n in lengths[:5]:
        yield Row(f'0.5 white + 0.5 AR(1), {times}', n, half(ar1(n / times)), times)
    for times, n in (lengths[0], lengths[3]):
        yield Row(f'0.8 white + 0.2 AR(1), {times}', n, mixed(0.8, white, ar1(n / times)), times)
    for times in (20, 50, 100, 300):
        yield Row(f'0.5 white + 0.5 narrow band, {times}', 60 * times, half(band(60.0)), times)
    for times in (20, 100):
        yield Row(f'0.8 white + 0.2 narrow band, {times}', 60 * times,
                  mixed(0.8, white, band(60.0)), times)
    for times, n in ((20, 1800), (50, 4500)):
        yield Row(f'0.5 AR(1) + 0.5 AR(1) 30 times slower, {times}', n,
                  mixed(0.5, ar1(n / times / 30.0), ar1(n / times)), times)
    for name, made in (('Laplace', as_laplace), ('Student-5', as_student5)):
        for times, n in lengths[2:]:
            yield Row(f'{name} AR(1), {times}', n, made(ar1(n / times)), times)
        yield Row(f'{name} white, n = 1000', 1000, made(white))
    yield Row('uniform AR(1), 100', 2000, as_uniform(ar1(20.0)), 100)
    yield Row('AR(1) in steps of 2 sigma, 100', 2000, quantised(2.0, ar1(20.0)), 100)
    yield Row('white in steps of 1 sigma, n = 2000', 2000, quantised(1.0, white))
    for order in (1, 2):
        for times, n in lengths[2:5]:
            yield Row(f'AR(1), {times}, drift of order {order} removed', n, ar1(n / times), times,
                      order, order)
    yield Row('white, calm then rough, n = 3000', 3000, calm_then_rough(white))
    yield Row('AR(1), calm then rough, 100', 2000, calm_then_rough(ar1(20.0)), 100)
    yield Row('AR(1), growing, 100', 2000, ramp(ar1(20.0)), 100)
    for times in (20, 50, 100):
        yield Row(f'sea state of sd 0.7, white, {times}', 60 * times,
                  sea_state(0.7, 60.0, white), times)
    for times in (20, 50):
        yield Row(f'sea state of sd 0.5, {times}, on AR(1), 100', 1000,
                  sea_state(0.5, 1000.0 / times, ar1(10.0)), times)


def table_cells() -> Iterator[Row]:
    """Yield the rows of table A with the sample in the middle missing."""
    for row in table_a():
        yield replace(row, sampling=one_missing, rate_hz=10.0)


def table_drift() -> Iterator[Row]:
    """Yield the rows of the risks after a drift was removed."""
    processes = [
        ('AR(1)', 20.0, ar1), ('0.5 white + 0.5 AR(1)', 20.0, lambda tau: half(ar1(tau))),
        ('Laplace AR(1)', 20.0, lambda tau: as_laplace(ar1(tau))), ('narrow band', 60.0, band),
        ('0.5 white + 0.5 narrow band', 60.0, lambda tau: half(band(tau))),
        ('sea state of sd 0.7, white', 60.0, lambda tau: sea_state(0.7, tau, white))]
    for name, samples, made in processes:
        for times in ((50, 100) if name.startswith('Laplace') else (20, 50, 100)):
            tau = 30.0 if times == 20 and samples == 20.0 else samples
            yield from _drifts(f'{name}, {times}', round(tau * times), made(tau), times)
    yield from _drifts('white, n = 600', 600, white, math.inf)


def _drifts(name: str, n: int, errors: Errors, times: float) -> Iterator[Row]:
    for order in range(4):
        yield Row(f'{name}; order {order}', n, errors, times, order, order)
    for drift in (0, 2):
        yield Row(f'{name}; auto, order {drift} there', n, errors, times, AUTO, drift,
                  rate_hz=10.0)


def table_gaps() -> Iterator[Row]:
    """Yield the rows of gaps and unequal steps; times count only data, not long gaps."""
    gaps = [('five gaps of 6 %', five_gaps, 1, 0.7), ('half of it missing', half_missing, 1, 0.5),
            ('one of four kept at random', one_in_four, 4, 1.0),
            ('1 % lost at random', some_lost, 1, 1.0), ('steps of 0.2 to 1.8', jittered, 10, 1.0),
            ('ten of twenty', seconds_on_and_off, 2, 1.0)]
    for name, sampling, fine, kept in gaps:
        for process, tau, made, times in (
                ('AR(1)', 20, ar1, 100), ('AR(1)', 30, ar1, 20),
                ('0.5 white + 0.5 narrow band', 60, lambda tau: half(band(tau)), 33)):
            n = round(tau * times / kept) * fine
            yield Row(f'{process}, {times}; {name}', n, made(tau * fine), times,
                      sampling=sampling, rate_hz=10.0)
        yield Row(f'white; {name}', 2000 * fine, white, sampling=sampling, rate_hz=10.0)
    for name, sampling, kept in (('five gaps of 6 %', five_gaps, 0.7),
                                 ('half of it missing', half_missing, 0.5)):
        times = 20 * kept
        yield Row(f'AR(1), {times:g}; {name}', 600, ar1(30.0), times, sampling=sampling,
                  rate_hz=10.0)


def table_short() -> Iterator[Row]:
    """Yield the rows of few samples."""
    for times in (2, 4, 8, 20):
        for n in (128, 200, 512, 1200):
            yield Row(f'0.5 white + 0.5 AR(1), {times}, n = {n}', n, half(ar1(n / times)), times)
    for n in (128, 200, 512, 1200):
        tau = n / 20.0
        for name, errors in (
                ('AR(1)', ar1(tau)), ('narrow band', band(tau)),
                ('0.5 white + 0.5 narrow band', half(band(tau))),
                ('sea state of sd 0.7, white', sea_state(0.7, tau, white))):
            yield Row(f'{name}, 20, n = {n}', n, errors, 20)
        yield Row(f'Laplace AR(1), 50, n = {n}', n, as_laplace(ar1(n / 50.0)), 50)
        yield Row(f'Student-5 AR(1), 50, n = {n}', n, as_student5(ar1(n / 50.0)), 50)
        yield Row(f'Student-5 white, n = {n}', n, as_student5(white))
        yield Row(f'white, n = {n}', n, white)


def table_rates() -> Iterator[Row]:
    """Yield the rows of rates: the largest decade of times that fits 20 times into the span."""
    processes = {
        'white': None, 'AR(1)': ar1, '0.5 white + 0.5 AR(1)': lambda tau: half(ar1(tau)),
        '0.5 white + 0.5 narrow band': lambda tau: half(band(tau)), 'narrow band': band,
        'sea state of sd 0.7, white': lambda tau: sea_state(0.7, tau, white)}
    for n in (128, 512, 10_000, 100_000, 4_300_000):
        for rate in (1, 2, 10, 100):
            span_s = n / rate
            tau_s = max((t for t in (0.1, 1, 10, 100, 1000) if span_s >= JUDGED_FROM * t),
                        default=0.1)
            for name, made in processes.items():
                at = f'{rate} Hz, n = {n}'
                if made is None:
                    yield Row(f'{at}: {name}', n, white, rate_hz=rate)
                else:
                    yield Row(f'{at}: {name}, {tau_s:g} s, {span_s / tau_s:.3g}', n,
                              made(tau_s * rate), span_s / tau_s, rate_hz=rate)


def table_e() -> Iterator[Row]:
    """Yield the rows of a component slower than a tenth of the record, in white errors."""
    for n in (600, 3000, 20_000):
        for share in (0.5, 0.3):
            for times in (0.1, 0.3, 1, 3, 6, 10):
                yield Row(f'{share} slow, {times}, n = {n}', n,
                          mixed(share, ar1(n / times), white), times)


def table_stated() -> Iterator[Row]:
    """Yield the rows of a run whose slowest error is stated: rightly, too slow, too fast."""
    made = {
        'AR(1)': (30, ar1), 'narrow band': (60, band),
        '0.5 white + 0.5 AR(1)': (30, lambda tau: half(ar1(tau))),
        '0.8 white + 0.2 AR(1)': (30, lambda tau: mixed(0.8, white, ar1(tau))),
        '0.5 white + 0.5 narrow band': (60, lambda tau: half(band(tau))),
        '0.5 AR(1) + 0.5 AR(1) 30 times slower':
            (60, lambda tau: mixed(0.5, ar1(tau / 30.0), ar1(tau))),
        'damped swing': (60, lambda tau: narrow_band(tau, 2.2 * tau)),
        'Laplace AR(1)': (20, lambda tau: as_laplace(ar1(tau))),
        'Student-5 AR(1)': (20, lambda tau: as_student5(ar1(tau))),
        'sea state of sd 0.7, white': (60, lambda tau: sea_state(0.7, tau, white)),
        'sea state of sd 0.7, AR(1) 30 times faster':
            (60, lambda tau: sea_state(0.7, tau, ar1(tau / 30.0)))}
    for name, (samples, process) in made.items():
        for times in (20, 30, 50, 100):
            yield Row(f'{name}, {times}', samples * times, process(float(samples)), times,
                      stated=1.0)
    for order in (1, 2, 3):
        for name in ('AR(1)', '0.5 white + 0.5 AR(1)'):
            for times in (20, 50):
                yield Row(f'{name}, {times}; drift of order {order} removed', 30 * times,
                          made[name][1](30.0), times, order, order, stated=1.0)
    for name, sampling, kept in (('five gaps of 6 %', five_gaps, 0.7),
                                 ('half of it missing', half_missing, 0.5)):
        for times in (20, 50):
            n = round(30 * times / kept)
            yield Row(f'AR(1), {times}; {name}', n, ar1(30.0), times, sampling=sampling,
                      rate_hz=10.0, stated=1.0)
    for stated in (2.0, 0.5, 0.25):
        for name, times in (('AR(1)', 40), ('0.5 white + 0.5 AR(1)', 40),
                            ('Student-5 AR(1)', 40), ('AR(1)', 100),
                            ('sea state of sd 0.7, white', 40)):
            samples, process = made[name]
            yield Row(f'{name}, {times}; stated {stated:g} of it', samples * times,
                      process(float(samples)), times, stated=stated)
    for times in (4, 10):
        yield Row(f'sea state of sd 0.7, AR(1), {times}; stated 0.2 of it', 60 * times,
                  sea_state(0.7, 60.0, ar1(12.0)), times, stated=0.2)
    for stated in (0.05, 0.02):
        yield Row(f'0.5 slow, 1; stated {stated:g} of it', 3000, half(ar1(3000.0)), 1,
                  stated=stated)


ROWS = {'A': table_a, 'cells': table_cells, 'drift': table_drift, 'gaps': table_gaps,
        'short': table_short, 'rates': table_rates, 'E': table_e, 'stated': table_stated}
"""Tables of rows of one run each."""
