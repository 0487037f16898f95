# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whole streams: a run paired again keeps its readings and its method of pairing."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings

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
