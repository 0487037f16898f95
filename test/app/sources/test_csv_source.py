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

"""The csv of pairs that the package writes gives, read back, the verdict of the recording."""

from __future__ import annotations

from functools import partial
import json
import re

import command_line
from command_line import refusal
from journals import some_pairs, write_journal
import numpy as np
import pytest

from heading_intercompare import Headings
from heading_intercompare.bags.csv.pairs_account import account_path
from heading_intercompare.bags.mcap.chunk_writer import Rows
from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import Notes, RECORD
from heading_intercompare.cli import main
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.messages.status_messages import encode_mark, MARKER_TOPIC, STATUS_TYPE

S = 1_000_000_000
T0 = 1_400_000_000 * S
NORMS = ['--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1']
analyze_json = partial(command_line.analyze_json, norms=NORMS)
N = 9000


def ship(stamp_ns):
    """Return the true heading."""
    t = (stamp_ns - T0) / S
    return 90.0 + 30.0 * np.sin(t / 200.0) + np.sin(t / 4.0)


def write_bag(path, *, rs_step=1, rs_late_ns=0, silent=(), lost=0.0, faults=(), marks=(),
              notes=(), sigma_deg=0.1):
    """Write 15 min of both sensors at 10 Hz; the RS every `rs_step`, and what goes wrong."""
    rng = np.random.default_rng(7)
    with BagWriter(path) as bag:
        bag.metadata(RECORD, {'version': '0'})
        rows = []
        for topic, sigma, step, late in (('ts/heading', sigma_deg, 1, 0),
                                         ('rs/heading', 0.03, rs_step, rs_late_ns)):
            at = np.arange(0, N, step)
            stamps = T0 + at * (S // 10) + late
            heading = ship(stamps) + sigma * rng.standard_normal(len(at))
            kept = np.ones(len(at), bool)
            for begin, end in silent:
                kept &= (at < begin) | (at >= end)
            if topic == 'rs/heading':
                kept &= rng.random(len(at)) >= lost
            for fault in faults:
                if fault == 'late':
                    stamps[500] = stamps[490]
                elif fault == 'future':
                    stamps[700:703] += 10**6 * S
                elif fault == 'set back' and topic == 'ts/heading':
                    stamps[N // 2:] -= 20 * S
                elif fault == 'nan' and step == 1:
                    heading[900:950] = np.nan
                elif fault == 'RS mostly nan' and topic == 'rs/heading':
                    heading[rng.random(len(at)) < 0.6] = np.nan
                elif fault == 'no stamp':
                    stamps[300] = 0
            readings = Headings(stamps, heading % 360.0)[kept]
            log = T0 + at[kept] * (S // 10) + 1
            bag.add_topic(topic, IMU)
            rows.append(Rows(topic, encode_imu(readings, 'x'), log,
                             sequence=np.flatnonzero(kept) + 1))
        bag.write_rows(rows)
        if marks:
            bag.add_topic(MARKER_TOPIC, STATUS_TYPE)
            for kind, second in marks:
                bag.write(MARKER_TOPIC, encode_mark(kind, T0 + second * S), T0 + second * S)
        noted = Notes(bag.metadata)
        for note in notes:
            noted.add(note, T0)
    return path


def same(verdict):
    """Return a verdict without the names of its inputs."""
    inputs = [{name: value for name, value in one.items()
               if name not in ('path', 'sha256', 'made_from')} for one in verdict['inputs'][:1]]
    text = json.dumps({**verdict, 'inputs': inputs})
    for one in verdict['inputs']:
        text = text.replace(json.dumps(one['path']), '"INPUT"')
    return json.loads(text)


KINDS = {
    'interpolated': {'rs_step': 10, 'rs_late_ns': 37_000_000},
    'nearest with lags': {'rs_late_ns': 3_000_000, 'set': ['pairing.method=nearest']},
    'the TS interpolated': {'rs_late_ns': 3_000_000, 'set': ['pairing.method=interpolate_ts']},
    'gaps': {'silent': [(3000, 4000), (6000, 6700)]},
    'half lost': {'rs_step': 10, 'rs_late_ns': 37_000_000, 'lost': 0.6,
                  'set': ['risk.min_duration_s=300']},
    'rejected': {'faults': ['late', 'future', 'nan', 'no stamp']},
    'a clock set back': {'faults': ['set back']},
    'marks': {'marks': [('start', 60), ('stop', 400), ('start', 450)]},
    'notes': {'notes': ['course <change>', '2026-03-01T09:00:00Z left port; "again"']},
    'looks': {'set': ['sequential.plan_s=900', 'risk.min_duration_s=0']},
    'runs by the clock': {'set': ['runs.every_h=0.1', 'runs.keep=1', 'risk.min_duration_s=0']},
    'just above the norm': {'sigma_deg': 0.21},
    'a run too short': {'silent': [(1000, 8800)], 'set': ['runs.min_duration_s=60']},
    'no run': {'set': ['runs.min_duration_s=86400']},
}


@pytest.mark.parametrize('kind', KINDS)
def test_a_csv_gives_the_verdict_of_its_bag_to_the_bit(tmp_path, capsys, kind):
    given = dict(KINDS[kind])
    extra = [word for one in given.pop('set', ()) for word in ('--set', one)]
    bag = write_bag(tmp_path / 'bag', **given)
    pairs, again = tmp_path / 'pairs.csv', tmp_path / 'again.csv'
    of_bag, _ = analyze_json(capsys, bag, *extra, '--csv', pairs)
    of_csv, _ = analyze_json(capsys, pairs, *extra, '--csv', again)
    of_copy, _ = analyze_json(capsys, again, *extra)
    assert same(of_csv) == same(of_bag) == same(of_copy)
    entry, = of_csv['inputs']
    assert entry['made_from'] == {str(bag): of_bag['inputs'][0]['sha256']}
    assert again.read_bytes() == pairs.read_bytes()


def test_readings_that_are_not_in_the_pairs_still_make_the_verdict_void(tmp_path, capsys):
    """All pairs are there, because the RS is interpolated; before, the csv was compliant."""
    bag = write_bag(tmp_path / 'bag', faults=['RS mostly nan'], rs_late_ns=37_000_000)
    found = []
    for path, more in ((bag, ['--csv', tmp_path / 'p.csv']), (tmp_path / 'p.csv', [])):
        verdict, _ = analyze_json(capsys, path, '--set', 'pairing.method=interpolate', *more)
        run, = verdict['runs']
        found.append((verdict['outcome'], run['reason'], run['pairing']['rs_received']))
    assert found[0] == found[1] and found[0][:2] == ('indeterminate', 'void.losses')


def test_a_table_of_runs_goes_along(tmp_path, capsys):
    bag, table, other = (tmp_path / name for name in ('bag', 'runs.csv', 'other.csv'))
    write_bag(bag, lost=0.2)
    table.write_text(f'start,stop\n{T0 + 50 * S},{T0 + 300 * S}\n{T0 + 310 * S},{T0 + 880 * S}\n')
    other.write_text(f'start,stop\n{T0 + 60 * S},{T0 + 800 * S}\n')
    of_bag, _ = analyze_json(capsys, bag, '--runs', table, '--csv', tmp_path / 'p.csv')
    for more in ([], ['--runs', table]):
        of_csv, _ = analyze_json(capsys, tmp_path / 'p.csv', *more)
        assert same(of_csv) == same(of_bag) and len(of_csv['runs']) == 2
    of_other, notes = analyze_json(capsys, tmp_path / 'p.csv', '--runs', other)
    assert len(of_other['runs']) == 1
    assert of_other['inputs'][0]['ledger_problems'] == [
        'its runs are not those of its account: what was rejected, lost or without partner is '
        'unknown']
    assert 'its runs are not those of its account' in notes[0]


def test_two_logs_and_a_journal_go_along(tmp_path, capsys):
    rng = np.random.default_rng(3)
    for name, sigma in (('ts', 0.1), ('rs', 0.02)):
        rows = [f'{T0 + i * S},{value:.3f}' for i, value in enumerate(
            90.0 + sigma * rng.standard_normal(900))]
        (tmp_path / f'{name}.csv').write_text('\n'.join(['t_ns,heading_deg', *rows, '5,x', '']))
    of_logs, _ = analyze_json(capsys, tmp_path / 'ts.csv', tmp_path / 'rs.csv', '--csv',
                            tmp_path / 'p.csv')
    of_csv, _ = analyze_json(capsys, tmp_path / 'p.csv')
    assert of_csv['runs'][0]['pairing'] == of_logs['runs'][0]['pairing']
    assert (of_csv['outcome'], of_csv['inputs'][0]['made_from']) == (
        of_logs['outcome'], {one['path']: one['sha256'] for one in of_logs['inputs']})
    write_journal(tmp_path / 'a.journal', some_pairs(2000), [(500, 'start')], booked=True)
    of_journal, _ = analyze_json(capsys, tmp_path / 'a.journal', '--csv', tmp_path / 'j.csv')
    # A journal brings its settings, a csv does not.
    of_csv, _ = analyze_json(capsys, tmp_path / 'j.csv', '--set', 'risk.min_duration_s=0')
    assert same(of_csv)['runs'] == same(of_journal)['runs']


@pytest.fixture
def pairs(tmp_path, capsys):
    """Return a csv of pairs with its account, and the verdict of its bag."""
    path = tmp_path / 'pairs.csv'
    bag = write_bag(tmp_path / 'bag', rs_step=10, rs_late_ns=37_000_000, lost=0.15)
    return path, analyze_json(capsys, bag, '--csv', path)[0]


def test_a_csv_that_a_spreadsheet_saved_keeps_its_account(pairs, capsys):
    path, of_bag = pairs
    text = path.read_text().replace(',', ';').replace('.', ',')
    path.write_bytes(b'\xef\xbb\xbf' + text.replace('\n', '\r\n').encode())
    of_csv, notes = analyze_json(capsys, path)
    assert same(of_csv) == same(of_bag) and notes == []


def test_a_csv_in_another_order_of_columns_keeps_its_account(pairs, capsys):
    path, of_bag = pairs
    rows = [line.split(',')[::-1] for line in path.read_text().splitlines()]
    path.write_text(''.join(','.join([*row, 'x' if at else 'remark']) + '\n'
                            for at, row in enumerate(rows)))
    of_csv, notes = analyze_json(capsys, path)
    assert same(of_csv) == same(of_bag)
    assert notes == [f'note: {path}: columns that are not read: remark']


@pytest.mark.parametrize('change', [
    lambda text: text[:-3], lambda text: text[:len(text) // 2].rpartition('\n')[0] + '\n',
    lambda text: text.replace(',0.5338\n', ',0.75\n', 1),
    lambda text: text.replace('ts_variance_factor', 'ts_variance')],
    ids=['last digits cut', 'half', 'a factor', 'a column'])
def test_an_account_of_other_pairs_does_not_count_and_the_verdict_says_so(
        pairs, capsys, change):
    path, of_bag = pairs
    text = path.read_text()
    assert change(text) != text
    path.write_text(change(text))
    of_csv, notes = analyze_json(capsys, path)
    said = ('pairs.csv.account.json belongs to other pairs, and does not count: what was '
            'rejected, lost or without partner is unknown')
    assert said in of_csv['inputs'][0]['ledger_problems']
    assert f'note: {path}: {said}' in notes
    assert not of_csv['ledger_complete'] and of_bag['ledger_complete']


def test_the_csv_of_this_package_without_its_account_says_what_is_unknown(pairs, capsys):
    path, _ = pairs
    account_path(path).unlink()
    of_csv, notes = analyze_json(capsys, path)
    assert of_csv['inputs'][0]['ledger_problems'] == [
        'pairs.csv.account.json is not beside it: what was rejected, lost or without partner is '
        'unknown']
    assert of_csv['inputs'][0]['ts_topic'] is None


def test_pairs_cannot_be_paired_again(pairs, capsys):
    path, _ = pairs
    of_csv, notes = analyze_json(capsys, path, '--set', 'pairing.max_gap_s=1.5', '--set',
                               'alignment.skew=apply')
    assert notes[0] == (f'note: {path}: alignment.skew = apply: a csv of pairs has no readings to '
                        'align; it is judged as it was paired')
    assert of_csv['inputs'][0]['ledger_problems'] == [
        'its pairs were made with pairing.max_gap_s = auto, not 1.5']


@pytest.mark.parametrize('text, problem', [
    ('', 'Expecting value'), ('[]', 'is no account of pairs'),
    ('{"schema": "x"}', 'is no account'), ('[' * 100_000, 'is no account of pairs'),
    (b'\xff\xfe\x00', "can't decode"),
    ({'segments': None}, 'segments = None: must be a list'),
    ({'segments': [{'start_ns': None, 'counts': {'eaten': 1}}]}, 'eaten'),
    ({'segments': [{'start_ns': None, 'counts': {}}] * 2}, r'segments\[1\].start_ns = None'),
    ({'marks': [['begin', 1]]}, r"marks\[0\]\[0\] = 'begin': must be 'start' or 'stop'"),
    ({'inputs': [{}]}, r'inputs\[0\].path is missing'),
])
def test_a_wrong_account_is_one_line(pairs, capsys, text, problem):
    path, _ = pairs
    account = account_path(path)
    if isinstance(text, dict):
        text = json.dumps({**json.loads(account.read_text()), **text})
    account.write_bytes(text if isinstance(text, bytes) else text.encode())
    err = refusal(capsys, 'analyze', path, *NORMS)
    assert f'{account}: ' in err and 'remove it to judge the pairs alone' in err
    assert re.search(problem, err)


def test_the_account_overwrites_no_input(pairs, tmp_path, capsys):
    path, _ = pairs
    given = tmp_path / 'given.csv'
    given.write_bytes(path.read_bytes())
    (tmp_path / 'b.csv.account.json').symlink_to(given)
    assert main(['analyze', str(given), *NORMS, '--csv', str(tmp_path / 'b.csv')]) == 2
    out, err = capsys.readouterr()
    assert out == '' and err.endswith('b.csv.account.json: that is an INPUT; name another file\n')
    assert main(['analyze', str(path), *NORMS, '--csv', str(tmp_path / 'c.csv'), '--json',
                 str(tmp_path / 'c.csv.account.json')]) == 2
    assert 'that is the file of --csv' in capsys.readouterr().err


def test_pairs_in_radians_are_refused_and_signed_degrees_are_taken(tmp_path, capsys, rng):
    """Both sensors turn across north; as degrees, radians would comply."""
    course = 60.0 * np.sin(np.arange(1500) / 60.0)
    ts, rs = (course + sigma * rng.standard_normal(1500) for sigma in (0.1, 0.05))
    form = {'deg': lambda x: (x + 180.0) % 360.0 - 180.0, 'rad': lambda x: np.radians(x % 360.0)}
    for unit, make in form.items():
        rows = ''.join(f'{(1716926400 + k) * 10 ** 9},{a:.5f},{b:.5f}\n'
                       for k, (a, b) in enumerate(zip(make(ts), make(rs))))
        (tmp_path / f'{unit}.csv').write_text('stamp_ns,ts_deg,rs_deg\n' + rows)
    norms = ['--set', 'norms.sigma_max_deg=0.2', '--set', 'norms.sigma_ref_max_deg=0.1']
    assert main(['analyze', str(tmp_path / 'deg.csv'), *norms]) == 0
    assert capsys.readouterr().out.startswith('VERDICT: COMPLIANT')
    assert main(['analyze', str(tmp_path / 'rad.csv'), *norms]) == 2
    assert 'ts_deg: the headings lie within' in capsys.readouterr().err
