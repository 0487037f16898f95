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

"""The command `analyze` on journals of live runs: settings, words and exit codes."""

from __future__ import annotations

import json

from journals import last_record_at, some_pairs, write_journal
import pytest

from heading_intercompare.cli import main


@pytest.fixture
def journal(tmp_path):
    """Return a journal of 4000 pairs with a judged run, that was set aside."""
    path = tmp_path / 'compliance.journal.1'
    write_journal(path, some_pairs(4000, gap_at=1500))
    return path


def run(capsys, *arguments):
    """Return the exit code, the output and the errors of a command."""
    code = main([str(one) for one in arguments])
    return (code, *capsys.readouterr())


@pytest.mark.parametrize('sigma_deg, check, code', [
    (0.1, True, 0), (0.1, False, 0), (0.5, True, 1), (0.5, False, 0)])
def test_a_journal_is_judged_with_its_own_settings(tmp_path, capsys, sigma_deg, check, code):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(4000, sigma_deg))
    found, out, err = run(capsys, 'analyze', path, *(['--check'] if check else []))
    assert found == code and out.startswith('VERDICT: ')
    assert 'norms: sigma_max 0.3 deg' in out
    assert f'{path}: is the journal of a live run, begun at ' in out
    assert f'note: {path}: it ends with the pair of ' in err


def test_a_short_journal_is_indeterminate(tmp_path, capsys):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(40))
    assert run(capsys, 'analyze', path, '--check')[0] == 3


def test_set_changes_a_setting_of_the_journal_and_config_replaces_all(tmp_path, capsys, journal):
    code, out, _ = run(capsys, 'analyze', journal, '--set', 'norms.sigma_max_deg=0.25')
    assert code == 0 and 'sigma_max 0.25 deg, sigma_ref_max 0.1 deg' in out
    assert 'judged by other settings than those of its node: norms.sigma_max_deg' in out
    config = tmp_path / 'c.yaml'
    config.write_text("'/**': {ros__parameters: {norms: {sigma_max_deg: 0.2, "
                      'sigma_ref_max_deg: 0.15}}}')
    code, out, _ = run(capsys, 'analyze', journal, '--config', config)
    assert code == 0 and 'sigma_max 0.2 deg, sigma_ref_max 0.15 deg' in out


def test_report_json_and_tables_take_a_journal(tmp_path, capsys, journal):
    pytest.importorskip('jinja2')
    pytest.importorskip('matplotlib')
    code, out, _ = run(capsys, 'report', journal, '-o', tmp_path / 'p.html', '--json', '-',
                       '--csv', tmp_path / 'pairs.csv')
    given, = json.loads(out)['inputs']
    assert (code, given['path']) == (0, str(journal))
    page = (tmp_path / 'p.html').read_text('utf-8')
    assert 'is the journal of a live run' in page and 'The ledger is not complete' in page
    assert len((tmp_path / 'pairs.csv').read_text().splitlines()) == 2501
    code, _, err = run(capsys, 'analyze', journal, '--json', journal)
    assert code == 2 and 'that is an INPUT' in err


def test_a_journal_beside_a_csv_needs_settings(tmp_path, capsys, journal):
    run(capsys, 'analyze', journal, '--csv', tmp_path / 'pairs.csv')
    code, _, err = run(capsys, 'analyze', journal, tmp_path / 'pairs.csv')
    assert code == 2 and 'norms.sigma_max_deg is missing' in err
    code, out, _ = run(capsys, 'analyze', journal, tmp_path / 'pairs.csv', '--set',
                       'norms.sigma_max_deg=0.3', '--set', 'norms.sigma_ref_max_deg=0.1')
    assert code == 0 and '\ncompliance.journal.1 ' in out and '\npairs.csv ' in out


@pytest.mark.parametrize('name, data, words', [
    ('x.journal', b'heading_intercompare journal 7\nrest', 'is a journal of version 7, must be 3'),
    ('x.bin', b'heading_intercompare journal 12\n', 'is a journal of version 12, must be 3'),
    ('x.journal', b'something else', 'is not a journal'), ('x.journal.3', b'', 'is not a journal'),
    ('x.journal', b'heading_intercompare journal 3\n', 'its first record was cut'),
    ('x.journal', None, 'No such file or directory')])
@pytest.mark.parametrize('command', ['analyze', 'info'])
def test_a_wrong_file_is_refused_in_one_line(tmp_path, capsys, command, name, data, words):
    path = tmp_path / name
    if data is not None:
        path.write_bytes(data)
    code, out, err = run(capsys, command, path)
    assert (code, out, err.count('\n')) == (2, '', 1)
    assert f'{path}: {words}' in err


def test_a_torn_journal_ends_with_a_verdict_whatever_the_byte(tmp_path, capsys):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(300), booked=False)
    whole = path.read_bytes()
    begin = last_record_at(path)
    for size in (*range(begin, begin + 40), *range(len(whole) - 40, len(whole))):
        path.write_bytes(whole[:size])
        code, out, _ = run(capsys, 'analyze', path)
        assert code == 0 and out.startswith('VERDICT: ')
        assert ('of a record that was cut' in out) == (size > begin)
    code, _, err = run(capsys, 'info', path, '--check')
    assert code == 2 and 'bytes are of a record that was cut' in err
