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

"""The protocol of `analyze`, in short `report`: of its inputs, or of a verdict in JSON."""

from __future__ import annotations

import json

from command_line import NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.cli import main
from heading_intercompare.readers.registry import is_verdict

S = 1_000_000_000


@pytest.fixture
def pairs(tmp_path):
    """Return two csv files of ten minutes at 1 Hz, TS 0.1° sd."""
    files = []
    for number in range(2):
        rng = np.random.default_rng(number)
        rows = [f'{(1_400_000_000 + 1000 * number + i) * S},{100.0 + x:.6f},100.0'
                for i, x in enumerate(0.1 * rng.standard_normal(600))]
        files.append(tmp_path / f'p{number}.csv')
        files[-1].write_text('\n'.join(['stamp_ns,ts_deg,rs_deg', *rows]) + '\n')
    return files


@pytest.fixture
def verdict(pairs, tmp_path, capsys):
    """Return the file of a verdict, and what was printed when it was made."""
    file = tmp_path / 'verdict.json'
    assert main(['analyze', str(pairs[0]), *NORMS, '--json', str(file)]) == 0
    return file, capsys.readouterr().out


@pytest.mark.slow
def test_a_report_takes_what_analyze_takes(pairs, tmp_path, capsys):
    table, page = tmp_path / 'runs.csv', tmp_path / 'r.html'
    table.write_text(f'start,stop\n{1_400_000_000 * S},{1_400_000_300 * S}\n'
                     f'{1_400_001_000 * S},{1_400_001_200 * S}\n')
    given = [*map(str, pairs), *NORMS, '--runs', str(table), '--jobs', '1', '--quiet']
    assert main(['analyze', *given, '--report', str(page)]) == 0
    printed, drawn = capsys.readouterr(), page.read_text('utf-8')
    assert main(['report', *given, '-o', str(page), '--json', str(tmp_path / 'v.json')]) == 0
    assert capsys.readouterr() == printed
    assert page.read_text('utf-8') == drawn
    assert [run['n'] for run in json.loads((tmp_path / 'v.json').read_text())['runs']] == [
        300, 200]


@pytest.mark.parametrize('command', ['analyze', 'report'])
def test_a_verdict_becomes_the_protocol_without_the_readings(verdict, pairs, tmp_path, capsys,
                                                             command):
    file, printed = verdict
    for path in pairs:
        path.unlink()
    page, again = tmp_path / 'r.html', tmp_path / 'again.json'
    assert main([command, str(file), '-o', str(page), '-o', str(again), '--check']) in (0, 3)
    first, label, *rest = capsys.readouterr().out.splitlines()
    assert [first, *rest] == printed.splitlines()
    assert label.startswith('printed from a file, not judged here; verdict id ')
    text = page.read_text('utf-8')
    assert label in text.partition('class="signatures"')[0]
    assert 'None: the protocol was made from the verdict alone.' in text
    assert again.read_bytes() == file.read_bytes()
    assert main([command, str(file), '-o', str(page), '--json', '-']) == 0
    assert capsys.readouterr().out == file.read_text('utf-8')


@pytest.mark.parametrize('asked, shown', [
    ([], False), (['--verbose'], True), (['--set', 'norms.k_rule=three'], True)])
def test_the_protocol_and_the_table_show_gk_if_a_contract_asks_or_in_verbose(
        pairs, tmp_path, capsys, asked, shown):
    page, file = tmp_path / 'r.html', tmp_path / 'v.json'
    assert main(['analyze', str(pairs[0]), *NORMS, *asked, '-o', str(page), '-o', str(file)]) == 0
    printed, text = capsys.readouterr().out, page.read_text('utf-8')
    assert ('GK as printed: ' in printed) is ('n+ / n++' in printed) is shown
    for words in ('GK as printed', 'Criteria of GK', 'by GK as printed',
                  'differences beyond the limit, and allowed', 'GK (6): n+'):
        assert (words in text) is shown, words
    assert 'count_criterion' in json.loads(file.read_text())['runs'][0]


def test_the_short_name_needs_a_protocol_and_analyze_needs_none(verdict, capsys):
    file, printed = verdict
    assert '-o is missing' in refusal(capsys, 'report', file)
    assert main(['analyze', str(file)]) == 0
    assert printed.partition('\n')[2] in capsys.readouterr().out


