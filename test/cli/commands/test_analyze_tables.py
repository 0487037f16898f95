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

"""Tables of two sensors as people have them, from the command line."""

from __future__ import annotations

from datetime import datetime, timedelta
import math

from command_line import analyze_json, NORMS, refusal
import pytest

from heading_intercompare.cli import main

START = datetime(2024, 5, 28, 20)
N = 700


def table(path, names, stamp, *, columns=('TS', 'RS'), scale=1.0, start=START):
    """Write a csv of two sensors that are 0.1 deg apart on a ship that yaws."""
    rows = [','.join((names, *columns))]
    for k in range(N):
        heading_deg = 100.0 + 20.0 * math.sin(k / 20.0) + 0.05 * math.sin(3.7 * k)
        stamps = (start + timedelta(seconds=k)).strftime(stamp)
        rows.append(f'{stamps},{(heading_deg + 0.1) * scale:.6f},'
                    f'{(heading_deg - 0.05 * math.sin(2.9 * k)) * scale:.6f}')
    path.write_text('\n'.join(rows) + '\n')
    return path


@pytest.mark.parametrize('names, stamp, options', [
    ('Date,Time', '%m/%d/%Y,%H:%M:%S', []), ('time', '%Y/%m/%d %H:%M:%S', []),
    ('uhr', '%d.%m.%Y %H:%M:%S', ['--time-column', 'uhr']),
    ('time', '%H:%M:%S', ['--date', '2024-05-28']),
    ('time', '05/06/2024 %H:%M:%S', ['--stamp-format', 'dmy'])])
def test_columns_of_any_name_and_stamp_are_judged(tmp_path, capsys, names, stamp, options):
    path = table(tmp_path / 'd.csv', names, stamp)
    verdict, _ = analyze_json(capsys, path, '--ts', 'TS', '--rs', 'RS', *options)
    assert verdict['runs'][0]['n'] == N


def test_the_stated_unit_holds_for_columns_of_any_name(tmp_path, capsys):
    path = table(tmp_path / 'd.csv', 'time', '%Y-%m-%d %H:%M:%S', scale=math.pi / 180.0)
    verdict, _ = analyze_json(capsys, path, '--ts', 'TS', '--rs', 'RS', '--set', 'ts_unit=rad',
                              '--set', 'rs_unit=rad')
    assert verdict['runs'][0]['mean_deg'] == pytest.approx(0.1, abs=0.01)


def test_two_tables_are_the_logs_of_two_sensors(tmp_path, capsys):
    paths = [table(tmp_path / name, 'time', '%m/%d/%Y %H:%M:%S') for name in ('a.csv', 'b.csv')]
    verdict, _ = analyze_json(capsys, *paths, '--ts-talker', 'TS', '--rs-talker', 'RS')
    assert verdict['runs'][0]['n'] == N


def test_two_tables_of_one_heading_each_need_no_name(tmp_path, capsys):
    paths = [tmp_path / 'ts.csv', tmp_path / 'rs.csv']
    for path, column in zip(paths, (1, 2)):
        rows = table(path, 'Date,Time', '%d.%m.%Y,%H:%M:%S').read_text().splitlines()[1:]
        cells = [row.split(',') for row in rows]
        path.write_text('Date;Time;heading_deg\n' + ''.join(
            f'{row[0]};{row[1]};{row[1 + column].replace(".", ",")}\n' for row in cells))
    verdict, _ = analyze_json(capsys, *paths)
    assert verdict['runs'][0]['n'] == N


@pytest.mark.parametrize('options', [[], ['--date', '2024-05-28']])
@pytest.mark.parametrize('pattern', ['', '*.csv'])
def test_the_files_of_a_folder_have_the_dates_in_their_names(tmp_path, capsys, pattern, options):
    folder = tmp_path / 'trial'
    folder.mkdir()
    for day in (1, 2):
        start = START + timedelta(days=day)
        table(folder / f'{start:%Y-%m-%d}.csv', 'time', '%H:%M:%S', start=start)
    verdict, notes = analyze_json(capsys, folder / pattern, '--ts', 'TS', '--rs', 'RS', *options)
    assert [run['n'] for run in verdict['runs']] == [N, N]
    assert [note.rpartition('/')[2] for note in notes] == [
        f'2024-05-{day}.csv: date by the name of the file' for day in (29, 30)]


def test_a_table_without_the_names_asked_for_is_refused(tmp_path, capsys):
    path = table(tmp_path / 'd.csv', 'time', '%Y-%m-%d %H:%M:%S', columns=('GYRO', 'POSMV'))
    assert '--ts and --rs' in refusal(capsys, 'analyze', path, *NORMS)
    assert "no stream 'POS'" in refusal(
        capsys, 'analyze', path, '--ts', 'GYRO', '--rs', 'POS', *NORMS)


def test_an_option_of_one_log_is_refused_for_a_table(tmp_path, capsys):
    path = table(tmp_path / 'd.csv', 'time', '%H:%M:%S')
    assert refusal(capsys, 'analyze', path, '--ts', 'TS', '--rs', 'RS', '--ts-date', '2024-05-28',
                   *NORMS).startswith('--ts-date 2024-05-28: is for logs')


@pytest.mark.parametrize('first_s, words', [
    (3_800_000_000, 'is in the future'), (700_000_000, 'is before 2000'), (1_700_000_000, '')])
def test_stamps_far_from_any_trial_are_said_of_tables_as_of_logs(
        tmp_path, capsys, first_s, words):
    path = tmp_path / 'table.csv'
    path.write_text('time_s,gyro_heading,ins_heading\n' + ''.join(
        f'{first_s + k},{90 + k % 7 / 10},{90 + k % 5 / 10}\n' for k in range(900)))
    assert main(['analyze', str(path), '--ts', 'gyro_heading', '--rs', 'ins_heading', '--quiet',
                 *NORMS]) == 0
    notes = [line for line in capsys.readouterr().err.splitlines()
             if 'the clock that gave' in line]
    assert len(notes) == bool(words) and all(words in note for note in notes)
