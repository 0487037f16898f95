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

"""History --certify: a month of runs judged together, with the outputs of analyze."""

from __future__ import annotations

from dataclasses import replace
import json
from pathlib import Path
import shutil
import subprocess

from command_line import NORMS, refusal
import numpy as np
import pytest
from trials import make_settings, make_turning_ship, write_headings

from heading_intercompare import analyze
from heading_intercompare.cli import main
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import make_rows
from heading_intercompare.report.json import CONFIRMED

RUNS = 6
SETTINGS = (*NORMS, '--set', 'risk.slowest_error_s=300')


@pytest.fixture(scope='module')
def trials(tmp_path_factory):
    """Return a folder with a bag of each day, and the logbook into which they were judged."""
    place = tmp_path_factory.mktemp('trials')
    for day in range(RUNS):
        rng = np.random.default_rng(day)
        ts, rs = make_turning_ship(day, 0.1 * rng.standard_normal(600))
        bag = write_headings(place / f'day{day}', {'/ts/heading': ts, '/rs/heading': rs})
        assert main(['analyze', bag, *SETTINGS, '--ts', '/ts/heading', '--rs', '/rs/heading',
                     '--logbook', str(place / 'l.sqlite'), '--ship', 'MV X', '--quiet']) == 0
    return place


@pytest.fixture
def book(trials, tmp_path, monkeypatch):
    """Return the path of a copy of that logbook, in a folder where tests write."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / 'l.sqlite'
    path.write_bytes((trials / 'l.sqlite').read_bytes())
    return str(path)


def certify(book, *options, n=RUNS):
    return main(['history', book, '--certify', str(n), '--quiet', *options])


def test_it_prints_a_line_per_recording_and_which_runs_these_are(book, capsys):
    capsys.readouterr()
    assert certify(book, '--check') == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith('VERDICT: COMPLIANT for errors that change within ')
    assert sorted(line.split()[0] for line in lines[3:10]) == [*(
        f'day{day}' for day in range(RUNS)), 'recording']
    assert lines[-1] == ('the last 6 usable runs of MV X in l.sqlite; none since the first of '
                         'them left out')


def test_the_verdict_is_confirmed_by_its_recordings_and_its_protocol_shows_the_choice(
        book, capsys):
    assert certify(book, '--json', 'v.json', '-o', 'p.html') == 0
    protocol = Path('p.html').read_text('utf-8')
    assert 'Runs of a logbook: the last 6 usable runs of MV X in l.sqlite; none ' in protocol
    assert Logbook(book).read_head().sha256 in protocol
    capsys.readouterr()
    assert main(['verify', 'v.json']) == 3
    assert capsys.readouterr().out.count('holds the data that were judged') == RUNS
    assert main(['report', 'v.json', '-o', 'q.html', '--check', '--quiet']) == 0
    assert CONFIRMED in capsys.readouterr().out
    assert 'Runs of a logbook: the last 6 usable runs of MV X' in Path('q.html').read_text('utf-8')


def test_a_changed_verdict_is_refused(book, capsys):
    assert certify(book, '--json', 'v.json') == 0
    verdict = json.loads(Path('v.json').read_text('utf-8'))
    verdict['campaign']['sensor']['upper_bound_deg2'] *= 0.5
    Path('v.json').write_text(json.dumps(verdict), 'utf-8')
    assert 'campaign.sensor.upper_bound_deg2 is ' in refusal(
        capsys, 'report', 'v.json', '-o', 'q.html')


@pytest.mark.process
@pytest.mark.skipif(shutil.which('ssh-keygen') is None, reason='OpenSSH is not installed')
def test_the_verdict_and_its_protocol_are_signed(book, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv('HOME', str(tmp_path))
    subprocess.run(['ssh-keygen', '-q', '-t', 'ed25519', '-N', '', '-f', 'key'], check=True)
    Path('signers').write_text(f'mate@ship {Path("key.pub").read_text()}')
    assert certify(book, '--json', 'v.json', '-o', 'p.html', '--sign', 'key', '--signers',
                   'signers') == 0
    assert 'the verdict is signed by mate@ship' in Path('p.html').read_text('utf-8')
    assert main(['verify', 'v.json', 'p.html', '--signers', 'signers']) == 0


@pytest.mark.parametrize('sigma, code', [(1.0, 0), (5.0, 1)])
def test_check_ends_with_the_exit_code_of_analyze(sigma, code, tmp_path, capsys):
    """Six runs at 0.1 and at 0.5 deg; the norm is 0.3 deg."""
    for day in range(RUNS):
        trial = make_turning_ship(day, sigma * 0.1 * np.random.default_rng(day).normal(size=600))
        verdict = analyze(*trial, make_settings(risk__slowest_error_s=300.0))
        Logbook(tmp_path / 'l.sqlite').write(make_rows(verdict))
    assert certify(str(tmp_path / 'l.sqlite'), '--check') == code


def test_json_and_a_table_of_runs(book, capsys):
    capsys.readouterr()
    assert certify(book, '--json', '-', '--runs-csv', 'runs.csv', n=5) == 0
    verdict = json.loads(capsys.readouterr().out)
    assert verdict['schema'] == 'heading_intercompare/verdict/1'
    assert verdict['chosen']['asked'] == len(verdict['runs']) == 5
    assert len(Path('runs.csv').read_text('utf-8').splitlines()) == 6


def spoil(book, day, **more):
    """Change the row of a day, and write it as the program does."""
    rows = Logbook(book).read_records(Logbook(book).read())
    Logbook(book).write([replace(rows[day], **more)])


def test_runs_left_out_are_named_and_too_few_are_refused(book, capsys):
    spoil(book, 2, outcome='indeterminate', reason='void.clocks', validity_effect='void',
          headline='INDETERMINATE, VOID', conditions='clocks=void')
    capsys.readouterr()
    assert certify(book, n=5) == 0
    assert capsys.readouterr().out.splitlines()[-1] == (
        '  1 run left out, void by clocks: 2023-11-16 02:00 UTC')
    assert refusal(capsys, 'history', book, '--certify', '6') == (
        f'{book}: 6 runs are asked for, and 5 can be judged together; 1 run left out, void by '
        'clocks: 2023-11-16 02:00 UTC')


@pytest.mark.parametrize('options, why', [
    (['--certify', '4'], '--certify 4: must be at least 5 runs'),
    (['--certify', '6', '--since', '2026-01-01'],
     '--since 2026-01-01: is not for --certify; leave it out'),
    (['--certify', '6', '--baseline', '20'], '--baseline 20: is not for --certify'),
    (['--certify', '6', '--csv', 'c.csv'], '--csv c.csv: is not for --certify'),
    (['-o', 'p.html'], '--output p.html: is for --certify N; leave it out'),
    (['--annexes-apart'], '--annexes-apart: is for --certify N; leave it out'),
    (['--sign', 'key'], '--sign key: is for --certify N'),
    (['--certify', '6', '--json', 'l.sqlite'], '--json l.sqlite: that is a LOGBOOK'),
    (['--certify', '6', '-o', 'p.txt'], 'p.txt'),
    (['--certify', '6', '-o', 'no/p.html'], '--output no/p.html: there is no folder'),
    (['--certify', '6', '--sign', 'key'], '--sign key: signs the verdict in JSON'),
    (['--certify', '6', '--ship', 'MV Y'], '6 runs are asked for, and 0 can be judged together')])
def test_a_wrong_option_is_refused_in_one_line(book, capsys, options, why):
    if options[-2:] == ['--sign', 'key']:
        Path('key').touch()
    assert why in refusal(capsys, 'history', book, *options)
