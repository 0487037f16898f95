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

"""The command `info` on journals, files of streams, and files that other commands write."""

from __future__ import annotations

from datetime import datetime, timedelta
import math
from pathlib import Path
import shlex

from checksums import with_checksum
from command_line import NORMS, refusal
from journals import some_pairs, write_journal
import numpy as np
import pytest

from heading_intercompare.bags.recording.bag_writer import BagWriter
from heading_intercompare.bags.rosbag2.provenance import RECORD
from heading_intercompare.cli import main
from heading_intercompare.core.records import Headings
from heading_intercompare.messages.heading_messages import encode_imu, IMU
from heading_intercompare.readers.written_files import WRITTEN_FILES

ROOT = Path(__file__).resolve().parents[3]
N = 900


def test_info_names_what_a_journal_holds_and_how_to_judge_it(tmp_path, capsys):
    path = tmp_path / 'my trial.journal'
    write_journal(path, some_pairs(4000, gap_at=1500), [(500, 'start')], bag='trial_7')
    assert main(['info', str(path), '--check']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f'journal: {path}'
    assert lines[2:6] == [
        'begun: 2024-10-04 00:00:00.000 UTC', 'bag: trial_7',
        'span: 2024-10-04 00:35:00.000 to 2024-10-04 01:16:39.000 UTC, 2500 pairs',
        'runs judged before: 1']
    assert '  2024-10-04 00:08:19.000 UTC  start' in lines
    assert '  norms.sigma_max_deg: 0.3' in lines
    assert lines[-1] == f"to judge it: heading-intercompare analyze '{path}'"


def test_a_journal_has_nothing_to_extract(tmp_path, capsys):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(40))
    assert main(['info', str(path), '--extract', str(tmp_path / 'out')]) == 2
    assert 'is a journal, which has no attachments; leave it out' in capsys.readouterr().err
    assert not (tmp_path / 'out').exists()


def two_headings(k):
    """Return the headings of a TS and of an RS of a ship that yaws."""
    ship_deg = 100.0 + 20.0 * math.sin(k / 30.0)
    return ship_deg + 0.1 * math.sin(3.7 * k), ship_deg + 0.02 * math.sin(2.9 * k)


def table(path, names='time,ts_hdg,rs_hdg,mood', stamp='%Y-%m-%dT%H:%M:%SZ'):
    """Write a csv of two sensors."""
    path.write_text(f'{names}\n' + ''.join(
        f'{datetime(2024, 5, 28, 20) + timedelta(seconds=k):{stamp}},'
        + ','.join(f'{x:.4f}' for x in two_headings(k)) + ',good\n' for k in range(N)))
    return path


def raw(path):
    """Write a log of a gateway of Yacht Devices, whose lines have no date."""
    path.write_text(''.join(
        f'{datetime(2024, 5, 28, 20) + timedelta(seconds=k):%H:%M:%S}.000 R 09F112{source} 01 '
        + round(math.radians(x) * 1e4).to_bytes(2, 'little').hex(' ').upper()
        + ' FF 7F FF 7F FC\n' for k in range(N)
        for source, x in zip(('23', '24'), two_headings(k))))
    return path


def printed(capsys, *arguments):
    """Return what a command prints."""
    capsys.readouterr()
    assert main([*map(str, arguments)]) == 0
    return capsys.readouterr().out


def follow(line, capsys, tmp_path):
    """Run a command line that was printed, with a real parameter file and bag."""
    config = tmp_path / 'NORMS.yaml'
    config.write_text('/**:\n  ros__parameters:\n    norms: {sigma_max_deg: 0.3, '
                      'sigma_ref_max_deg: 0.1}\n')
    program, *words = shlex.split(line.partition(': ')[2])
    assert program == 'heading-intercompare'
    places = {'NORMS.yaml': str(config), 'BAG': str(tmp_path / 'bag')}
    return printed(capsys, *(places.get(word, word) for word in words))