def test_a_log_in_json_is_no_verdict_whatever_its_name(tmp_path, capsys):
    path = tmp_path / 'gpsd.json'
    path.write_text(''.join(
        f'{{"class":"ATT","device":"/dev/gps0","time":"2026-03-01T09:00:0{i}.000Z",'
        f'"heading":10.{i}}}\n' for i in range(9)))
    assert not is_verdict(path)
    assert 'choose with --ts and --rs' in refusal(capsys, 'analyze', path, *NORMS)


def test_the_annexes_of_a_verdict_are_a_second_file(verdict, tmp_path, capsys):
    page, beside = tmp_path / 'r.html', tmp_path / 'r-annexes.html'
    assert main(['report', str(verdict[0]), '-o', str(page), '--annexes-apart']) == 0
    assert 'a second file, r-annexes.html' in page.read_text('utf-8')
    assert 'Annex E. Settings' in beside.read_text('utf-8')


def test_annexes_without_a_protocol_are_refused(pairs, capsys):
    said = refusal(capsys, 'analyze', pairs[0], *NORMS, '--annexes-apart')
    assert '--annexes-apart: no protocol is asked for; give -o F.pdf' in said


@pytest.mark.parametrize('options, words', [
    *((option, '{file}: is a verdict, which is judged by its own settings; leave out '
       f'{" ".join(option)}')
      for option in (['--set', 'window_s=60'], ['--config', 'x.yaml'], ['--runs', 'x.csv'],
                     ['--csv', 'x.csv'], ['--jobs', '2'], ['--logbook', 'x.sqlite'],
                     ['--ts-unit', 'rad'])),
    ([*NORMS, '{file}'], '{file}: is a verdict: heading-intercompare report {file} -o'),
    (['--json', '{file}'], '--json {file}: that is an INPUT'),
    (['-o', '{file}'], '--output {file}: that is an INPUT'),
    (['-o', 'r.html'], '--output r.html: that is the file of --output'),
    (['-o', 'x.txt'], 'x.txt: a report must end in .html or .json or .pdf or .xml'),
    (['--annexes-apart', '--json', 'r-annexes.html'],
     '--json r-annexes.html: that is the file of --annexes-apart; name another file')])
def test_what_a_verdict_cannot_be_asked_for_is_one_line(verdict, tmp_path, capsys, monkeypatch,
                                                        options, words):
    file, _ = verdict
    monkeypatch.chdir(tmp_path)
    before = file.read_bytes()
    said = refusal(capsys, 'report', '-o', tmp_path / 'r.html',
                   *(option.format(file=file) for option in options), file)
    assert words.format(file=file) in said
    assert file.read_bytes() == before and not (tmp_path / 'r.html').exists()


@pytest.mark.parametrize('spoil, words', [
    (lambda text: text[:1000], 'is not JSON: '), (lambda text: '', 'is not JSON: '),
    (lambda text: f'[{text}]', 'a verdict must be an object, not list'),
    (lambda text: text.replace('verdict/1', 'verdict/2'), 'a newer version of '),
    (lambda text: text.replace('"n_input"', '"n_imput"'), 'runs[0].n_input is missing'),
    (lambda text: text.replace('"n_input": 600', '"n_input": "many"'),
     "runs[0].n_input = 'many': must be an integer")])
def test_what_is_no_verdict_is_told_in_one_line(verdict, tmp_path, capsys, spoil, words):
    file, _ = verdict
    file.write_text(spoil(file.read_text('utf-8')), 'utf-8')
    said = refusal(capsys, 'report', file, '-o', tmp_path / 'r.html')
    assert said.startswith(f'{file}: ') and words in said
    assert not (tmp_path / 'r.html').exists()


def test_a_verdict_that_is_not_there_is_named(tmp_path, capsys):
    assert 'v.json: No such file or directory' in refusal(
        capsys, 'report', tmp_path / 'v.json', '-o', tmp_path / 'r.html')


def test_what_is_no_verdict_is_not_asked_to_leave_out_its_options(tmp_path, capsys):
    path = tmp_path / 'a.json'
    path.write_text('{"a": 1}\n')
    said = refusal(capsys, 'analyze', path, *NORMS)
    assert said.startswith(f'{path}: ') and 'schema' in said and 'leave out' not in said
