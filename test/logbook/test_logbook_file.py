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

"""The file: nothing doubled, nothing lost, and each trouble in one line."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
import math
import os
from pathlib import Path
import signal
import sqlite3
import subprocess
import sys

from logbook.made_up_rows import DAY_NS, make_row, T0_NS
import pytest

from heading_intercompare.logbook.logbook_file import (
    Logbook,
    LogbookBusy,
    LogbookError,
    merge_logbooks,
    VERSION,
)
from heading_intercompare.logbook.run_row import RunRow

HERE = Path(__file__).resolve().parent


@pytest.fixture
def book(tmp_path):
    return Logbook(tmp_path / 'l.sqlite', timeout_s=0.1)


def test_rows_come_back_as_they_were_in_the_order_of_time(book):
    rows = [make_row(day, mean_deg=day / 7.0, bag=None if day else '/bags/ä') for day in range(5)]
    book.write(rows[3:])
    book.write(rows[:3])
    assert book.read() == rows


def test_a_run_that_is_there_is_replaced_and_not_doubled(book):
    book.write([make_row(0, paired=1, bag='/bags/one'), make_row(1)])
    with sqlite3.connect(book.path) as connection:
        before = connection.execute('SELECT id, start_ns FROM runs').fetchall()
    book.write([make_row(0, paired=2)])
    assert book.read() == [make_row(0, paired=2, bag='/bags/one'), make_row(1)]
    with sqlite3.connect(book.path) as connection:
        assert connection.execute('SELECT id, start_ns FROM runs').fetchall() == before


@pytest.mark.parametrize('other', [
    {'ship': 'MV Other'}, {'settings_sha256': 'b' * 64}, {'end_ns': T0_NS + 5},
    {'start_ns': T0_NS + 1}])
def test_another_run_is_added(book, other):
    book.write([make_row(), make_row(**other)])
    assert len(book.read()) == 2


def test_rows_are_chosen_by_time_and_ship(book):
    book.write([make_row(0), make_row(1), make_row(1, ship='MV Other')])
    assert book.read(since_ns=T0_NS + DAY_NS) == [make_row(1), make_row(1, ship='MV Other')]
    assert book.read(ship='MV Other') == [make_row(1, ship='MV Other')]
    assert book.read(ship='MV') == []
    book.write([make_row(2, ship='MV Other/gyro')])
    assert [row.ship for row in book.read(ship='MV Other')] == ['MV Other', 'MV Other/gyro']
    assert [row.ship for row in book.read(ship='MV Other/gyro')] == ['MV Other/gyro']


def test_the_file_names_its_version_and_a_newer_one_is_refused(book):
    book.write([make_row()])
    with sqlite3.connect(book.path) as connection:
        assert connection.execute('PRAGMA user_version').fetchone() == (VERSION,)
        connection.execute(f'PRAGMA user_version = {VERSION + 1}')
    for act in (book.read, lambda: book.write([make_row()])):
        with pytest.raises(LogbookError, match=r'l.sqlite: is a logbook of version 5, .*; '
                           'install that') as found:
            act()
        assert '\n' not in str(found.value)


ADDED = {'installation_offset_deg': 1.5, 'deviation_coefficients_deg': (0.1, 0.2, 1 / 3, 0, -1.0),
         'deviation_covariance_deg2': ((1e-4, 0.0), (0.0, 1e-4)), 'empty_arc_deg': 12.5}


def make_old(path, *rows):
    """Write a logbook of version 1, which lacks the columns of version 2."""
    Logbook(path).write(rows)
    with sqlite3.connect(path) as connection:
        for name in ADDED:
            connection.execute(f'ALTER TABLE runs DROP COLUMN {name}')
        connection.execute('PRAGMA user_version = 1')
        connection.execute('DROP TABLE chain')
    connection.close()


def test_a_column_that_an_old_logbook_lacks_is_unknown_and_not_zero(book):
    make_old(book.path, make_row(0, **ADDED))
    before = Path(book.path).read_bytes()
    assert book.read() == [make_row(0)]
    assert all(getattr(book.read()[0], name) is None for name in ADDED)
    assert Path(book.path).read_bytes() == before


def test_an_old_logbook_is_extended_when_a_row_is_written(book):
    make_old(book.path, make_row(0))
    book.write([make_row(1, **ADDED)])
    assert book.read() == [make_row(0), make_row(1, **ADDED)]
    with sqlite3.connect(book.path) as connection:
        assert connection.execute('PRAGMA user_version').fetchone() == (VERSION,)


def test_an_old_row_about_a_run_does_not_erase_what_a_new_one_knows(book, tmp_path):
    book.write([make_row(0, **ADDED)])
    make_old(tmp_path / 'old', make_row(0, paired=7))
    merge_logbooks(book, [Logbook(tmp_path / 'old')])
    assert book.read() == [make_row(0, paired=7, **ADDED)]
    # A later judgement without a fit replaces the fit: it knows the offset.
    book.write([make_row(0, installation_offset_deg=1.5)])
    assert book.read() == [make_row(0, installation_offset_deg=1.5)]


@pytest.mark.parametrize('cell', ['0.1 0.2', '{"a": 1}', '["x"]', 3.5, '[[1]'])
def test_a_cell_that_is_no_list_of_numbers_is_named(book, cell):
    book.write([make_row(0, **ADDED)])
    with sqlite3.connect(book.path) as connection:
        connection.execute('UPDATE runs SET deviation_coefficients_deg = ?', (cell,))
        connection.execute('DROP TABLE chain')
        connection.execute('PRAGMA user_version = 2')
    with pytest.raises(LogbookError, match='l.sqlite: row 1, column deviation_coefficients_deg '
                       r'\(.*\): must be a JSON list of numbers'):
        book.read()


def forge(book, *commands):
    """Change a logbook by another program."""
    with sqlite3.connect(book.path) as connection:
        for command in commands:
            connection.execute(command)
    connection.close()


COLUMNS = ', '.join(RunRow.columns())


@pytest.mark.parametrize('command, words', [
    ("UPDATE runs SET headline = 'COMPLIANT for years' WHERE id = 2",
     'row 2 was changed after it was written'),
    ('UPDATE runs SET mean_deg = mean_deg + 1e-9 WHERE id = 3', 'row 3 was changed'),
    ('UPDATE runs SET bag = NULL WHERE id = 1', 'row 1 was changed'),
    ('UPDATE runs SET id = 9 WHERE id = 1', 'row 9 was put in by another program'),
    ('DELETE FROM runs WHERE id = 2', 'row 2 was taken out'),
    (f"INSERT INTO runs ({COLUMNS}) SELECT {COLUMNS.replace('ship', chr(39) + 'X' + chr(39), 1)} "
     'FROM runs WHERE id = 1', 'row 4 was put in by another program'),
    ("UPDATE chain SET row_sha256 = 'ab' WHERE entry = 2", 'entry 2 of its chain does not follow'),
    ('DELETE FROM chain WHERE entry = 1', 'entry 2 of its chain does not follow'),
    ('DELETE FROM chain WHERE entry = 3', 'row 3 was put in by another program'),
    ('DROP TABLE chain', 'l.sqlite: the chain of its rows was taken out'),
    ("CREATE TRIGGER t AFTER INSERT ON runs BEGIN UPDATE runs SET reason = 'x'; END",
     "l.sqlite: has the trigger 't', which changes rows as they are written")])
def test_a_row_that_another_program_changed_is_named(book, command, words):
    """Before, one word changed in a row was the outcome of the run ever after."""
    book.write([make_row(day, bag='trial') for day in range(3)])
    assert len(book.read()) == 3
    forge(book, command)
    for read in (book.read, lambda: book.read(ship='no ship')):
        with pytest.raises(LogbookError, match=words):
            read()


@pytest.mark.parametrize('column, cell', [
    ('headline', "x'434f4d504c49414e54'"), ('mean_deg', '0.1'),
    ('n', '86400.5'), ('bag', "'%s'"), ('bag', "'\", \"conditions\": \"'"), ('sd_deg', '9e999'),
    ('skew_s', '0.0'), ('empty_arc_deg', "x'00'")])
@pytest.mark.parametrize('many', [1, 2500])
def test_a_cell_of_any_kind_that_was_changed_is_named(book, column, cell, many):
    """Rows are hashed a thousand at a time: a text, a sign or a kind of cell is no other one."""
    book.write([make_row(day, mean_deg=0.0, **ADDED) for day in range(many)])
    forge(book, f'UPDATE runs SET {column} = {cell} WHERE id = {many}')
    with pytest.raises(LogbookError, match=f'row {many} was changed after it was written'):
        book.read()


def test_rows_of_all_kinds_of_cells_fit_the_chain_together(book):
    rows = [make_row(0, bag='100 % "of" ä\\'), make_row(1, **ADDED), make_row(2, skew_s=math.inf),
            make_row(3, skew_s=-0.0, mean_deg=None), make_row(4, skew_s=1e300, bag='')]
    book.write(rows)
    assert book.read() == rows
    forge(book, 'ALTER TABLE runs ADD COLUMN "later %s" TEXT')
    assert book.read() == rows


def test_the_next_run_does_not_take_the_place_of_a_row_that_was_taken_out(book):
    book.write([make_row(0), make_row(1)])
    forge(book, 'DELETE FROM runs WHERE id = 2')
    book.write([make_row(2)])
    with pytest.raises(LogbookError, match='row 2 was taken out'):
        book.read()


def test_every_write_goes_into_the_chain_and_the_same_row_only_once(book, tmp_path):
    assert book.write([]) is None and book.read_with_head()[1].entry == 0
    book.write([make_row(0), make_row(1)])
    head = book.read_with_head()[1]
    book.write([make_row(1)])
    merge_logbooks(book, [book])
    assert book.read_with_head()[1] == head and head.entry == 2
    book.write([make_row(1, paired=7)])
    assert book.read_with_head()[1].entry == 3 and len(book.read()) == 2
    other = Logbook(tmp_path / 'other')
    other.write([make_row(0)])
    other.write([make_row(1)])
    assert other.read_with_head()[1] == head


def test_whoever_noted_the_newest_hash_sees_a_chain_that_was_made_anew(book, tmp_path):
    book.write([make_row(0, headline='COMPLIANT for an hour'), make_row(1)])
    noted = book.read_with_head()[1]
    forged = Logbook(tmp_path / 'forged')
    forged.write([make_row(0, headline='COMPLIANT for years'), make_row(1)])
    assert forged.read() and forged.read_with_head()[1].sha256 != noted.sha256


def test_a_chain_begins_with_the_rows_of_an_old_logbook(book):
    make_old(book.path, make_row(0), make_row(1))
    assert book.read_with_head()[1] is None
    book.write([make_row(2)])
    assert book.read_with_head()[1].entry == 3
    forge(book, 'UPDATE runs SET n = 5 WHERE id = 1')
    with pytest.raises(LogbookError, match='row 1 was changed'):
        book.read()


def test_another_file_is_refused_and_left_as_it_is(book):
    Path(book.path).write_text('not a database, but long enough to be taken for one\n' * 9)
    before = Path(book.path).read_bytes()
    for act in (book.read, book.check):
        with pytest.raises(LogbookError, match='is not a logbook of heading_intercompare'):
            act()
    assert Path(book.path).read_bytes() == before
    Path(book.path).unlink()
    with sqlite3.connect(book.path) as connection:
        connection.execute('CREATE TABLE mine (x)')
    connection.close()
    for act in (book.read, book.check):
        with pytest.raises(LogbookError, match='is not a logbook of heading_intercompare'):
            act()


def test_a_logbook_that_is_not_there_is_not_made_by_reading(book):
    with pytest.raises(LogbookError, match='there is no such logbook'):
        book.read()
    assert not Path(book.path).exists()


def test_a_folder_that_is_not_there_is_named(tmp_path):
    with pytest.raises(LogbookError, match='no/l.sqlite: cannot be opened; is there a folder'):
        Logbook(tmp_path / 'no' / 'l.sqlite').write([])


def test_a_locked_logbook_says_so_and_is_written_afterwards(book):
    book.write([])
    other = sqlite3.connect(book.path, isolation_level=None)
    other.execute('BEGIN EXCLUSIVE')
    for act in (book.read, lambda: book.write([make_row()])):
        with pytest.raises(LogbookBusy, match='another process is writing'):
            act()
    other.execute('COMMIT')
    other.close()
    book.write([make_row()])
    assert book.read() == [make_row()]


def test_several_writers_lose_nothing(book):
    patient = Logbook(book.path, timeout_s=60.0)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda day: patient.write([make_row(day)]), range(40)))
    assert [row.start_ns for row in book.read()] == [T0_NS + day * DAY_NS for day in range(40)]


@pytest.mark.process
def test_a_writer_that_is_killed_leaves_whole_transactions(book):
    """A process writes pairs of rows without end until kill -9; no pair is ever halved."""
    code = ('import sys\n'
            'from heading_intercompare.logbook.logbook_file import Logbook\n'
            'from made_up_rows import make_row\n'
            'day = int(sys.argv[2])\n'
            'while True:\n'
            '    Logbook(sys.argv[1]).write([make_row(day), make_row(day, ship="other")])\n'
            '    print(day, flush=True)\n'
            '    day += 1\n')
    day = 0
    for _ in range(5):
        with subprocess.Popen([sys.executable, '-c', code, book.path, str(day)],
                              stdout=subprocess.PIPE, text=True,
                              env={**os.environ, 'PYTHONPATH': os.pathsep.join(
                                  map(str, (HERE, HERE.parents[1])))}) as writer:
            said = [int(writer.stdout.readline()) for _ in range(3)]
            writer.send_signal(signal.SIGKILL)
            said += [int(line) for line in writer.stdout.read().split()]
        rows = book.read()
        days = [{row.start_ns for row in rows if row.ship == ship}
                for ship in ('MV Example', 'other')]
        assert days[0] == days[1] >= {T0_NS + d * DAY_NS for d in range(said[-1] + 1)}
        day = said[-1] + 1


@pytest.mark.skipif(os.geteuid() == 0, reason='root may write everywhere')
def test_a_folder_that_is_read_only_is_named(book, tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(LogbookError, match='cannot be opened'):
            book.write([make_row()])
    finally:
        tmp_path.chmod(0o700)


def test_a_full_disk_is_one_line_and_leaves_the_rows_that_were_there(tmp_path):
    """Pages are refused above max_page_count just as it does when the disk is full."""
    class Small(Logbook):
        def _connect(self, write):
            connection = super()._connect(write)
            connection.execute('PRAGMA max_page_count = 6')
            return connection

    book = Small(tmp_path / 'l.sqlite')
    book.write([make_row()])
    with pytest.raises(LogbookError, match='l.sqlite: database or disk is full'):
        book.write([make_row(day) for day in range(1, 200)])
    assert book.read() == [make_row()]


def test_logbooks_merge_and_merging_again_changes_nothing(tmp_path):
    fleet, one, two = (Logbook(tmp_path / name) for name in ('f', 'a', 'b'))
    one.write([make_row(day, ship='A') for day in range(3)])
    two.write([make_row(day, ship='B') for day in range(2)])
    assert merge_logbooks(fleet, [one, two]) == 5
    rows = fleet.read()
    assert merge_logbooks(fleet, [two, one]) == 5
    assert fleet.read() == rows and len(rows) == 5


def test_a_source_that_cannot_be_read_stops_the_merge_before_it_writes(tmp_path):
    fleet, one = Logbook(tmp_path / 'f'), Logbook(tmp_path / 'a')
    one.write([make_row()])
    with pytest.raises(LogbookError, match='no such logbook'):
        merge_logbooks(fleet, [one, Logbook(tmp_path / 'b')])
    assert not Path(fleet.path).exists()