@pytest.mark.parametrize('write, options, streams', [
    (table, [], ['ts_hdg', 'rs_hdg']),
    (lambda path: table(path, 'time,GYRO,POS MV,mood'), ['--ts', 'GYRO', '--rs', 'POS MV'],
     ['GYRO', 'POS MV']),
    (lambda path: table(path, stamp='%H:%M:%S'), ['--date', '2024-05-28'], ['ts_hdg', 'rs_hdg']),
    (raw, ['--date', '2024-05-28'], ['35', '36'])])
def test_info_says_what_streams_there_are_and_what_to_type_next(
        tmp_path, capsys, write, options, streams):
    lines = printed(capsys, 'info', write(tmp_path / 'a file.csv'), *options).splitlines()
    begin = next(at for at, line in enumerate(lines) if line.startswith('stream '))
    rows = {line[:line.index('  ')]: line.split() for line in lines[begin + 1:begin + 3]}
    for name in streams:
        assert rows[name][-6:] == [str(N), '2024-05-28', '20:00:00.000', '2024-05-28',
                                   '20:14:59.000', '1.00']
    *_, judge, make = lines
    assert judge.startswith('to judge it: ') and make.startswith('to make a bag of it: ')
    assert follow(judge, capsys, tmp_path).startswith('VERDICT: COMPLIANT')
    assert follow(make, capsys, tmp_path).endswith(f'bag: {tmp_path / "bag"}\n')
    judge = printed(capsys, 'info', tmp_path / 'bag').splitlines()[-1]
    assert follow(judge, capsys, tmp_path).startswith('VERDICT: COMPLIANT')


def test_info_of_a_single_stream_asks_for_the_file_of_the_other_sensor(tmp_path, capsys):
    log = tmp_path / 'gyro.csv'
    log.write_text('time,heading\n2024-05-28T20:00:00Z,10.0\n2024-05-28T20:00:01Z,10.1\n')
    assert f'analyze {log} OTHER_SENSOR --config NORMS.yaml' in printed(capsys, 'info', log)


def test_a_table_whose_headings_have_no_name_is_refused_with_its_columns(tmp_path, capsys):
    path = table(tmp_path / 'd.csv', 'time,GYRO,POSMV,mood')
    assert refusal(capsys, 'info', path) == (
        f'{path}: is a table, and no column has the name of a heading: choose two with --ts and '
        '--rs from time, GYRO, POSMV, mood')
    assert 'choose two with --ts and --rs' in refusal(
        capsys, 'import', path, '-o', tmp_path / 'bag')


def test_info_of_parquet_of_pairs_shows_the_pairs(tmp_path, capsys):
    pyarrow = pytest.importorskip('pyarrow', reason='pyarrow is not installed')
    parquet = pytest.importorskip('pyarrow.parquet')
    pairs = [two_headings(k) for k in range(N)]
    path = tmp_path / 'pairs.parquet'
    parquet.write_table(pyarrow.table({
        'stamp_ns': (1_700_000_000 + np.arange(N)) * 10 ** 9,
        'ts_deg': [a for a, _ in pairs], 'rs_deg': [b for _, b in pairs]}), path)
    lines = printed(capsys, 'info', path).splitlines()
    assert lines[:2] == ['format: Parquet of pairs', f'pairs: {N}']
    assert follow(lines[-1], capsys, tmp_path).startswith('VERDICT: COMPLIANT')


