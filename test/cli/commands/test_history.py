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

"""The command history: what it lists, writes, merges and refuses."""

from __future__ import annotations

import csv
from dataclasses import replace
import json
import os
from pathlib import Path
import re
import sqlite3

from command_line import refusal
import numpy as np
import pytest

from heading_intercompare.app import history_table
from heading_intercompare.cli import main
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.logbook.run_row import RunRow
from heading_intercompare.report.figures.drawing import SVG_STYLE

DAY_NS = 86_400_000_000_000
T0_NS = 20_000 * DAY_NS
VOID_RUN = {'outcome': 'indeterminate', 'reason': 'void.clocks', 'validity_effect': 'void',
            'headline': 'INDETERMINATE, VOID', 'conditions': 'clocks=void'}


def rows_of(ship, days, shift_at):
    """Return a run a day of a ship whose mean moves by 0.5 deg on a day."""
    rng = np.random.default_rng(len(ship))
    return [RunRow(
        ship=ship, start_ns=T0_NS + day * DAY_NS, end_ns=T0_NS + (day + 1) * DAY_NS - 1,
        n=86400, outcome='compliant', reason='r', headline='COMPLIANT', validity_effect='holds',
        conditions='', mean_deg=0.1 + 0.01 * rng.standard_normal() + 0.5 * (day >= shift_at),
        mean_u_deg=0.002, sd_deg=0.2 * float(np.exp(0.03 * rng.standard_normal())), nu=400.0,
        lower_bound_deg2=0.03, upper_bound_deg2=0.05, acceptance_limit_deg2=0.09,
        rejection_limit_deg2=0.1, skew_s=None, paired=86400, ts_received=86400, ts_unpaired=0,
        ts_rejected=0, rs_received=86400, rs_unused=0, rs_rejected=0, source='live', bag=None,
        settings_sha256='ab' * 32, rule_version=2, software_version='0.1.0')
        for day in range(days)]


@pytest.fixture
def books(tmp_path):
    """Return two logbooks: one of a ship that changes on day 30, one of a ship that does not."""
    for name, days, shift_at in (('A', 40, 30), ('BB', 35, 99)):
        Logbook(tmp_path / f'{name}.sqlite').write(rows_of(f'MV {name}', days, shift_at))
    return [str(tmp_path / f'{name}.sqlite') for name in ('A', 'BB')]


