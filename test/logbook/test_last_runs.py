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

"""The last runs of a logbook give the verdict that their readings give; which ones these are."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from trials import find_finding, make_settings, make_turning_ship, NORMS

from heading_intercompare import analyze
from heading_intercompare.core.outcome import Outcome
from heading_intercompare.core.verdict.compare_verdicts import find_differences
from heading_intercompare.core.verdict.consistency import check_consistency, ContradictionError
from heading_intercompare.core.verdict.verdict_document import Verdict
from heading_intercompare.core.version import RULE_VERSION
from heading_intercompare.logbook.last_runs import judge_last_runs
from heading_intercompare.logbook.logbook_file import Logbook, LogbookError
from heading_intercompare.logbook.run_record import decode_record, encode_record, hash_record
from heading_intercompare.logbook.run_row import make_rows

S = 1_000_000_000
#: The runs of a test: their seconds, and those from one start to the next.
N, APART_S = 600, 50_000
STATED = {'risk.slowest_error_s': 300.0}


def make_errors(kind, rng, runs):
    """Return the errors of some runs, with a standard deviation of 0.1 to 0.2 deg."""
    if kind == 'shifted':
        return [0.1 * rng.standard_normal(N) + mean for mean in 0.1 * rng.standard_normal(runs)]
    if kind == 'heavy':
        return [0.06 * rng.standard_t(4.0, N) for _ in range(runs)]
    if kind == 'slow':
        t = np.arange(N) / N
        return [0.05 * rng.standard_normal(N) + 0.1 * (run % 2) * np.cos(np.pi * t)
                for run in range(runs)]
    return [0.1 * rng.standard_normal(N) for _ in range(runs)]


def judge(trials, *, rule='every_run', norms=NORMS, **settings):
    return analyze([ts for ts, _ in trials], [rs for _, rs in trials],
                   make_settings(norms, **{'campaign.rule': rule, **settings}))


@lru_cache(maxsize=None)
def rows_of(kind='white', runs=8, sigma=1.0, first=0, **settings):
    """Return the rows of runs that were judged one by one, as a ship does."""
    rng = np.random.default_rng(first + 1)
    trials = [make_turning_ship(first + at, sigma * error)
              for at, error in enumerate(make_errors(kind, rng, runs))]
    return tuple(row for trial in trials
                 for row in make_rows(judge([trial], **settings), ship='MV X'))


def rows(kind='white', runs=8, sigma=1.0, first=0, **settings):
    return list(rows_of(kind, runs, sigma, first, **{**STATED, **settings}))


@pytest.fixture
def book(tmp_path):
    return Logbook(tmp_path / 'l.sqlite')


@pytest.mark.slow
@pytest.mark.parametrize('kind, settings', [
    ('white', {}), ('shifted', STATED), ('slow', STATED), ('heavy', STATED),
    ('heavy', {'variant': 'A', 'risk.slowest_error_s': 25.0}),
    ('slow', {'variant': 'C', 'risk.slowest_error_s': 25.0}), ('slow', {'variant': 'C'}),
    ('white', {'runs.stabilization_s': 60.0}), ('slow', {'drift_order': 1}),
    ('white', {'sequential.plan_s': 600.0}),
    ('shifted', {'norms': {**NORMS, 'total_error_max_deg': 1.0}})])
def test_they_give_the_verdict_that_their_readings_give(book, kind, settings):
    rng = np.random.default_rng(3)
    trials = [make_turning_ship(at, error) for at, error in enumerate(make_errors(kind, rng, 6))]
    for trial in trials:
        book.write(make_rows(judge([trial], **settings)))
    verdict = judge_last_runs([book], 6)
    assert [*find_differences(verdict, judge(trials, rule='sensor', **settings))] == []
    check_consistency(Verdict.from_dict(verdict.to_dict()))


def test_sound_runs_too_short_for_one_certificate_certify_together(book):
    """Each has two slowest errors, not 20, so none complies alone."""
    book.write(rows())
    verdict = judge_last_runs([book], 8)
    assert verdict.campaign.runs_by_outcome['compliant'] == 0
    assert verdict.outcome is Outcome.COMPLIANT and verdict.campaign.rule == 'sensor'
    assert verdict.campaign.sensor.between_upper_bound_deg2 is not None
    assert verdict.headline.startswith('COMPLIANT for errors')


@pytest.mark.parametrize('kind, sigma, outcome', [
    ('white', 4.0, 'non_compliant'), ('shifted', 2.5, 'indeterminate')])
def test_runs_that_do_not_show_the_norm_do_not_certify(book, kind, sigma, outcome):
    """The scatter within the shifted runs is 0.25 deg, as is that of their means."""
    book.write(rows(kind, sigma=sigma))
    assert judge_last_runs([book], 8).outcome.value == outcome


def list_starts(verdict):
    return [run.start_ns for run in verdict.runs]


def test_the_last_ones_are_chosen_whatever_their_outcomes(book):
    """A run at four times the norm is among them, an older one is not."""
    poor = rows(sigma=4.0, runs=1, first=6)
    book.write([*rows(runs=6), *poor, *rows(runs=1, first=7)])
    verdict = judge_last_runs([book], 5)
    assert list_starts(verdict) == [row.start_ns for row in book.read()[-5:]]
    assert [run.run for run in verdict.runs] == [1, 2, 3, 4, 5]
    assert verdict.chosen.asked == 5 and verdict.chosen.ship == 'MV X'
    assert verdict.chosen.left_out == ()
    assert verdict.chosen.logbooks == {'l.sqlite': book.read_head().sha256}


def void(row):
    return replace(row, outcome='indeterminate', reason='void.clocks', validity_effect='void',
                   headline='INDETERMINATE, VOID', conditions='clocks=void')


UNUSABLE = {
    'void by clocks': void,
    'without a record, as an older version wrote the row: analyze its recording again':
        lambda row: replace(row, record=None, record_sha256=None),
    f'judged by version {RULE_VERSION + 1} of the decision rule': lambda row: replace(
        row, rule_version=RULE_VERSION + 1),
    'judged by other settings (bbbbbbbb)': lambda row: replace(row, settings_sha256='b' * 64),
    'not more than 5 min before the next': lambda row: replace(
        row, start_ns=row.start_ns + 49_200 * S, end_ns=row.end_ns + 49_200 * S)}


@pytest.mark.parametrize('why', UNUSABLE)
def test_a_run_that_cannot_count_is_left_out_and_named(book, why):
    """Of seven runs the fifth cannot count, so the last five are those without it."""
    given = rows(runs=7)
    given[4] = UNUSABLE[why](given[4])
    book.write(given)
    verdict = judge_last_runs([book], 5)
    assert list_starts(verdict) == [row.start_ns for at, row in enumerate(given)
                                    if at in (1, 2, 3, 5, 6)]
    run, = verdict.chosen.left_out
    assert run.start_ns == given[4].start_ns and run.why.startswith(why)
    assert verdict.chosen.words == ('the last 5 usable runs of MV X in l.sqlite; 1 since the '
                                    'first of them left out')
    line, = verdict.chosen.list_left_out()
    assert line.startswith(f'1 run left out, {why}') and line in str(verdict)


def test_a_line_names_three_of_many_runs(book):
    given = rows(runs=12)
    book.write([void(row) if at in (3, 5, 7, 9) else row for at, row in enumerate(given)])
    line, = judge_last_runs([book], 7).chosen.list_left_out()
    assert line == ('4 runs left out, void by clocks: 2023-11-16 15:53, 2023-11-17 19:40, '
                    '2023-11-18 23:26 UTC, ...')


def test_runs_without_a_pause_count_where_their_means_do_not(book):
    """In variant C only runs that overlap are left out."""
    settings = {'variant': 'C', 'risk.slowest_error_s': 20.0, 'runs.every_h': 0.125}
    rng = np.random.default_rng(1)
    ts, rs = make_turning_ship(0, 0.1 * rng.standard_normal(3000))
    book.write(make_rows(judge([(ts, rs)], **settings)))
    assert len(judge_last_runs([book], 6).runs) == 6
    overlapping = book.read_records(book.read())[-3]
    book.write([replace(overlapping, start_ns=overlapping.start_ns - S // 2)])
    assert [run.why for run in judge_last_runs([book], 6).chosen.left_out] == ['overlaps the next']


def test_runs_without_a_pause_are_thinned_where_their_means_count(book):
    settings = {'risk.slowest_error_s': 100.0, 'runs.every_h': 0.125}
    rng = np.random.default_rng(1)
    ts, rs = make_turning_ship(0, 0.1 * rng.standard_normal(4500))
    book.write(make_rows(judge([(ts, rs)], **settings)))
    verdict = judge_last_runs([book], 5)
    starts = [row.start_ns for row in book.read()]
    assert list_starts(verdict) == starts[-9::2]
    assert {run.why for run in verdict.chosen.left_out} == {'not more than 100 s before the next'}
    assert verdict.campaign.sensor.between_upper_bound_deg2 is not None


def test_too_few_runs_are_refused_with_those_left_out(book):
    given = rows(runs=6)
    book.write([void(row) if at == 2 else row for at, row in enumerate(given)])
    with pytest.raises(LogbookError) as error:
        judge_last_runs([book], 6)
    assert str(error.value) == (
        f'{book.path}: 6 runs are asked for, and 5 can be judged together; 1 run left out, void '
        'by clocks: 2023-11-16 02:00 UTC')


def test_a_logbook_without_a_usable_run_is_refused(book):
    book.write([])
    with pytest.raises(LogbookError, match='5 runs are asked for, and 0 can be judged together'):
        judge_last_runs([book], 5)
    book.write([void(row) for row in rows(runs=2)])
    with pytest.raises(LogbookError, match='and 0 can be judged together; 2 runs left out, void'):
        judge_last_runs([book], 5)


def test_one_of_several_sensors_is_to_be_chosen(book):
    given = rows(runs=5)
    book.write([*given, *(replace(row, ship='MV X/gyro') for row in given)])
    with pytest.raises(LogbookError, match='holds runs of MV X, MV X/gyro; choose one with '
                       '--ship'):
        judge_last_runs([book], 5)
    assert judge_last_runs([book], 5, 'MV X/gyro').chosen.ship == 'MV X/gyro'


def test_a_run_in_two_logbooks_counts_once(book, tmp_path):
    (tmp_path / 'copy').mkdir()
    given, copy = rows(runs=6), Logbook(tmp_path / 'copy' / 'l.sqlite')
    book.write(given)
    copy.write([replace(row, record=None) for row in given])
    for books in ([book, copy], [copy, book]):
        verdict = judge_last_runs(books, 6)
        assert list_starts(verdict) == [row.start_ns for row in given]
        assert verdict.chosen.logbooks == {
            'l.sqlite': books[0].read_head().sha256, 'l.sqlite (2)': books[1].read_head().sha256}


def test_a_record_that_cannot_be_read_is_named(book):
    """As one that lacks a setting of a later version."""
    given = rows(runs=5)
    book.write([*given[:4], replace(given[4], record=b'x', record_sha256=hash_record(b'x'))])
    with pytest.raises(LogbookError, match='l.sqlite: the record of the run of 2023-11-17 '
                       '05:46:40.000 UTC: is no record of a run: error; analyze its recording '):
        judge_last_runs([book], 5)


def test_the_same_readings_under_another_date_certify_nothing(book):
    rng = np.random.default_rng(1)
    errors = make_errors('white', rng, 5)
    for at, error in enumerate([*errors, errors[1]]):
        book.write(make_rows(judge([make_turning_ship(at, error)], **STATED), ship='MV X'))
    verdict = judge_last_runs([book], 6)
    assert verdict.outcome is Outcome.INDETERMINATE
    assert verdict.campaign.reason == 'a_run_repeated'
    assert find_finding(verdict.campaign, 'repeated_readings').effect == 'doubtful'
    check_consistency(Verdict.from_dict(verdict.to_dict()))


def test_what_the_runs_leave_out_counts(book):
    """The first 200 s are bad and called settling; nothing shows a warm-up."""
    rng = np.random.default_rng(1)
    for at in range(6):
        error = 0.1 * rng.standard_normal(N)
        error[:200] += 3.0 * rng.standard_normal(200)
        book.write(make_rows(judge([make_turning_ship(at, error)], **STATED, **{
            'runs.stabilization_s': 200.0})))
    verdict = judge_last_runs([book], 6)
    assert verdict.taken_out.n == 1200 and verdict.taken_out.share == pytest.approx(1 / 3)
    assert find_finding(verdict.campaign, 'left_out').effect == 'doubtful'


def rewrite(book, change):
    """Write a changed record of the last run into the logbook, as a forger with the program."""
    row = book.read_records(book.read())[-1]
    record = decode_record(row.record, row.settings_sha256)
    run = change(record.run)
    verdict = replace(judge([make_turning_ship(0, np.zeros(N))]), settings=record.settings)
    data = encode_record(verdict, run)
    book.write([replace(row, record=data, record_sha256=hash_record(data))])


def change_evidence(run):
    evidence = run.evidence.evidence
    spread = replace(evidence.spread, d_deg2=0.5 * evidence.spread.d_deg2)
    return replace(run, evidence=replace(run.evidence, evidence=replace(evidence, spread=spread)))


@pytest.mark.parametrize('change', [
    change_evidence, lambda run: replace(run, variance_deg2=0.5 * run.variance_deg2),
    lambda run: replace(run, outcome=Outcome.COMPLIANT),
    lambda run: replace(run, guarded=replace(run.guarded, upper_bound_deg2=0.001))],
    ids=['evidence', 'variance', 'outcome', 'bound'])
def test_a_record_that_contradicts_itself_is_refused(book, change):
    book.write(rows(runs=5))
    rewrite(book, lambda run: run)
    assert judge_last_runs([book], 5).outcome is Outcome.COMPLIANT
    rewrite(book, change)
    with pytest.raises(LogbookError, match='l.sqlite: the record of the run '
                       'of 2023-11-17 05:46:40.000 UTC: .*the record was changed'):
        judge_last_runs([book], 5)


def test_a_number_of_runs_that_was_changed_in_the_verdict_is_refused(book):
    book.write(rows(runs=6))
    document = judge_last_runs([book], 6).to_dict()
    document['chosen']['asked'] = 30
    with pytest.raises(ContradictionError, match='chosen.asked is 30, but its figures give 6'):
        check_consistency(Verdict.from_dict(document))