@pytest.fixture(scope='module')
def written(tmp_path_factory):
    """Return a folder with the files that commands write, and those that a person gives them."""
    folder = tmp_path_factory.mktemp('written')
    names = ['--ts', 'ts_hdg', '--rs', 'rs_hdg', '--quiet']
    source = str(table(folder / 'survey.csv'))
    made = {name: str(folder / name) for name in (
        'verdict.json', 'pairs.csv', 'ens.csv', 'runs.csv', 'book.sqlite', 'history.json',
        'history.csv', 'correction.csv', 'history.html', 'plan.json', 'bag', 'rejudge.json',
        'observed.json', 'card.csv', 'series.csv')}
    assert main(['analyze', source, *names, *NORMS, '--json', made['verdict.json'], '--csv',
                 made['pairs.csv'], '--ensembles', made['ens.csv'], '--runs-csv',
                 made['runs.csv'], '--logbook', made['book.sqlite'], '--card',
                 made['card.csv'], '--corrections', made['series.csv']]) == 0
    assert main(['history', made['book.sqlite'], '--json', made['history.json'], '--csv',
                 made['history.csv'], '--correction', made['correction.csv']]) == 0
    assert main(['plan', *NORMS, '--set', 'risk.slowest_error_s=10', '--json',
                 made['plan.json'], '--quiet']) == 0
    assert main(['import', source, *names, *NORMS, '-o', made['bag']]) == 0
    assert main(['rejudge', made['bag'], '--json', made['rejudge.json'], '--quiet']) == 0
    write_journal(folder / 'trial.journal', some_pairs(400))
    texts = {'table.csv': 'start, stop\n2024-05-28T20:00:00Z,2024-05-28T20:10:00Z\n',
             'out.csv': 'start,end,reason\n2024-05-28T20:01:00Z,2024-05-28T20:02:00Z,helm\n',
             'my.yaml': '/**:\n  ros__parameters:\n    norms: {sigma_max_deg: 0.3}\n',
             'c.xml': "<?xml version='1.0'?>\n<dcc:digitalCalibrationCertificate/>\n",
             'v.json.sig': '-----BEGIN SSH SIGNATURE-----\nU1NIU0lH\n',
             'observed.json': '{\n "schema": "heading_intercompare/observations/1"}\n'}
    for name, text in texts.items():
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize('name, kind, shown', [
    ('verdict.json', 'a verdict', 'VERDICT: COMPLIANT'),
    ('pairs.csv', 'a csv of pairs', f'pairs: {N}'),
    ('pairs.csv.account.json', 'the account of a csv of pairs', ''),
    ('ens.csv', 'a table of ensembles, as ens_hcorr.asc', 'rows: 8'),
    ('runs.csv', 'a table of the runs of a verdict', 'rows: 1'),
    ('card.csv', 'a correction card', 'rows: 8'),
    ('series.csv', 'a table of corrections of ensembles', 'rows: 8'),
    ('book.sqlite', 'a logbook', 'runs: 1'), ('history.json', 'the result of history', ''),
    ('history.csv', 'a table of the runs of logbooks', 'rows: 1'),
    ('correction.csv', 'a table of corrections of the heading', 'rows: 1'),
    ('plan.json', 'the result of plan', ''), ('rejudge.json', 'the result of rejudge', ''),
    ('observed.json', 'the result of observe', ''), ('table.csv', 'a table of runs', 'rows: 1'),
    ('out.csv', 'a table of stretches to take out', 'rows: 1'),
    ('v.json.sig', 'a signature', ''), ('c.xml', 'a Digital Calibration Certificate', ''),
    ('my.yaml', 'a parameter file', '  norms.sigma_max_deg: 0.3'),
    ('bag/metadata.yaml', 'the list of the files of a bag', '')])
def test_info_names_what_a_command_wrote_and_what_to_do_with_it(
        written, tmp_path, capsys, name, kind, shown):
    path = written / name
    out = printed(capsys, 'info', path)
    assert out.startswith(f'format: {kind}') and f'\n{shown}' in out
    use = out.splitlines()[-1].removeprefix('to use it: ')
    assert out.splitlines()[-1].startswith('to use it: ')
    assert f'--extract x: {path} is {kind}' in refusal(capsys, 'info', path, '--extract', 'x')
    if kind != 'a csv of pairs':
        for command in (['analyze', path, *NORMS], ['import', path, '-o', tmp_path / 'bag']):
            assert refusal(capsys, *command).startswith(f'{path}: is {kind}')
    for word in ('analyze {}', 'history {}'):
        if word.format(path) in use:
            follow(f'to use it: {use}', capsys, tmp_path)


@pytest.mark.parametrize('path, kind', [
    ('schema/verdict.schema.json', 'the JSON Schema of verdicts'),
    ('config/scenarios/sea_trial_12h.yaml', 'a scenario'),
    ('config/heading_intercompare.yaml', 'a parameter file')])
def test_info_names_the_files_of_the_package(capsys, path, kind):
    assert printed(capsys, 'info', ROOT / path).startswith(f'format: {kind}\n')


