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

"""Forged verdicts: refused in one line where they contradict themselves, labelled otherwise."""

from __future__ import annotations

import json
from pathlib import Path
import sqlite3

import numpy as np
import pytest
from trials import make_turning_ship, write_headings

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.cli import main
from heading_intercompare.report.json import CONFIRMED, NOT_JUDGED

NORMS = ['--set', 'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1', '--quiet']


@pytest.fixture
def trial(tmp_path, capsys):
    """Return a bag whose TS breaks its norm, the verdict on it, and its logbook."""
    errors_deg = 0.05 + np.random.default_rng(1).normal(0.0, 0.6, 700)
    ts, rs = make_turning_ship(0, errors_deg)
    bag, verdict, book = (str(tmp_path / name) for name in ('trial', 'v.json', 'book.sqlite'))
    write_headings(bag, {'ts/heading': ts, 'rs/heading': rs})
    assert main(['analyze', bag, *NORMS, '--json', verdict, '--logbook', book]) == 0
    capsys.readouterr()
    return bag, Path(verdict), book


def _forge(verdict, change):
    document = json.loads(verdict.read_text('utf-8'))
    change(document)
    verdict.write_text(json.dumps(document), 'utf-8')


def _accept(document):
    document.update(json.loads(json.dumps(document).replace(': "non_compliant"',
                                                            ': "compliant"')))


def _empty_hashes(document):
    document['inputs'][0]['sha256'] = '0' * 64


def _scale(document):
    document['runs'][0]['skew']['estimate']['strength'] *= 2.0


def _multiply(document):
    document['runs'][0]['n'] = 10 ** 9


def test_a_verdict_whose_inputs_are_at_hand_says_that_they_agree(trial, tmp_path, capsys):
    page = tmp_path / 'p.html'
    assert main(['report', str(trial[1]), '-o', str(page), '--quiet']) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[1].startswith(f'{CONFIRMED}; verdict id ') and not err
    assert CONFIRMED in page.read_text('utf-8').partition('class="signatures"')[0]


@pytest.mark.parametrize('change, words', [
    (_accept, 'but its figures give '), (_multiply, 'runs[0].n is 1000000000, but its figures '
                                         'give 700: the file was changed'),
    (_scale, 'runs[0].skew.estimate.strength is ')])
@pytest.mark.parametrize('command', ['analyze', 'report'])
def test_a_forged_verdict_is_refused_in_one_line(trial, tmp_path, capsys, command, change, words):
    _, verdict, _ = trial
    _forge(verdict, change)
    page = tmp_path / 'p.html'
    assert main([command, str(verdict), '-o', str(page), '--quiet']) == 2
    out, err = capsys.readouterr()
    assert not out and not page.exists()
    assert err.count('\n') == 1 and f'{verdict}: ' in err and words in err


def test_a_verdict_with_zeroed_hashes_is_labelled_and_says_why(trial, tmp_path, capsys):
    _, verdict, _ = trial
    _forge(verdict, _empty_hashes)
    page = tmp_path / 'p.html'
    assert main(['report', str(verdict), '-o', str(page), '--quiet']) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[1].startswith(f'{NOT_JUDGED}; verdict id ')
    assert f'note: {verdict}: {NOT_JUDGED}: ' in err and 'holds other data than those' in err
    text = page.read_text('utf-8')
    assert NOT_JUDGED in text.partition('class="signatures"')[0] and CONFIRMED not in text
    assert str(tmp_path) not in text


def test_a_verdict_by_a_table_of_runs_is_not_refused_but_labelled(trial, tmp_path, capsys):
    bag, verdict, _ = trial
    table, page = tmp_path / 'runs.csv', str(tmp_path / 'p.html')
    table.write_text('start,stop\n2023-11-14T22:15:00Z,2023-11-14T22:20:00Z\n')
    assert main(['analyze', bag, *NORMS, '--runs', str(table), '--json', str(verdict)]) == 0
    capsys.readouterr()
    assert main(['report', str(verdict), '-o', page, '--quiet']) == 0
    out, err = capsys.readouterr()
    assert out.splitlines()[1].startswith(f'{NOT_JUDGED}; verdict id ')
    assert 'its inputs alone give other runs, as without a table of runs' in err


def test_a_forged_attachment_is_refused_after_the_rest_of_the_bag(trial, tmp_path, capsys):
    _, verdict, _ = trial
    bags = []
    for name, change in (('sound', lambda document: None), ('forged', _accept)):
        _forge(verdict, change)
        with BagWriter(tmp_path / name) as writer:
            writer.add_topic('ts/heading', 'sensor_msgs/msg/Imu')
            writer.attachment('report.json', 'application/json', verdict.read_bytes())
        bags.append(str(tmp_path / name))
    assert main(['info', bags[0]]) == 0
    assert f'{NOT_JUDGED}; verdict id ' in capsys.readouterr().out
    assert main(['info', bags[1]]) == 2
    out, err = capsys.readouterr()
    assert 'topic' in out and 'VERDICT' not in out and '  wrong: runs[0].' in out
    assert err.count('\n') == 1 and 'attachment report.json: runs[0].' in err


@pytest.mark.parametrize('column, value, words', [
    ('outcome', 'compliant', 'outcome is compliant, but its reason '
     'lower_bound_above_rejection_limit gives non_compliant'),
    ('outcome', 'fine', 'outcome is fine, but its reason'),
    ('reason', 'upper_bound_within_acceptance_limit', 'outcome is non_compliant, but its reason'),
    ('headline', 'COMPLIANT', "headline is 'COMPLIANT', but its outcome gives NON-COMPLIANT"),
    ('lower_bound_deg2', 0.01, 'its lower_bound_deg2 does not exceed its rejection_limit_deg2'),
    ('upper_bound_deg2', 0.02, 'lower_bound_deg2 exceeds upper_bound_deg2'),
    ('sd_deg', 5.0, 'sd_deg is larger than its upper_bound_deg2 allows'),
    ('rejection_limit_deg2', 9.0, 'does not exceed its rejection_limit_deg2'),
    ('validity_effect', 'doubtful', 'validity_effect is doubtful, but its conditions give holds'),
    ('conditions', 'clocks=void', 'validity_effect is holds, but its conditions give void'),
    ('conditions', 'clocks=odd', "conditions are 'clocks=odd', which have no such effect"),
    ('end_ns', 5, 'end_ns lies before start_ns')])
def test_an_edited_row_of_a_logbook_is_refused(trial, capsys, column, value, words):
    """A logbook of version 2, which has no chain of its rows."""
    _, _, book = trial
    assert main(['history', book]) == 0
    capsys.readouterr()
    with sqlite3.connect(book) as connection:
        connection.execute('DROP TABLE chain')
        connection.execute('PRAGMA user_version = 2')
        connection.execute(f'UPDATE runs SET {column} = ?', [value])
    connection.close()
    assert main(['history', book]) == 2
    out, err = capsys.readouterr()
    assert not out and err.count('\n') == 1
    assert f'{book}: row 1, ' in err and words in err and err.endswith(': the row was changed\n')
