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

"""Import and analysis of real ship logs, compared with figures of two independent programs."""

from __future__ import annotations

from datetime import datetime
import json
import re

from checksums import checksum_of
import numpy as np
import pytest

from heading_intercompare.cli import main

RULES = ['--set', 'norms.m_low=0.9', '--set', 'norms.k_rule=three']
NORMS = ['--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1', *RULES]
#: The golden figures are those of a straight line.
LINE = ['--set', 'pairing.kernel=line']
INTERPOLATE = ['--set', 'pairing.method=interpolate', *LINE]
NEAREST = ['--set', 'pairing.method=nearest', '--set', 'pairing.tolerance_s=0.1']
SETS = {
    'gyr1-s330': ('NBP1406', 'nbp1406/NBP1406_gyr1-2014-08-01',
                  'nbp1406/NBP1406_s330-2014-08-01'),
    'gyr1-seap': ('NBP1406', 'nbp1406/NBP1406_gyr1-2014-08-01',
                  'nbp1406/NBP1406_seap-2014-08-01'),
    'seap-s330': ('NBP1406', 'nbp1406/NBP1406_seap-2014-08-01',
                  'nbp1406/NBP1406_s330-2014-08-01'),
    'adcp-s330': ('NBP1406', 'nbp1406/NBP1406_adcp-2014-08-01',
                  'nbp1406/NBP1406_s330-2014-08-01'),
    'lgyr-lsep': ('LMG1903', 'lmg1903/LMG1903_lgyr.d085', 'lmg1903/LMG1903_lsep.d085'),
}


def verdict_of(capsys, *arguments):
    assert main([*map(str, arguments), '--json', '-', '--quiet']) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope='module')
def golden(shared_data):
    return json.loads((shared_data / 'golden_nbp1406_lmg1903.json').read_text())['sets']


@pytest.fixture(scope='module')
def bags(shared_data, tmp_path_factory):
    folder = tmp_path_factory.mktemp('bags')
    for name, (_, ts, rs) in SETS.items():
        assert main(['import-nmea', '--ts', str(shared_data / ts), '--rs',
                     str(shared_data / rs), '-o', str(folder / name), '--quiet']) == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize('name', SETS)
@pytest.mark.parametrize('method, key', [(INTERPOLATE, 'interp'),
                                         (NEAREST, 'nearest_unique_100ms')])
