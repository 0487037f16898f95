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

"""The files that `analyze` and `report` write besides the verdict: ensembles, pairs, protocol."""

from __future__ import annotations

import csv
import json
from pathlib import Path
import re
import subprocess

from command_line import NORMS, refusal
import numpy as np
import pytest
from trials import write_headings

from heading_intercompare import Headings
from heading_intercompare.bags.rosbag2.provenance import Notes
from heading_intercompare.cli import main
from heading_intercompare.logbook.logbook_file import Logbook

S = 1_000_000_000
T0 = 1_406_851_200 * S


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a bag of 10 minutes at 10 Hz with 2 minutes of silence; TS 0.1° sd, 0.2° off."""
    path = tmp_path_factory.mktemp('bag') / 'trial'
    rng = np.random.default_rng(2)
    stamps = T0 + np.arange(6000) * (S // 10)
    stamps[4000:] += 120 * S
    heading = np.mod(355.0 + 0.005 * np.arange(6000), 360.0)
    streams = {topic: Headings.of(stamps, heading + offset + error * rng.standard_normal(6000))
               for topic, error, offset in (('ts/heading', 0.1, 0.2), ('rs/heading', 0.0, 0.0))}
    write_headings(path, streams, write_more=lambda writer: Notes(writer.metadata).add(
        '2014-08-01T00:03:00Z course <change>', T0))
    return path


def rows(path):
    """Return the rows of a csv, of numbers."""
    with open(path, newline='') as file:
        return [{name: float(text) for name, text in row.items()} for row in csv.DictReader(file)]


def test_the_card_of_a_bag_is_that_of_its_verdict_in_json(bag, tmp_path, capsys):
    """The ship turns from 355 to 25 deg in ten minutes; the TS is 0.2 deg too far."""
    card, again, verdict = (tmp_path / name for name in ('c.csv', 'again.csv', 'v.json'))
    assert main(['analyze', str(bag), *NORMS, '--card', str(card), '--json', str(verdict)]) == 0
    with open(card, newline='') as file:
        sectors = [row for row in csv.DictReader(file) if row['n'] != '0']
    assert [(row['run'], row['heading_deg']) for row in sectors] == [
        ('1', '0'), ('2', '0'), ('2', '45')]
    for row in sectors:
        assert float(row['c_minus_o_deg']) == pytest.approx(-0.2, abs=0.02)
    assert main(['analyze', str(verdict), '--card', str(again)]) == 0
    assert again.read_text() == card.read_text()
    assert '--card' in refusal(capsys, 'analyze', bag, *NORMS, '--card', tmp_path)


def test_the_corrections_are_minus_the_means_of_the_ensembles(bag, tmp_path, capsys):
    ensembles, series = tmp_path / 'e.csv', tmp_path / 's.csv'
    assert main(['analyze', str(bag), *NORMS, '--ensembles', str(ensembles), '--corrections',
                 str(series), '--running-s', '600']) == 0
    with open(series, newline='') as file:
        found = [*csv.DictReader(file)]
    for ensemble, row in zip(rows(ensembles), found, strict=True):
        assert float(row['correction']) == -ensemble['mean_dh']
        assert float(row['dday']) == ensemble['dday']
        assert float(row['running']) == pytest.approx(-0.2, abs=0.02)
    assert [row['flag'] for row in found] == ['0', '0', '0', '1', '0', '0']
    assert 'running window = 60.0 s' in refusal(
        capsys, 'analyze', bag, *NORMS, '--corrections', series, '--running-s', '60')


def test_ensembles_are_written_and_are_those_of_the_pairs(bag, tmp_path, capsys):
    """400 s, 120 s of silence, 200 s: 4 and 2 ensembles of 120 s."""
    ensembles, pairs, again = (tmp_path / name for name in ('e.csv', 'p.csv', 'again.csv'))
    assert main(['analyze', str(bag), *NORMS, '--ensembles', str(ensembles), '--csv',
                 str(pairs)]) == 0
    found, pairs_found = rows(ensembles), rows(pairs)
    assert [row['num'] for row in found] == [1200, 1200, 1200, 400, 1200, 800]
    at = 0
    for row in found:
        mine = pairs_found[at:at + int(row['num'])]
        at += len(mine)
        x = [pair['difference_deg'] for pair in mine]
        assert row['mean_dh'] == pytest.approx(np.mean(x), abs=6e-5)
        assert row['std_dh'] == pytest.approx(np.std(x, ddof=1), abs=6e-5)
        assert row['last_hdg'] == pytest.approx(mine[-1]['ts_deg'], abs=6e-5)
        day = (mine[-1]['stamp_ns'] - T0) / (86400 * S) + 212
        assert row['dday'] == pytest.approx(day, abs=2e-7)
        assert row['badflag'] == 0
    assert found[0]['mean_hdg'] == pytest.approx(358.2, abs=0.02)
    assert main(['analyze', str(pairs), *NORMS, '--ensembles', str(again)]) == 0
    assert again.read_text() == ensembles.read_text()
    capsys.readouterr()


def test_the_length_of_an_ensemble_can_be_set_and_the_norms_set_the_flag(bag, tmp_path, capsys):
    """√(0.05² + 0.05²) = 0.07, less than the standard deviation of 0.1."""
    path = tmp_path / 'e.csv'
    assert main(['analyze', str(bag), '--ensembles', str(path), '--ensemble-s', '300', '--set',
                 'norms.sigma_max_deg=0.05', '--set', 'norms.sigma_ref_max_deg=0.05']) == 0
    assert [(row['num'], row['badflag']) for row in rows(path)] == [
        (3000, 1), (1000, 1), (2000, 1)]
    capsys.readouterr()


@pytest.mark.parametrize('arguments, words', [
    (['{bag}', '{bag}', '--ensembles', '{to}'], 'takes the pairs of one INPUT, but 2 are given'),
    (['{bag}', '--ensembles', '{to}', '--ensemble-s', '0'], 'must be from 1 to 86400'),
    (['{bag}', '--ensembles', '{to}', '--ensemble-s', 'nan'], 'must be from 1 to 86400'),
    (['{bag}', '--ensembles', '{to}', '--ensemble-s', 'long'], "invalid float value: 'long'"),
    (['{bag}', '--ensembles', 'nowhere/x.csv'], 'nowhere/x.csv: there is no folder '),
    (['{bag}', '--ensembles', '{to}', '--csv', '{to}'], 'that is the file of --csv'),
    (['{bag}', '--csv', '-'], '--csv -: name a file'),
    (['{bag}', '--json', '{bag}'], '--json {bag}: that is an INPUT'),
    (['{bag}', '--json', '{bag}/..'], 'is a folder; name a file'),
    (['{bag}', '--json', '{bag}/trial_0.mcap'], 'trial_0.mcap: that is a file of {bag}'),
    (['{bag}', '--csv', '{bag}/metadata.yaml'], 'metadata.yaml: that is a file of {bag}'),
    (['{bag}', '--runs', '{to}', '--report', '{to}/../e.html', '--csv', '{to}'],
     'that is the file of --runs'),
    (['{bag}', '--config', '{config}', '--json', '{config}'], 'that is the file of --config'),
    (['{bag}', '--json', '{to}', '--report', '{to}.html', '--ensembles', '{to}.html'],
     'that is the file of --ensembles')])
def test_a_mistake_about_the_files_is_one_line(bag, tmp_path, capsys, arguments, words):
    config = tmp_path / 'my.yaml'
    config.write_text('/**: {ros__parameters: {window_s: 60.0}}')
    names = {'bag': bag, 'to': tmp_path / 'e.csv', 'config': config}
    given = [a.format(**names) for a in arguments]
    before = _files(bag)
    assert words.format(**names) in refusal(capsys, 'analyze', *given, *NORMS)
    assert _files(bag) == before and config.read_text() and not names['to'].exists()


def _files(folder) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_table_is_not_touched_before_there_are_pairs(bag, tmp_path, capsys):
    table = tmp_path / 'p.csv'
    table.write_text('precious')
    refusal(capsys, 'analyze', tmp_path / 'nothing', *NORMS, '--csv', table)
    assert table.read_text() == 'precious'
    empty = tmp_path / 'empty.csv'
    empty.write_text('stamp_ns,ts_deg,rs_deg\n')
    assert main(['analyze', str(empty), *NORMS, '--csv', str(table)]) == 0
    assert table.read_text().startswith('stamp_ns,') and table.read_text().count('\n') == 1


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='there is no full device')
@pytest.mark.parametrize('option', ['--csv', '--ensembles', '--json'])
def test_a_full_disk_is_named_with_the_file(bag, capsys, option):
    assert main(['analyze', str(bag), *NORMS, option, '/dev/full']) == 2
    assert '/dev/full: No space left on device' in capsys.readouterr().err


def test_the_verdict_is_told_though_the_report_cannot_be_written(bag, tmp_path, capsys,
                                                                 monkeypatch):
    def full(*args):
        raise OSError(28, 'No space left on device', 'r.html')
    monkeypatch.setattr('heading_intercompare.cli.commands.analyze.write_protocols', full)
    told = tmp_path / 'v.json'
    assert main(['analyze', str(bag), *NORMS, '--json', str(told), '--report', 'r.html']) == 2
    out, err = capsys.readouterr()
    assert out.startswith('VERDICT: ') and json.loads(told.read_text())['runs']
    assert err.endswith('r.html: No space left on device\n')


@pytest.mark.parametrize('option', ['--csv', '--ensembles', '--json'])
def test_an_input_is_never_overwritten(bag, tmp_path, capsys, option):
    path = tmp_path / 'pairs.csv'
    path.write_text('stamp_ns,ts_deg,rs_deg\n1,2,3\n')
    assert 'that is an INPUT' in refusal(capsys, 'analyze', path, *NORMS, option, path)
    assert path.read_text() == 'stamp_ns,ts_deg,rs_deg\n1,2,3\n'


@pytest.mark.slow
def test_report_writes_the_protocol_with_the_notes(bag, tmp_path, capsys):
    path = tmp_path / 'protocol.html'
    assert main(['report', str(bag), '-o', str(path), *NORMS]) == 0
    assert capsys.readouterr().out.startswith('VERDICT: ')
    page = path.read_text()
    assert '2014-08-01 00:03:00.000 UTC' in page and 'course &lt;change&gt;' in page


@pytest.mark.slow
def test_the_json_holds_the_notes_and_a_sha256_that_anybody_can_check(bag, tmp_path, capsys):
    whole = (bag / 'trial_0.mcap').read_bytes()
    # Two that end too soon, by which they are no copies, and one copy, which is left out.
    for number, content in ((10, whole[:-1]), (2, whole[:-2])):
        (bag / f'trial_{number}.mcap').write_bytes(content)
    try:
        (bag / 'trial_3.mcap').write_bytes(whole)
        assert main(['analyze', str(bag), *NORMS, '--json', '-']) == 0
        (bag / 'trial_3.mcap').unlink()
        entry, = json.loads(capsys.readouterr().out)['inputs']
        done = subprocess.run(['sh', '-c', 'export LC_ALL=C; cat "$0"/*.mcap | sha256sum', bag],
                              capture_output=True, text=True, check=True)
    finally:
        for number in (10, 2, 3):
            (bag / f'trial_{number}.mcap').unlink(missing_ok=True)
    assert entry['sha256'] == done.stdout.split()[0]
    assert entry['notes'] == [{'stamp_ns': T0 + 180 * S, 'text': 'course <change>'}]
    assert main(['analyze', str(bag), *NORMS, '--csv', str(tmp_path / 'p.csv')]) == 0
    capsys.readouterr()
    assert main(['analyze', str(tmp_path / 'p.csv'), *NORMS, '--json', '-']) == 0
    again, = json.loads(capsys.readouterr().out)['inputs']
    assert again['notes'] == entry['notes'] and list(again['made_from']) == [str(bag)]


@pytest.mark.slow
def test_a_logbook_gets_a_row_per_run_and_a_second_time_none(bag, tmp_path, capsys):
    book = tmp_path / 'l.sqlite'
    config = tmp_path / 'c.yaml'
    config.write_text("compliance:\n  ros__parameters:\n    ship: 'MV Example'\n")
    for more in ([], ['--config', str(config)], ['--ship', 'B', '--config', str(config)]):
        for _ in range(2):
            assert main(['analyze', str(bag), *NORMS, '--logbook', str(book), *more]) == 0
    capsys.readouterr()
    found = Logbook(book).read()
    assert sorted((row.ship, row.n) for row in found) == [
        ('', 2000), ('', 4000), ('B', 2000), ('B', 4000), ('MV Example', 2000),
        ('MV Example', 4000)]
    assert {row.bag for row in found} == {str(bag)}


def test_a_logbook_has_the_runs_that_are_too_old_for_the_verdict(bag, tmp_path, capsys):
    """Cut each minute, 4 + 3 runs, of which the verdict covers the newest."""
    book = tmp_path / 'l.sqlite'
    assert main(['analyze', str(bag), *NORMS, '--logbook', str(book), '--json', '-',
                 '--set', 'runs.every_h=0.0333333333333333', '--set', 'runs.keep=1']) == 0
    runs = json.loads(capsys.readouterr().out)['runs']
    found = Logbook(book).read()
    assert len(found) > len(runs) and sum(row.n for row in found) == 6000
    assert [row.start_ns for row in found][-len(runs):] == [run['start_ns'] for run in runs]


def test_a_logbook_that_cannot_be_written_stops_the_command_before_the_work(
        bag, tmp_path, capsys):
    said = refusal(capsys, 'analyze', bag, *NORMS, '--logbook', tmp_path / 'no' / 'l')
    assert 'cannot be opened' in said
    said = refusal(capsys, 'analyze', bag, *NORMS, '--logbook', next(bag.glob('*.mcap')))
    assert 'is not a logbook' in said


@pytest.fixture
def exclusions(tmp_path):
    """Return a function that writes a table of stretches to take out."""
    def make(*lines):
        path = tmp_path / 'exclude.csv'
        path.write_text('\n'.join(('start,end,reason', *lines)) + '\n', 'utf-8')
        return path
    return make


def test_stretches_taken_out_are_in_json_and_protocol_with_their_reasons(
        bag, tmp_path, exclusions, capsys):
    """One minute of ten; the record begins at 2014-08-01T00:00:00Z."""
    table = exclusions('2014-08-01T00:01:00Z,2014-08-01T00:02:00Z,"tug <alongside>, by order"')
    found, page = tmp_path / 'verdict.json', tmp_path / 'protocol.html'
    assert main(['analyze', str(bag), *NORMS, '--exclude', str(table), '--json', str(found),
                 '--report', str(page)]) == 0
    out = capsys.readouterr().out
    assert '10 % of the pairs are left out (tug' in out and 'as recorded' in out
    verdict = json.loads(found.read_text('utf-8'))
    (stretch,) = verdict['taken_out']['stretches']
    assert (stretch['reason'], stretch['n']) == ('tug <alongside>, by order', 600)
    text = page.read_text('utf-8')
    assert 'tug &lt;alongside&gt;, by order' in text
    assert 'Variance as recorded: ' in text
    assert 'left out: taken out by hand' in text
    assert '>taken out by hand</text>' in text, 'the figures against time are shaded'


def test_the_protocol_of_a_json_names_what_was_taken_out(bag, tmp_path, exclusions, capsys):
    table = exclusions('2014-08-01T00:01:00Z,2014-08-01T00:02:00Z,tug')
    found, page = tmp_path / 'verdict.json', tmp_path / 'protocol.html'
    main(['analyze', str(bag), *NORMS, '--exclude', str(table), '--json', str(found)])
    assert main(['report', str(found), '-o', str(page)]) == 0
    assert 'Variance as recorded: ' in page.read_text('utf-8')
    capsys.readouterr()
    assert '--exclude' in refusal(capsys, 'report', found, '-o', page, '--exclude', table)


def test_a_stretch_outside_of_the_record_is_a_note(bag, exclusions, capsys):
    table = exclusions('2013-08-01T00:01:00Z,2013-08-01T00:02:00Z,tug')
    assert main(['analyze', str(bag), *NORMS, '--exclude', str(table)]) == 0
    assert ('note: exclusions: 2013-08-01 00:01:00.000 to 2013-08-01 00:02:00.000 UTC (tug) takes '
            'out nothing') in capsys.readouterr().err


@pytest.mark.parametrize('line, why', [
    ('2014-08-01T00:01:00Z,2014-08-01T00:02:00Z', 'row 2: .*must be start, end, reason'),
    ('2014-08-01T00:01:00Z,2014-08-01T00:02:00Z,"tug\n'
     '2014-08-01T00:03:00Z,2014-08-01T00:04:00Z,tug', 'a quotation mark hides the rows after it'),
    ('2014-08-01T00:02:00Z,2014-08-01T00:01:00Z,tug', 'row 2: end .* is not after start'),
    ('noon,2014-08-01T00:01:00Z,tug', "row 2: 'noon' is neither ISO UTC"),
])
def test_a_wrong_table_of_stretches_is_one_line_with_its_file(bag, exclusions, line, why, capsys):
    table = exclusions(line)
    said = refusal(capsys, 'analyze', bag, *NORMS, '--exclude', table)
    assert str(table) in said and re.search(why, said)


def test_an_empty_or_binary_table_of_stretches_is_one_line(bag, tmp_path, exclusions, capsys):
    assert 'has no row start,end,reason' in refusal(
        capsys, 'analyze', bag, *NORMS, '--exclude', exclusions())
    path = tmp_path / 'binary.csv'
    path.write_bytes(b'\xff\xfe1,2,x')
    assert 'is not csv in UTF-8' in refusal(capsys, 'analyze', bag, *NORMS, '--exclude', path)


def test_a_reason_may_hold_any_sign_in_a_setting(bag, capsys):
    text = '2014-08-01T00:01:00Z, 2014-08-01T00:02:00Z, tug: see log # 7'
    assert main(['analyze', str(bag), *NORMS, '--set', f'exclusions={text}', '--json', '-']) == 0
    verdict = json.loads(capsys.readouterr().out)
    assert verdict['taken_out']['stretches'][0]['reason'] == 'tug: see log # 7'
    assert verdict['settings']['exclusions'] == text
