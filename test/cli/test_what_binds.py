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

"""What the data show binds on the command line: ordinary records, each with its exit code."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.signal import lfilter

from heading_intercompare.cli import main

NORMS = ['--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1']
COMPLIANT, NON_COMPLIANT, OPEN, DOUBTFUL = 0, 1, 3, 4
SPAN_S = 1500


def yaw(t, rms_deg, period_s, seed):
    """Return forty sines about a period, degrees."""
    rng = np.random.default_rng(seed)
    frequency = (1.0 + 0.15 * rng.standard_normal(40)) / period_s
    phase = rng.uniform(0.0, 2.0 * np.pi, 40)
    return rms_deg / np.sqrt(20.0) * np.sin(
        2.0 * np.pi * np.multiply.outer(t, frequency) + phase).sum(axis=1)


def ship(t, rms_deg=1.0, period_s=8.0, seed=11):
    """Return the heading of a ship on a slow swing, degrees."""
    return 80.0 + 25.0 * np.sin(2.0 * np.pi * t / 700.0) + yaw(t, rms_deg, period_s, seed)


def write_log(path, t, heading_deg, decimals=2):
    """Write a log of HDT sentences with ISO stamps."""
    lines = []
    for at_s, heading in zip(t, np.asarray(heading_deg) % 360.0):
        body = f'HEHDT,{heading:.{decimals}f},T'
        checksum = 0
        for letter in body.encode():
            checksum ^= letter
        stamp = np.datetime64(1_800_000_000_000 + round(1000 * at_s), 'ms')
        lines.append(f'{stamp}Z ${body}*{checksum:02X}\n')
    path.write_text(''.join(lines))
    return str(path)


@pytest.fixture
def judge(tmp_path, capsys):
    """Return a function that judges two streams and returns exit code and headline."""
    def analyze(ts, rs, *arguments, decimals=(2, 2)):
        logs = [write_log(tmp_path / f'{name}.log', *stream, number)
                for name, stream, number in zip(('gyro', 'ref'), (ts, rs), decimals)]
        code = main(['analyze', *logs, *NORMS, *arguments, '--check', '--quiet'])
        return code, capsys.readouterr().out.partition('\n')[0]
    return analyze


def times(hz, phase_s=0.0):
    """Return the times of readings, seconds."""
    return np.arange(0, SPAN_S * hz) / hz + phase_s


@pytest.mark.slow
@pytest.mark.parametrize('ts_hz, rs_hz', [(1.0, 1.0), (1.25, 1.0), (2.0, 1.0), (1.0, 5.0)])
def test_a_sound_ts_in_a_yaw_of_six_seconds_is_not_rejected(judge, ts_hz, rs_hz):
    """2 deg rms; the straight line rejected it firmly."""
    rng = np.random.default_rng(31)
    t, r = times(ts_hz), times(rs_hz, 0.47)
    code, line = judge((t, ship(t, 2.0, 6.0) + 0.1 * rng.standard_normal(t.size)),
                       (r, ship(r, 2.0, 6.0) + 0.07 * rng.standard_normal(r.size)))
    assert code == COMPLIANT, line


@pytest.mark.slow
def test_a_ts_that_averages_over_two_seconds_is_not_certified(judge):
    """Its error is 0.35 deg; the straight line averages the RS as much."""
    rng = np.random.default_rng(32)
    t, r = times(1.0), times(1.0, 0.5)
    fine = np.linspace(-1.0, 1.0, 41)
    ts = np.mean([ship(t + shift, 2.0, 6.0) for shift in fine], axis=0)
    code, line = judge((t, ts + 0.06 * rng.standard_normal(t.size)),
                       (r, ship(r, 2.0, 6.0) + 0.05 * rng.standard_normal(r.size)))
    assert code in (NON_COMPLIANT, OPEN), line


@pytest.mark.slow
@pytest.mark.parametrize('missing', [0.05, 0.2])
@pytest.mark.parametrize('sensor', ['ts', 'rs'])
def test_missing_readings_are_not_charged_to_the_ts(judge, missing, sensor):
    rng = np.random.default_rng(33)
    t = times(1.0)
    streams = {}
    for name, sigma in (('ts', 0.1), ('rs', 0.06)):
        there = rng.random(t.size) > (missing if name == sensor else 0.0)
        streams[name] = (t[there], ship(t[there], 3.0, 7.0)
                         + sigma * rng.standard_normal(there.sum()))
    code, line = judge(streams['ts'], streams['rs'])
    assert code == COMPLIANT or (code == DOUBTFUL and 'lost' in line), line


@pytest.mark.slow
def test_two_logs_of_a_reading_each_five_seconds_are_judged(judge):
    rng = np.random.default_rng(34)
    t = np.arange(0.0, 7200.0, 5.0)
    code, line = judge((t, ship(t, 0.1, 40.0) + 0.1 * rng.standard_normal(t.size)),
                       (t + 1.7, ship(t + 1.7, 0.1, 40.0) + 0.05 * rng.standard_normal(t.size)))
    assert code in (COMPLIANT, OPEN) and 'No run' not in line, line


@pytest.mark.slow
@pytest.mark.parametrize('noise', ['white', 'steps'])
def test_an_rs_out_of_its_norm_rejects_no_ts(judge, noise):
    rng = np.random.default_rng(35)
    t = times(5.0)
    rs = ship(t) + (0.3 if noise == 'white' else 0.05) * rng.standard_normal(t.size)
    code, line = judge((t, ship(t) + 0.1 * rng.standard_normal(t.size)), (t, rs),
                       decimals=(2, 2 if noise == 'white' else 0))
    assert code == OPEN and 'VOID: the RS breaks its norm of 0.1 deg' in line


@pytest.mark.slow
def test_a_parting_is_named_with_its_times(judge):
    rng = np.random.default_rng(36)
    t = times(5.0)
    ts = ship(t) + 0.1 * rng.standard_normal(t.size)
    ts[2000:4000] += 38.0
    code, line = judge((t, ts), (t, ship(t) + 0.05 * rng.standard_normal(t.size)))
    assert code == DOUBTFUL
    assert re.search('the sensors part by 3[78].. deg from 2027-01-15 08:06:40 to 08:13:.. UTC',
                     line)


@pytest.mark.slow
def test_an_rs_that_repeats_the_ts_is_no_reference(judge):
    """Slow errors of 0.4 deg cancel; a fifth of a norm of its own noise shows."""
    rng = np.random.default_rng(37)
    t = times(5.0)
    slow = lfilter([np.sqrt(1.0 - 0.998 ** 2)], [1.0, -0.998], rng.standard_normal(t.size))
    ts = ship(t) + 0.4 * slow + 0.04 * rng.standard_normal(t.size)
    code, line = judge((t, ts), (t, ts + 0.06 * rng.standard_normal(t.size)))
    assert code in (OPEN, DOUBTFUL), line
    assert 'look like one sensor' in line or 'share a part of their noise' in line


@pytest.mark.slow
def test_a_mean_of_two_norms_is_no_clean_certificate_in_variant_a(judge):
    rng = np.random.default_rng(38)
    t = times(5.0)
    code, line = judge((t, ship(t) + 0.4 + 0.1 * rng.standard_normal(t.size)),
                       (t, ship(t) + 0.05 * rng.standard_normal(t.size)), '--set', 'variant=A')
    assert code == DOUBTFUL and 'variant A takes it for zero; by variant B compliant' in line


@pytest.mark.slow
def test_a_table_of_runs_hides_no_bad_stretch(judge, tmp_path):
    """500 s of 1500 s are 4 deg off; the table has one row after them."""
    rng = np.random.default_rng(39)
    t = times(5.0)
    ts = ship(t) + 0.1 * rng.standard_normal(t.size)
    ts[:2500] += 4.0
    table = tmp_path / 'runs.csv'
    table.write_text('start,stop\n2027-01-15T08:08:30Z,2027-01-15T08:30:00Z\n')
    code, line = judge((t, ts), (t, ship(t) + 0.05 * rng.standard_normal(t.size)),
                       '--runs', str(table))
    assert code == DOUBTFUL
    assert '34 % of the pairs are left out (not in the table of runs), as recorded non-compliant' \
        in line


@pytest.mark.slow
@pytest.mark.parametrize('hz, rms_deg, decimals', [(1.0, 1.0, 2), (5.0, 0.5, 1), (10.0, 1.5, 2)])
def test_sound_sensors_are_certified_without_a_word(judge, hz, rms_deg, decimals):
    rng = np.random.default_rng(40)
    t, r = times(hz), times(hz, 0.013)
    code, line = judge((t, ship(t, rms_deg) + 0.08 * rng.standard_normal(t.size)),
                       (r, ship(r, rms_deg) + 0.05 * rng.standard_normal(r.size)),
                       decimals=(decimals, decimals))
    assert code == COMPLIANT, line
