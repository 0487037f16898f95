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

"""The record of a run comes back whole, and nobody changes it unseen."""

from __future__ import annotations

import sqlite3
import zlib

from logbook.made_up_rows import make_row
import numpy as np
import pytest
from trials import judge_headings

from heading_intercompare.core.conditions.shared_readings import Fingerprint
from heading_intercompare.core.typed_reader import make_plain, VerdictError
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.logbook.logbook_file import Logbook, LogbookError, merge_logbooks
from heading_intercompare.logbook.run_record import decode_record
from heading_intercompare.logbook.run_row import make_rows

S = 1_000_000_000


def judge(rng, n=2000, **more):
    rs_deg = 90.0 + 0.01 * rng.standard_normal(n)
    return judge_headings(90.05 + 0.1 * rng.standard_normal(n), rs_deg,
                          (1_700_000_000 + np.arange(n)) * S, **{
                              'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}, **more})


@pytest.fixture
def book(tmp_path):
    return Logbook(tmp_path / 'l.sqlite')


def test_a_record_has_the_run_its_settings_and_its_evidence_to_the_bit(rng, book):
    verdict = judge(rng, **{'runs.stabilization_s': 60.0})
    book.write(make_rows(verdict))
    row, = book.read_records(book.read())
    record = decode_record(row.record, row.settings_sha256)
    run, = verdict.runs
    assert make_plain(record.run) == make_plain(run)
    assert record.settings == verdict.settings
    assert record.run.evidence.evidence == run.evidence.evidence
    assert record.run.evidence.pieces == run.evidence.pieces != ()
    assert record.run.evidence.fingerprint == run.evidence.fingerprint is not None


def test_a_run_that_is_too_short_for_evidence_has_a_record(rng, book):
    book.write(make_rows(judge(rng, n=1)))
    row, = book.read_records(book.read())
    assert decode_record(row.record, row.settings_sha256).run.evidence.evidence.spread is None


def test_an_earlier_run_has_a_record_with_the_record_around_it(rng):
    verdict = judge(rng, n=3600, **{'runs.every_h': 0.2})
    rows = make_rows(judge(rng, n=3600, **{'runs.every_h': 0.2}), earlier=verdict.runs[:1])
    for row in rows:
        pieces = decode_record(row.record, row.settings_sha256).run.evidence.pieces
        assert [(piece.start_ns, piece.end_ns) for piece in pieces] == [
            (row.start_ns, row.end_ns)]


def test_rows_are_read_without_their_records_and_do_not_differ_by_them(rng, book):
    rows = make_rows(judge(rng))
    book.write(rows)
    assert book.read() == rows and book.read()[0].record is None
    assert book.read()[0].record_sha256 == rows[0].record_sha256
    assert book.read_records(book.read())[0].record == rows[0].record


def test_merging_takes_the_records_along_and_an_old_row_does_not_erase_one(rng, book, tmp_path):
    rows = make_rows(judge(rng))
    Logbook(tmp_path / 'source').write(rows)
    merge_logbooks(book, [Logbook(tmp_path / 'source')])
    assert book.read_records(book.read())[0].record == rows[0].record
    book.write(book.read())
    assert book.read_records(book.read())[0].record == rows[0].record


def test_a_verdict_that_was_read_gives_rows_without_records(rng, book):
    book.write(make_rows(Verdict.from_dict(judge(rng).to_dict())))
    row, = book.read_records(book.read())
    assert row.record is None and row.record_sha256 is None


@pytest.mark.parametrize('command, why', [
    ("UPDATE records SET record = x'00'", 'was changed'),
    ("UPDATE records SET record = 'text'", 'was changed'),
    ('DELETE FROM records', 'was taken out')])
def test_a_record_that_another_program_touched_is_refused(rng, book, command, why):
    book.write(make_rows(judge(rng)))
    with sqlite3.connect(book.path) as connection:
        connection.execute(command)
    connection.close()
    assert len(book.read()) == 1
    with pytest.raises(LogbookError, match='l.sqlite: the record of the run of 2023-11-14 '
                       f'22:13:20.000 UTC {why}'):
        book.read_records(book.read())


def test_the_digest_of_a_record_belongs_to_the_chain(rng, book):
    book.write(make_rows(judge(rng)))
    with sqlite3.connect(book.path) as connection:
        connection.execute('UPDATE runs SET record_sha256 = NULL')
    connection.close()
    with pytest.raises(LogbookError, match='row 1 was changed after it was written'):
        book.read()


def test_a_logbook_of_version_3_is_extended_and_keeps_its_chain(rng, book):
    book.write([make_row(0)])
    with sqlite3.connect(book.path) as connection:
        connection.execute('DROP TABLE records')
        connection.execute('ALTER TABLE runs DROP COLUMN record_sha256')
        connection.execute('PRAGMA user_version = 3')
    connection.close()
    head = book.read_head()
    assert book.read_records(book.read()) == [make_row(0)]
    book.write(make_rows(judge(rng)))
    assert [row.record is None for row in book.read_records(book.read())] == [False, True]
    assert book.read_head().entry == head.entry + 1


def test_a_changed_row_of_version_3_does_not_enter_a_new_chain(book):
    book.write([make_row(0)])
    with sqlite3.connect(book.path) as connection:
        connection.execute('ALTER TABLE runs DROP COLUMN record_sha256')
        connection.execute('UPDATE runs SET paired = 1')
        connection.execute('PRAGMA user_version = 3')
    connection.close()
    book.write([make_row(1)])
    with pytest.raises(LogbookError, match='row 1 was changed after it was written'):
        book.read()


@pytest.mark.parametrize('data', [b'', b'x', zlib.compress(b'[]'), zlib.compress(b'{}'),
                                  zlib.compress(b'{')])
def test_what_is_no_record_is_named(data):
    with pytest.raises(VerdictError, match='is no record of a run'):
        decode_record(data, 'a' * 64)


def test_a_record_of_other_settings_is_named(rng):
    row, = make_rows(judge(rng))
    with pytest.raises(VerdictError, match='settings_sha256'):
        decode_record(row.record, 'a' * 64)


def test_a_long_run_has_a_shorter_fingerprint(rng):
    """16 000 grains of half a second are more than 4096, so four of them become one."""
    fingerprint = Fingerprint.of(np.arange(8000) * S, rng.standard_normal(8000), np.zeros(8000))
    shorter = fingerprint.shorten(4096)
    assert len(fingerprint.count) == 15999 and len(shorter.count) == 4000
    assert shorter.grain_s == 2.0 and shorter.count.sum() == 8000
    assert shorter.total_deg.sum() == pytest.approx(fingerprint.total_deg.sum())
    assert shorter.shorten(4000) is shorter