def test_info_names_the_pages_of_the_program(written, tmp_path, capsys):
    pytest.importorskip('jinja2')
    pytest.importorskip('matplotlib')
    from heading_intercompare.report.trial_page import compose_trial_page
    assert main(['report', str(written / 'verdict.json'), '-o', str(tmp_path / 'p.html')]) == 0
    assert main(['history', str(written / 'book.sqlite'), '--html',
                 str(tmp_path / 'h.html')]) == 0
    (tmp_path / 's.html').write_text(compose_trial_page('A voyage', ['one line']), 'utf-8')
    for page in ('p.html', 'h.html', 's.html'):
        assert printed(capsys, 'info', tmp_path / page).startswith(
            'format: a page of this program\n')


def test_no_two_kinds_of_written_files_have_one_name():
    assert len({written.name for written in WRITTEN_FILES}) == len(WRITTEN_FILES)


@pytest.mark.parametrize('write, options, n_figures', [
    (table, [], 2), (lambda path: table(path, 'time,GYRO,POS MV,mood'),
                     ['--ts', 'GYRO', '--rs', 'POS MV'], 2),
    (lambda path: table(path, 'time,ts_hdg,x,mood'), [], 1),
    (raw, ['--date', '2024-05-28', '--ts', '36'], 2)])
def test_a_picture_shows_what_was_read_before_it_is_judged(
        tmp_path, capsys, write, options, n_figures):
    pytest.importorskip('matplotlib')
    picture = tmp_path / 'read.svg'
    out = printed(capsys, 'info', write(tmp_path / 'a.csv'), *options, '--plot', picture)
    assert out.splitlines()[-1] == f'written: {picture}'
    text = picture.read_text('utf-8')
    assert text.count('>time UTC<') == n_figures and f'headings as read: {N} of ' in text


def test_a_picture_of_a_bag_counts_what_is_lost_and_rejected(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    with BagWriter(tmp_path / 'bag') as bag:
        bag.metadata(RECORD, {'version': 'x'})
        for topic in ('/ts/heading', '/rs/heading'):
            bag.add_topic(topic, IMU)
            rows = encode_imu(Headings.of((10 ** 9 + np.arange(N)) * 10 ** 9, np.full(N, 9.0)),
                              'x')
            for k, row in enumerate(rows):
                if topic[1] == 't' or k not in (100, 101):
                    bag.write(topic, row.tobytes(), (10 ** 9 + k) * 10 ** 9, sequence=k + 1)
    picture = tmp_path / 'read.svg'
    printed(capsys, 'info', tmp_path / 'bag', '--plot', picture)
    text = picture.read_text('utf-8')
    assert 'ts/heading - rs/heading: n = ' in text
    assert 'rs/heading: lost.on_the_way' in text and 'not taken: 2' in text


def test_a_picture_that_cannot_be_drawn_is_one_line(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    path = table(tmp_path / 'd.svg')
    journal = tmp_path / 'trial.journal'
    write_journal(journal, some_pairs(400))
    assert 'must end in .png or .pdf or .svg' in refusal(
        capsys, 'info', path, '--plot', tmp_path / 'x.gif')
    assert 'that is the FILE' in refusal(capsys, 'info', path, '--plot', path)
    assert 'is a journal, which has no readings' in refusal(
        capsys, 'info', journal, '--plot', tmp_path / 'x.png')
    assert not [*tmp_path.glob('x.*')]


def test_a_log_without_a_known_heading_is_shown_with_its_first_line(tmp_path, capsys):
    """`analyze` refuses it in the same words; nothing is suggested that cannot work."""
    path = tmp_path / 'own.log'
    path.write_text(''.join(
        f'2024-05-28T20:00:{k:02d}Z {with_checksum("PXYZ,ATT,1.5,1")}\n' for k in range(20)))
    assert main(['info', str(path)]) == 0
    out = capsys.readouterr().out
    assert '$PXYZ,ATT,1.5,1' in out and 'describe another one with --ts-own-sentence' in out
    assert 'not taken: 20 not_heading' in out and 'to judge it' not in out