def test_the_figures_are_the_golden_ones(name, method, key, bags, golden, capsys):
    if name not in golden[SETS[name][0]]['pairs']:
        pytest.skip(f'the golden file has no figures of {name}')
    figures = golden[SETS[name][0]]['pairs'][name][key]
    verdict = verdict_of(capsys, 'analyze', bags / name, *NORMS, *method,
                         '--set', 'runs.gap_s=100000')
    if figures['n'] == 0:
        assert verdict['runs'] == [] and verdict['outcome'] == 'indeterminate'
        return
    (run,) = verdict['runs']
    assert run['n'] == figures['n']
    for ours, theirs in (('mean_deg', 'mean'), ('std_deg', 'sd'), ('min_deg', 'min'),
                         ('max_deg', 'max')):
        assert run[ours] == pytest.approx(figures[theirs], rel=1e-9, abs=1e-12), ours
    assert run['mean_square_deg2'] == pytest.approx(figures['rms'] ** 2, rel=1e-9)
    if key != 'interp':
        assert run['pairing']['mean_lag_s'] == pytest.approx(-figures['mean_dt'], rel=1e-9)
        assert run['pairing']['max_lag_s'] == pytest.approx(figures['max_abs_dt'], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize('name', SETS)
@pytest.mark.parametrize('variant, suffix', [('A', 'raw'), ('B', 'c')])
def test_the_criteria_are_the_golden_ones(name, variant, suffix, bags, golden, capsys, tmp_path):
    """GK (5) and the counts, on a csv without variance factors: there M = 0.9 is not tightened."""
    pairs = golden[SETS[name][0]]['pairs']
    if name not in pairs:
        pytest.skip(f'the golden file has no figures of {name}')
    csv = tmp_path / 'pairs.csv'
    gap = ['--set', 'runs.gap_s=100000']
    verdict_of(capsys, 'analyze', bags / name, *NORMS, *INTERPOLATE, *gap, '--csv', csv)
    rows = [line.split(',') for line in csv.read_text().splitlines()]
    csv.write_text('\n'.join(','.join(row[:3]) for row in rows) + '\n')
    for case in pairs[name]['criteria']:
        (run,) = verdict_of(
            capsys, 'analyze', csv, *RULES, *gap, '--set', f'variant={variant}', '--set',
            f'norms.sigma_max_deg={case["smax"]}', '--set',
            f'norms.sigma_ref_max_deg={case["sref"]}')['runs']
        outcome = ('non_compliant' if case['bad5'] else
                   'compliant' if case['good5'] else 'indeterminate')
        assert run['variance_criterion']['outcome'] == outcome
        counts = run['count_criterion']
        assert counts['n_plus'] == case[f'nplus_{suffix}']
        assert counts['n_plus_plus'] == case[f'nplus2_{suffix}']
        assert counts['allowed'] == pytest.approx(case['n_allowed'])


@pytest.mark.parametrize('name, readings, n, variance_deg2, factor', [
    ('gyr1-s330', (0, 2500, 2500, 625, 0), 625, 0.0929431, 0.658289),
    ('lgyr-lsep', (11, 3952, 6037, 999, 1001), 999, 0.0023740, 0.803467)])
def test_a_gyro_is_put_onto_the_stamps_of_a_slow_reference(name, readings, n, variance_deg2,
                                                           factor, bags, capsys):
    """5 Hz against 1 Hz, each RS reading about halfway between two; 10 Hz against 1 Hz."""
    (run,) = verdict_of(capsys, 'analyze', bags / name, *NORMS)['runs']
    pairing = run['pairing']
    assert (run['n'], pairing['paired']) == (n, n)
    assert pairing['ts_variance_factor'] == pytest.approx(factor, abs=1e-6)
    assert pairing['ts_received'] == (pairing['ts_paired'] + pairing['ts_used']
                                      + pairing['ts_unpaired'])
    assert tuple(pairing[key] for key in (
        'ts_paired', 'ts_used', 'ts_unpaired', 'rs_used', 'rs_unused')) == readings
    assert run['variance_deg2'] == pytest.approx(variance_deg2, abs=1e-7)
    assert run['variance_criterion']['tightened_limit_deg2'] == pytest.approx(
        factor * 0.2 ** 2 + 0.9 ** 2 * 0.1 ** 2, abs=1e-7)


def test_of_four_sensors_the_gyro_is_suspected_and_every_age_agrees(shared_data, capsys):
    """The ship carries a gyro, two GNSS-aided systems, and UHDAS; the gyro is late."""
    logs = [f'{name}={shared_data / "nbp1406"}/NBP1406_{file}-2014-08-01' for name, file in (
        ('gyro', 'gyr1'), ('s330', 's330'), ('seap', 'seap'), ('uhdas', 'adcp'))]
    rows = ('gyro sigma_max_deg=0.2; seap sigma_max_deg=0.1 installation_offset_deg=0.82; '
            'uhdas sigma_max_deg=0.3 installation_offset_deg=0.82; s330 sigma_max_deg=0.1')
    for reference in (' rs', ''):
        verdict = verdict_of(capsys, 'analyze', *logs, '--set', f'sensors={rows}{reference}',
                             '--set', 'norms.m_low=0.5')
        assert verdict['vote']['suspected'] == ['gyro'] and verdict['vote']['wrong'] == []
        assert [one['outcome'] for one in verdict['sensors']][0] != 'compliant'
        age = {(pair['first'], pair['second']): pair['skew_s'] for pair in verdict['pairs']}
        # What two ages say of a third one.
        assert age['gyro', 's330'] == pytest.approx(1.2, abs=0.05)
        assert age['gyro', 's330'] - age['seap', 's330'] == pytest.approx(
            age['gyro', 'seap'], abs=0.05)
        assert age['gyro', 's330'] - age['uhdas', 's330'] == pytest.approx(
            age['gyro', 'uhdas'], abs=0.05)
    assert verdict['verdicts'] == {}


AUTO = {
    # The RS reports once a second and the gyro more often, so the gyro is interpolated.
    'gyr1-s330': (True, 3120, 625), 'gyr1-seap': (True, 3564, 714), 'lgyr-lsep': (True, 9991, 999),
    # Both report once a second, or the TS less often: nothing changes.
    'seap-s330': (False, 624, 624), 'adcp-s330': (False, 521, 521)}


def read_plainly(path):
    """Return stamps and headings of a log, read line by line without the package."""
    stamps, headings, has_hdt = [], [], b'HDT' in path.read_bytes()
    for line in path.read_bytes().decode('ascii', 'replace').splitlines():
        # 19+085:10:05:54.447 is day 85 of 2019.
        found = re.match(r'(\d{4}-\d\d-\d\dT[\d:]+\.\d+|\d\d\+\d{3}:[\d:]+\.\d+)Z?\s+'
                         r'\$([^*]*)(?:\*(..))?\s*$', line)
        if not found:
            continue
        stamp, sentence, check = found.groups()
        fields = sentence.split(',')
        at = 1 if fields[0].endswith('HDT') else None if has_hdt else {
            'PSXN23': 4, 'PUHAWUVH': 4}.get(''.join(fields[:2]))
        if at is None or not fields[at] or check and int(check, 16) != checksum_of(sentence):
            continue
        whole, _, part = stamp.partition('.')
        form = '%Y-%m-%dT%H:%M:%S%z' if '-' in whole else '%y+%j:%H:%M:%S%z'
        since = datetime.strptime(f'{whole}+0000', form)
        stamps.append(round(since.timestamp()) * 10 ** 9 + int(f'{part:0<9}'))
        headings.append(float(fields[at]))
    keep = np.r_[True, np.diff(np.maximum.accumulate(stamps)) > 0]
    return np.array(stamps)[keep], np.array(headings)[keep]


def differ(at, of):
    """Return the differences of readings from a line through others, no gap above 3 s."""
    t0 = at[0][0]
    t, s = (at[0] - t0) / 1e9, (of[0] - t0) / 1e9
    steps = (np.diff(of[1]) + 180.0) % 360.0 - 180.0
    line = np.interp(t, s, np.concatenate(([of[1][0]], of[1][0] + np.cumsum(steps))))
    right = np.clip(np.searchsorted(of[0], at[0]), 1, len(s) - 1)
    inside = (at[0] >= of[0][0]) & (at[0] <= of[0][-1]) & (
        (of[0][right] - of[0][right - 1] <= 3 * 10 ** 9) | np.isin(at[0], of[0]))
    return ((at[1] - line + 180.0) % 360.0 - 180.0)[inside]


@pytest.mark.parametrize('name', AUTO)
def test_the_figures_of_auto_are_those_of_a_plain_program(name, bags, shared_data, capsys):
    exchanged, n_interpolate, n = AUTO[name]
    ts, rs = (read_plainly(shared_data / path) for path in SETS[name][1:])
    x = -differ(rs, ts) if exchanged else differ(ts, rs)
    assert (len(differ(ts, rs)), len(x)) == (n_interpolate, n)
    (run,) = verdict_of(capsys, 'analyze', bags / name, *NORMS, *LINE,
                        '--set', 'runs.gap_s=100000')['runs']
    assert run['n'] == n
    assert (run['mean_deg'], run['std_deg'], run['min_deg'], run['max_deg']) == pytest.approx(
        (x.mean(), x.std(ddof=1), x.min(), x.max()), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize('ts, rs', [('seap', 's330'), ('s330', 'seap')])
def test_times_of_validity_give_the_golden_figures(ts, rs, shared_data, golden, capsys, tmp_path):
    logs = [str(shared_data / f'nbp1406/NBP1406_{s}-2014-08-01') for s in (ts, rs)]
    bag = str(tmp_path / 'bag')
    assert main(['import-nmea', '--ts', logs[0], '--rs', logs[1], '--time', 'validity', '-o',
                 bag, '--quiet']) == 0
    capsys.readouterr()
    figures = golden['NBP1406_zda']['pairs'][f'{ts}-{rs}']['interp']
    (run,) = verdict_of(capsys, 'analyze', bag, *NORMS, *INTERPOLATE)['runs']
    assert run['n'] == figures['n']
    assert run['mean_deg'] == pytest.approx(figures['mean'], rel=1e-9)
    assert run['std_deg'] == pytest.approx(figures['sd'], rel=1e-9)


def test_a_csv_of_pairs_gives_the_verdict_of_its_bag(bags, capsys, tmp_path):
    csv = tmp_path / 'pairs.csv'
    of_bag = verdict_of(capsys, 'analyze', bags / 'gyr1-s330', *NORMS, '--csv', csv)
    of_csv = verdict_of(capsys, 'analyze', csv, *NORMS)
    for run in of_bag['runs'] + of_csv['runs']:
        for key in ('source', 'pairing'):
            del run[key]
        # The csv holds the pairs, not what was lost on the way to them, nor how they were made.
        run['validity'] = [f for f in run['validity']
                           if f['condition'] not in ('losses', 'interpolation')]
    assert of_csv['runs'] == of_bag['runs']


def test_a_log_without_zda_has_no_time_of_validity(shared_data, tmp_path, capsys):
    assert main(['import-nmea', '--ts', str(shared_data / SETS['gyr1-s330'][1]), '--rs',
                 str(shared_data / SETS['gyr1-s330'][2]), '--time', 'validity', '-o',
                 str(tmp_path / 'bag')]) == 2
    text = capsys.readouterr().err
    assert 'no heading in it, read as the TS (not taken: 5000 no_validity_time)' in text
    assert 'a stamp of the form iso' in text and 'set --time to receipt' in text
    assert not (tmp_path / 'bag').exists()


def test_a_replayed_log_goes_through_and_says_what_was_rejected(shared_data, tmp_path, capsys):
    folder = shared_data / 'nbp1700_replay'
    assert main(['import-nmea', '--ts', str(folder / 'NBP1700_gyr1-2017-11-04'), '--rs',
                 str(folder / 'NBP1700_s330-2017-11-04'), '-o', str(tmp_path / 'bag')]) == 0
    assert '2490 bad_checksum' in capsys.readouterr().out
    verdict = verdict_of(capsys, 'analyze', tmp_path / 'bag', *NORMS)
    rejected = sum(run['pairing']['rejected']['ts'].get('stamp_not_increasing', 0)
                   for run in verdict['runs'])
    assert rejected > 0
    for run in verdict['runs']:
        pairing = run['pairing']
        for s, rows in (('ts', ('ts_paired', 'ts_used', 'ts_unpaired', 'ts_unbridged')),
                        ('rs', ('rs_used', 'rs_unused', 'rs_unbridged'))):
            assert pairing[f'{s}_received'] == (sum(pairing[row] for row in rows)
                                                + sum(pairing['rejected'][s].values()))
