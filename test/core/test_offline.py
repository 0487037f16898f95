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

"""Whole streams: a run paired again keeps its readings and its method of pairing."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.core.pairing import stream_pieces

S = 1_000_000_000
T0 = 1_400_000_000 * S


def late_ts(rng, rs_hz, late_s):
    """Return a TS of 10 Hz whose data are older than its stamps, and an RS."""
    def heading(t_s):
        return 100.0 + 10.0 * np.sin(t_s / 8.0)

    def stream(t_s, heading_deg):
        return Headings.of(T0 + np.round(t_s * 1e9).astype(np.int64), heading_deg)

    t_ts, t_rs = np.arange(20.0, 1220.0, 0.1) + 0.037, np.arange(0.0, 1240.0, 1.0 / rs_hz)
    return (stream(t_ts, heading(t_ts - late_s) + 0.05 * rng.standard_normal(t_ts.size)),
            stream(t_rs, heading(t_rs) + 0.02 * rng.standard_normal(t_rs.size)))


@pytest.mark.parametrize('rs_hz', [1.0, 10.0])
@pytest.mark.parametrize('late_s', [0.45, -0.55])
def test_an_aligned_run_keeps_its_first_and_last_pair(rng, rs_hz, late_s):
    """
    It keeps the TS readings from its first pair to its last, and takes the skew from their stamps.

    With an RS of 1 Hz the pairs are those of the RS stamps within that, else those of all these TS
    readings, for the RS reads before and after.
    """
    ts, rs = late_ts(rng, rs_hz, late_s)
    names = {'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1}
    (plain,) = analyze(ts, rs, Settings.from_mapping(names)).runs
    (run,) = analyze(ts, rs, Settings.from_mapping({**names, 'alignment.skew': 'apply'})).runs
    skew_s = plain.skew.estimate.skew_s
    assert skew_s == pytest.approx(late_s, abs=0.02)
    assert run.skew.scan.skew_s == pytest.approx(late_s, abs=0.02)
    assert run.std_deg == pytest.approx(0.054 if rs_hz > 1.0 else 0.047, abs=0.006)
    shift_ns = round(skew_s * 1e9)
    kept = ts.stamp_ns[(ts.stamp_ns >= plain.start_ns) & (ts.stamp_ns <= plain.end_ns)] - shift_ns
    if rs_hz > 1.0:
        stamps = kept
        assert run.pairing.rs_variance_factor < 1.0 == run.pairing.ts_variance_factor
    else:
        stamps = rs.stamp_ns[(rs.stamp_ns >= kept[0]) & (rs.stamp_ns <= kept[-1])]
        assert run.pairing.ts_variance_factor < 1.0 == run.pairing.rs_variance_factor
    assert (run.start_ns, run.end_ns, run.n) == (stamps[0], stamps[-1], stamps.size)


def without(headings, from_s, to_s):
    """Return headings without those of a stretch."""
    t_s = (headings.stamp_ns - T0) / 1e9
    return headings[(t_s < from_s) | (t_s >= to_s)]


@pytest.mark.parametrize('rs_hz', [1.0, 10.0])
@pytest.mark.parametrize('case', ['whole', 'ts hole', 'rs hole', 'clocks apart', 'disorder'])
def test_a_run_paired_again_in_pieces_is_that_of_all_readings_at_once(
        rng, rs_hz, case, monkeypatch):
    """At once the readings of 12 h at 100 Hz took 1.3 GB, which is why they come in pieces."""
    ts, rs = late_ts(rng, rs_hz, 0.45)
    if case == 'clocks apart':
        ts = Headings.of(ts.stamp_ns + 85 * S, ts.heading_deg)
    elif case == 'disorder':
        ts = ts[np.r_[0:500, 600:700, 500:600, 700:len(ts)]]
    elif case != 'whole':
        ts, rs = (without(each, 400.0, 480.0) if name == case[:2] else each
                  for name, each in (('ts', ts), ('rs', rs)))
    settings = Settings.from_mapping({
        'norms.sigma_max_deg': 0.3, 'norms.sigma_ref_max_deg': 0.1, 'alignment.skew': 'apply'})
    whole = analyze(ts, rs, settings).to_dict()
    assert sum(any('aligned: ' in word for word in run['warnings']) for run in whole['runs'])
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 300)
    assert analyze(ts, rs, settings).to_dict() == whole


GYROS = ('gyr1', 'lgyr')
NAMES = {'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1}


def moved(headings, by_s):
    """Return headings with stamps of a clock that is ahead."""
    return Headings.as_sent(headings.stamp_ns + round(by_s * 1e9), headings.heading_deg)


@pytest.mark.parametrize('name', GYROS)
@pytest.mark.parametrize('by_s', [79.5, 89.1, -300.0])
def test_one_gyro_in_two_loggers_is_void_and_its_clocks_are_named(logs, name, by_s):
    """
    At 79.5 s the gyro of the Gould had "met" as its (b), at 89.1 s a sound gyro was rejected.

    The loose norm once made this COMPLIANT, the tight one NON-COMPLIANT.
    """
    for sigma_max_deg in (0.2, 10.0):
        verdict = analyze(moved(logs[name], by_s), logs[name], Settings.from_mapping(
            {**NAMES, 'norms.sigma_max_deg': sigma_max_deg}))
        assert verdict.runs[0].reason == 'void.clocks'
        assert (f'the clock of the {"RS" if by_s > 0.0 else "TS"} lags by about {abs(by_s):.1f} s '
                f'(alignment.skew_s = {by_s:.1f} mends it)') in verdict.headline
        assert {a.id: a.state for a in verdict.runs[0].assumptions}['b'] == 'violated'


@pytest.mark.parametrize('by_s', [79.5, -300.0])
def test_clocks_of_a_gyro_and_a_satellite_compass_are_named(logs, by_s):
    """The gyro is 1.2 s late by itself."""
    verdict = analyze(moved(logs['gyr1'], by_s), logs['s330'], Settings.from_mapping(NAMES))
    assert verdict.runs[0].reason == 'void.clocks'
    assert verdict.runs[0].skew.estimate.beyond_s == pytest.approx(by_s + 1.18, abs=0.1)


@pytest.mark.parametrize('name', GYROS)
@pytest.mark.parametrize('by_s', [89.1, -300.0, 590.0])
def test_clocks_that_lie_apart_are_mended_by_apply_and_by_a_setting(logs, name, by_s):
    """At 590 s only the readings show it: the pairs of 410 s were made of different motion."""
    gyro = logs[name]
    (run,) = analyze(moved(gyro, by_s), gyro, Settings.from_mapping(
        {**NAMES, 'alignment.skew': 'apply'})).runs
    (said,) = (w for w in run.warnings if w.startswith('aligned: '))
    assert float(said.split()[1]) == pytest.approx(by_s, abs=2e-3)
    assert run.std_deg < 1e-3
    (mended,) = analyze(moved(gyro, by_s), gyro, Settings.from_mapping(
        {**NAMES, 'alignment.skew_s': by_s})).runs
    assert mended.std_deg == 0.0
    assert mended.n == len(gyro)


def test_beyond_what_the_pairs_show_nothing_is_met(logs):
    (run,) = analyze(moved(logs['lgyr'], 590.0), logs['lgyr'],
                     Settings.from_mapping(NAMES)).runs
    (b,) = (a for a in run.assumptions if a.id == 'b')
    assert b.state == 'not_testable'
    assert 0.0 < run.skew.estimate.searched_s < 300.0
    assert f'nor was one found up to {run.skew.estimate.searched_s:g} s' in b.evidence


def test_a_skew_that_no_setting_may_state_is_not_applied(rng):
    """The known latency and what is found exceed an hour together."""
    t_s = np.arange(0.0, 6000.0, 0.5)

    def heading(at_s):
        return 100.0 + sum(np.sin(2.0 * np.pi * at_s / period + period) for period in (
            5.3, 6.1, 7.7, 8.4, 9.9, 11.6))

    def stream(by_s):
        return Headings.of(T0 + np.round((t_s + by_s) * 1e9).astype(np.int64), heading(t_s)
                           + 0.05 * rng.standard_normal(t_s.size))
    (run,) = analyze(stream(3700.0), stream(0.0), Settings.from_mapping(
        {**NAMES, 'alignment.skew': 'apply', 'alignment.skew_s': 3500.0})).runs
    assert run.skew.estimate.beyond_s == pytest.approx(200.0, abs=0.1)
    assert any(w.startswith('not_aligned: ') for w in run.warnings)