def test_it_lists_the_runs_and_says_since_when_the_sensor_differs(books, capsys):
    assert main(['history', books[0]]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == 'MV A, settings abababab: 40 runs'
    assert lines[2].split() == ['2024-10-04', '00:00', '24.00', '86400', '0.0935', '0.1990',
                                'COMPLIANT']
    assert lines[41].startswith('  2024-11-12 00:00') and lines[41].endswith(
        'COMPLIANT; mean outside the limits')
    assert 'it left its limits at 2024-11-03 00:00 UTC, 10 of 20 runs are outside' in lines[42]
    assert 'it differs since 2024-11-03 00:00 UTC' in lines[42]
    assert lines[43].endswith('has stayed within its limits')


def test_several_logbooks_are_one_and_a_ship_can_be_chosen(books, capsys):
    assert main(['history', *books, '--check']) == 1
    assert capsys.readouterr().out.splitlines() == [
        'ship                        runs  newest, UTC       outcome',
        'MV A, settings abababab       40  2024-11-12 23:59  COMPLIANT; mean differs since '
        '2024-11-03 00:00 UTC by +0.4975 deg; mean outside the limits',
        'MV BB, settings abababab      35  2024-11-07 23:59  COMPLIANT',
        '1 of 2 differ; --ship NAME lists the runs']
    assert main(['history', *books, '--ship', 'MV BB', '--check']) == 0
    assert 'MV A' not in capsys.readouterr().out
    assert main(['history', *books, '--ship', 'MV CCC']) == 0
    assert capsys.readouterr().out == 'no runs\n'


@pytest.mark.parametrize('more, words', [
    ({'outcome': 'non_compliant', 'headline': 'NON-COMPLIANT'}, 'NON-COMPLIANT'),
    ({'outcome': 'non_compliant', 'headline': 'NON-COMPLIANT, DOUBTFUL: why',
      'validity_effect': 'doubtful', 'conditions': 'losses=doubtful'},
     'NON-COMPLIANT, DOUBTFUL: losses=doubtful'),
    (VOID_RUN, 'INDETERMINATE, VOID: clocks=void')])
def test_an_outcome_has_the_words_of_the_page(tmp_path, capsys, more, words):
    """Before, the list said NON_COMPLIANT, and the page NON-COMPLIANT."""
    book, row = str(tmp_path / 'l'), replace(*rows_of('MV A', 1, 9), **more)
    Logbook(book).write([row, replace(row, ship='MV B')])
    for options, lines in ([], 2), (['--ship', 'MV A'], 1):
        assert main(['history', book, *options]) == 0
        said = re.findall(r'  ([A-Z]{3}.*?)(?:; .*)?$', capsys.readouterr().out, re.MULTILINE)
        assert said == [words] * lines


def test_the_json_tells_rows_and_chain_of_one_instant(books, capsys, monkeypatch):
    """A node writes a run after the logbook was read: neither its row nor its entry is told."""
    read = Logbook._read

    def read_before_a_write(book, *choice):
        contents = read(book, *choice)
        book.write(rows_of('MV C', 1, 9))
        return contents

    monkeypatch.setattr(Logbook, '_read', read_before_a_write)
    assert main(['history', *books, '--json', '-']) == 0
    told = json.loads(capsys.readouterr().out)
    assert [told['chains'][book]['entry'] for book in books] == [40, 35]
    assert sorted(len(history['points']) for history in told['histories']) == [35, 40]


def test_since_shortens_the_list_but_not_the_chart(books, capsys):
    assert main(['history', books[0], '--since', '2024-11-10']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + 3 + 2 and 'it differs since 2024-11-03' in lines[-2]


def test_json_and_csv_hold_runs_and_limits(books, tmp_path, capsys):
    table = tmp_path / 'h.csv'
    assert main(['history', books[0], '--json', '-', '--csv', str(table)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['schema'] == 'heading_intercompare/history/1'
    assert told['one_in'] == pytest.approx(780.3, abs=0.1)
    assert told['chains'] == {books[0]: Logbook(books[0]).read_with_head()[1]._asdict()}
    history, = told['histories']
    assert history['trends'][0]['differs_since_ns'] == T0_NS + 30 * DAY_NS
    with table.open(newline='', encoding='utf-8') as file:
        found = list(csv.DictReader(file))
    assert len(found) == len(history['points']) == 40
    for row, point in zip(found, history['points']):
        assert float(row['mean_deg']) == point['row']['mean_deg']
        assert float(row['mean_high_deg']) == point['mean_high_deg']
        assert row['outside'] == ' '.join(point['outside'])


def write_offsets(path, *rows):
    """Write a run a day with a mean of 0.1 and an installation offset of 1.5."""
    Logbook(path).write([replace(
        row, mean_deg=0.1, mean_u_deg=0.01, nu=10.0, **{'installation_offset_deg': 1.5, **more})
        for row, more in zip(rows_of('MV A', len(rows), 99), rows)])


def test_a_correction_is_what_to_add_to_the_tested_heading(tmp_path, capsys):
    """TS - RS is 1.6 as measured, so the TS needs -1.6; UHDAS writes TS - RS and subtracts it."""
    book, table, angles = (str(tmp_path / name) for name in ('l', 'c.csv', 'hcorr.ang'))
    write_offsets(book, {}, VOID_RUN, {},
                  {'installation_offset_deg': None})
    assert main(['history', book, '--correction', table]) == 0
    assert capsys.readouterr().err == (
        f'note: --correction {table}: 2 runs; no correction from 2 runs: 1 void, '
        '1 without the installation offset, from an old logbook\n')
    with open(table, newline='', encoding='utf-8') as file:
        rows = list(csv.DictReader(file))
    assert [row['start_utc'][:10] for row in rows] == ['2024-10-04', '2024-10-06']
    assert {(row['add_to_ts_deg'], row['add_to_ts_low_deg'], row['add_to_ts_high_deg'], row['n'],
             row['add_to_ts_a_deg']) for row in rows} == {
        ('-1.6000', '-1.6223', '-1.5777', '86400', '')}
    assert main(['history', book, '--correction', angles]) == 0
    assert Path(angles).read_text('ascii').splitlines() == [
        '277.0000000 1.6000', '278.0000000 1.6000', '279.0000000 1.6000', '280.0000000 1.6000']


def test_a_correction_follows_ship_and_since(books, tmp_path, capsys):
    book, table = str(tmp_path / 'l'), tmp_path / 'c.csv'
    write_offsets(book, *[{}] * 5)
    assert main(['history', book, '--since', '2024-10-07', '--correction', str(table)]) == 0
    assert len(table.read_text('utf-8').splitlines()) == 3
    assert main(['history', book, '--ship', 'MV B', '--correction', str(table)]) == 0
    assert len(table.read_text('utf-8').splitlines()) == 1


def test_angles_of_several_sensors_are_refused(tmp_path, capsys):
    book = str(tmp_path / 'l')
    write_offsets(book, {}, {'ship': 'MV B'})
    assert 'choose the sensor with --ship' in refusal(
        capsys, 'history', book, '--correction', tmp_path / 'c.ang')
    assert not (tmp_path / 'c.ang').exists()


def test_a_csv_holds_several_figures_of_a_run_as_json(tmp_path, capsys):
    row, = rows_of('MV A', 1, 9)
    row = replace(row, deviation_coefficients_deg=(0.1, 0.2, 0.3, 0.0, 1 / 3))
    Logbook(tmp_path / 'l').write([row])
    assert main(['history', str(tmp_path / 'l'), '--csv', '-']) == 0
    cells, = csv.DictReader(capsys.readouterr().out.splitlines())
    assert json.loads(cells['deviation_coefficients_deg']) == [0.1, 0.2, 0.3, 0.0, 1 / 3]
    assert cells['installation_offset_deg'] == ''


def test_parquet_holds_every_cell_with_its_type_and_unit(books, tmp_path, capsys):
    pq = pytest.importorskip('pyarrow.parquet', reason='pyarrow is not installed')
    row, = rows_of('MV A', 1, 9)
    covariance = tuple(tuple(1e-4 * (i == j) for j in range(5)) for i in range(5))
    row = replace(row, bag='/bags/ä', deviation_coefficients_deg=(0.1, 0.2, 1 / 3, 0.0, -1.0),
                  start_ns=row.start_ns + 1, deviation_covariance_deg2=covariance, sd_deg=None)
    Logbook(books[0]).write([row])
    for name in ('runs.parquet', 'runs.csv'):
        assert main(['history', *books, '-o', str(tmp_path / name)]) == 0
    capsys.readouterr()
    table = pq.read_table(tmp_path / 'runs.parquet')
    with open(tmp_path / 'runs.csv', newline='', encoding='utf-8') as file:
        lines = [*csv.DictReader(file)]
    assert table.column_names == [*lines[0]] and table.num_rows == len(lines) == 76
    for name in table.column_names:
        kind, column = str(table.schema.field(name).type), table[name]
        cells = (column.cast('int64') if 'timestamp' in kind else column).to_pylist()
        assert [('' if cell is None else cell if kind == 'string' else json.dumps(cell))
                for cell in cells] == [line[name] for line in lines], name
    fields = {name: table.schema.field(name) for name in table.column_names}
    assert {name: str(fields[name].type) for name in (
        'start_ns', 'n', 'sd_deg', 'outcome', 'deviation_coefficients_deg', 'sd_low_deg')} == {
            'start_ns': 'timestamp[ns, tz=UTC]', 'n': 'int64', 'sd_deg': 'double',
            'outcome': 'string', 'deviation_coefficients_deg': 'list<element: double>',
            'sd_low_deg': 'double'}
    assert fields['sd_deg'].metadata == {b'unit': b'deg', b'description': b'standard deviation'}
    assert fields['deviation_covariance_deg2'].metadata[b'unit'] == 'deg²'.encode()
    assert fields['sd_deg'].nullable and not fields['n'].nullable
    chains = json.loads(table.schema.metadata[b'chains'])
    assert chains == {book: Logbook(book).read_head()._asdict() for book in books}


def test_a_table_needs_its_library_and_follows_since(books, tmp_path, capsys, monkeypatch):
    tables = [str(tmp_path / name) for name in ('one.csv', 'two.csv')]
    assert main(['history', books[0], '--since', '2024-11-10', '-o', tables[0],
                 '--csv', tables[1]]) == 0
    one, two = (Path(path).read_text('utf-8') for path in tables)
    assert one == two and len(one.splitlines()) == 4
    monkeypatch.setattr(history_table, 'find_spec', lambda name: None)
    assert 'writing Parquet needs pyarrow: install heading_intercompare[parquet]' in refusal(
        capsys, 'history', books[0], '-o', tmp_path / 'runs.parquet')
    assert not (tmp_path / 'runs.parquet').exists()


def test_parquet_of_no_run_has_its_columns(books, tmp_path):
    pq = pytest.importorskip('pyarrow.parquet', reason='pyarrow is not installed')
    path = tmp_path / 'runs.parquet'
    assert main(['history', books[0], '--ship', 'none', '-o', str(path)]) == 0
    assert pq.read_table(path).num_rows == 0 and 'mean_deg' in pq.read_schema(path).names


def test_a_page_shows_both_charts(books, tmp_path, capsys):
    pytest.importorskip('matplotlib')
    pytest.importorskip('jinja2')
    page = tmp_path / 'h.html'
    assert main(['history', *books, '--html', str(page)]) == 0
    text = page.read_text('utf-8')
    assert text.count('<svg') == 6 and SVG_STYLE in text and 'Mean difference, 40 runs' in text
    assert 'mean difference [deg]' in text and 'outside the limits' in text
    assert 'It' not in text.partition('<p>')[2][:3]


def test_a_page_has_a_row_per_day_with_the_correction(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    pytest.importorskip('jinja2')
    book, page = str(tmp_path / 'l'), tmp_path / 'h.html'
    write_offsets(book, {}, VOID_RUN, {'installation_offset_deg': None},
                  {'validity_effect': 'doubtful', 'conditions': 'losses=doubtful'})
    assert main(['history', book, '--html', str(page)]) == 0
    text = page.read_text('utf-8')
    assert 'Worst verdict of each day, 4 days' in text and 'Mean difference, 3 runs' in text
    for words in ('compliant: 3', 'indeterminate: 0', 'void: 1', 'non-compliant: 0'):
        assert f'>{words}<' in text
    rows = [re.findall('<td>(.*?)</td>', line)[:8] for line in text.splitlines()
            if line.startswith('<tr><td>')]
    assert [(row[0], *row[3:6], row[7]) for row in rows] == [
        ('2024-10-04', 'COMPLIANT', '86400', '0.100 ± 0.010', '-1.600 ± 0.010'),
        ('2024-10-05', 'INDETERMINATE, VOID', '0', '-', '-'),
        ('2024-10-06', 'COMPLIANT', '86400', '0.100 ± 0.010', '-'),
        ('2024-10-07', 'COMPLIANT, DOUBTFUL', '86400', '0.100 ± 0.010', '-1.600 ± 0.010')]
    assert main(['history', book, '--html', str(page), '--since', '2024-10-07']) == 0
    assert page.read_text('utf-8').count('<tr><td>') == 1


def test_the_page_of_a_fleet_lists_all_and_draws_the_worst(tmp_path):
    """100 ships with all their figures were 100 times the page of one."""
    pytest.importorskip('matplotlib')
    book, page = str(tmp_path / 'fleet.sqlite'), tmp_path / 'h.html'
    for ship in range(23):
        Logbook(book).write(rows_of(f'MV {ship:02}', 24, 21 if ship == 17 else 99))
    assert main(['history', book, '--html', str(page)]) == 0
    text = page.read_text('utf-8')
    names = re.findall(r'(MV \d\d), settings \w+(?:</a>)?</td>', text)
    assert len(names) == 23 and names[0] == 'MV 17'
    assert text.count('<a href="#h') == text.count('<h2 id="h') == 20
    assert text.count('<svg') == 3 * 20
    assert '#h0">MV 17' in text
    assert re.search(r'mean differs since 2024-10-2\d 00:00 UTC by \+0\.[45]\d', text)


def test_the_sensors_of_a_ship_are_listed_and_shown_together(tmp_path, capsys):
    """Before, --ship with the name of the ship listed none of them."""
    book = str(tmp_path / 'fleet.sqlite')
    for name, shift_at in (('MV A/gyro1', 99), ('MV A/gyro2', 30), ('MV AB/gyro1', 99)):
        Logbook(book).write(rows_of(name, 40, shift_at))
    assert main(['history', book, '--ship', 'MV A']) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if line[0] != ' ']
    assert said == [f'MV A/{name}, settings abababab: 40 runs' for name in ('gyro2', 'gyro1')]
    assert main(['history', book, '--ship', 'MV A/gyro2', '--check']) == 1
    assert 'gyro1' not in capsys.readouterr().out
    pytest.importorskip('matplotlib')
    pytest.importorskip('jinja2')
    page = tmp_path / 'h.html'
    assert main(['history', book, '--html', str(page)]) == 0
    text = page.read_text('utf-8')
    # Two charts of each sensor with its days, and two of the ship with two of them.
    assert text.count('<svg') == 3 * 3 + 2
    assert text.count('<h2>MV A: 2 sensors</h2>') == 1 and 'MV AB: ' not in text
    assert 'Mean difference of each sensor, 80 runs' in text
    assert 'gyro2, settings abababab' in text


def test_a_fleet_is_merged_and_merging_again_changes_nothing(books, tmp_path, capsys):
    fleet = tmp_path / 'fleet.sqlite'
    for _ in range(2):
        assert main(['history', '--merge-into', str(fleet), *books]) == 0
        assert capsys.readouterr().out == f'75 runs of 2 logbooks are in {fleet}\n'
        assert len(Logbook(fleet).read()) == 75
    assert main(['history', *books]) == 0
    apart = capsys.readouterr().out
    assert main(['history', str(fleet)]) == 0
    assert capsys.readouterr().out == apart


@pytest.mark.parametrize('options, why', [
    (['--baseline', '7'], '--baseline 7: must be at least 8'),
    (['--one-in', '1'], '--one-in 1: must be from 2 to 1000000'),
    (['--one-in', 'nan'], '--one-in nan: must be from 2'),
    (['--since', 'yesterday'], '--since yesterday: must be a time, UTC'),
    (['--json', '-', '--csv', '-'], 'only one can be on standard output'),
    (['--correction', 'c.txt'], '--correction c.txt: must end with .csv or .ang'),
    (['--html', 'h.pdf'], '--html h.pdf: must end with .html')])
def test_a_wrong_option_is_refused_in_one_line(books, capsys, options, why):
    assert why in refusal(capsys, 'history', books[0], *options)


def test_a_logbook_is_not_overwritten_by_a_table(books, capsys):
    link = f'{books[0]}.csv'
    os.symlink(books[0], link)
    for option, path in ('--csv', books[0]), ('-o', link):
        assert 'that is a LOGBOOK' in refusal(capsys, 'history', books[0], option, path)
    assert len(Logbook(books[0]).read()) == 40


def test_a_logbook_that_is_none_or_of_a_newer_version_is_refused(books, tmp_path, capsys):
    assert 'there is no such logbook' in refusal(capsys, 'history', tmp_path / 'no')
    Path(tmp_path / 'text').write_text('not a logbook ' * 50)
    assert 'is not a logbook' in refusal(capsys, 'history', tmp_path / 'text')
    with sqlite3.connect(books[0]) as connection:
        connection.execute('PRAGMA user_version = 9')
    assert 'a newer heading_intercompare wrote it' in refusal(capsys, 'history', books[0])


def test_it_says_whether_a_sensor_differs_after_a_service(books, capsys):
    at = str(T0_NS + 30 * DAY_NS)
    assert main(['history', books[0], '--service', at, '--check']) == 1
    lines = [line for line in capsys.readouterr().out.splitlines() if 'service: ' in line]
    assert lines[0].startswith('  service: the mean changed by +0.5') and 'it differs' in lines[0]
    assert lines[1].startswith('  service: the standard deviation changed by the factor ')
    assert main(['history', books[1], '--service', at, '--check']) == 0
    assert capsys.readouterr().out.count('no change is shown') == 2
    assert main(['history', books[0], '--service', at, '--json', '-']) == 0
    found = json.loads(capsys.readouterr().out)['histories'][0]['service']
    assert [one['figure'] for one in found] == ['mean', 'sd'] and found[0]['before'] == 30
    assert '--service soon: must be a time' in refusal(
        capsys, 'history', books[0], '--service', 'soon')
