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

"""Journals of live runs as inputs; bags and csv are tested with the analysis and its commands."""

from __future__ import annotations

from pathlib import Path
import time

from journals import (
    last_record_at,
    ledger_of,
    NORMS,
    plain,
    some_pairs,
    T0,
    write_journal,
    write_records,
)
import numpy as np
import pytest

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.config import settings_for
from heading_intercompare.app.inputs import _join_chunks, judge_input, load_config_or_journal
from heading_intercompare.bags.errors import BagError
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings, Pairs
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal.run_journal import RunJournal
from heading_intercompare.messages.ledger_messages import LedgerMessage

S = 1_000_000_000


def judge(path, *assignments, **more):
    """Return what the command judges, without --config."""
    settings = settings_for(load_config_or_journal(None, [str(path)]), assignments)
    return judge_bags([str(path)], settings, **more)


#: Settings and marks of a journal; whether it has a ledger goes with them in turn.
RULES = ({}, {'runs.every_h': 0.25}, {'runs.every_h': 0.25, 'runs.keep': 3},
         {'runs.stabilization_s': 100.0}, {'sequential.plan_s': 3600.0},
         {'norms.sigma_max_deg': 0.05})
MARKS = ((), [(500, 'start')], [(500, 'start'), (3000, 'stop')])


@pytest.mark.parametrize('rule, marks, booked', [
    (rule, marks, (at + place) % 2 == 0)
    for at, rule in enumerate(RULES) for place, marks in enumerate(MARKS)])
def test_a_journal_gives_the_verdict_that_its_node_would_have_given(tmp_path, rule, marks, booked):
    path = tmp_path / 'trial.journal'
    live = write_journal(path, some_pairs(4000, gap_at=1500), marks, booked=booked, **rule)
    judged = judge(path).verdict
    assert judged.runs and plain(judged) == plain(live)
    assert {run.source for run in judged.runs} == {str(path)}
    assert judged.settings_sha256 == live.settings_sha256


def test_the_input_says_what_it_was_and_what_is_not_in_it(tmp_path):
    path = tmp_path / 'compliance.journal.1'
    write_journal(path, some_pairs(2000, gap_at=1500), [(500, 'start')], bag='trial_7')
    judged = judge(path)
    given, = judged.verdict.inputs
    assert (given.ts_topic, given.rs_topic) == ('ts/heading', 'rs/heading')
    first, last = given.ledger_problems
    assert first.startswith(
        'is the journal of a live run, begun at 2024-10-04 00:00:00.000 UTC by version ')
    assert first.endswith(', recorded to trial_7: it holds 500 pairs, 1 mark and 1 judged run')
    assert last == ('it ends with the pair of 2024-10-04 00:43:19.000 UTC: what came later is not '
                    'in it')
    assert judged.verdict.ledger_complete is False
    assert judged.notes[0] == f'{path}: {first}'


def test_a_journal_without_a_ledger_and_with_gaps_says_so(tmp_path):
    path, rule = tmp_path / 'j', Settings.from_mapping(NORMS)
    journal = RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=60.0, now_ns=T0)
    journal.add(some_pairs(50), {'1000': (4, 60, 7, 0)})
    journal.close(over=False)
    given, = judge(path).verdict.inputs
    assert [*given.ledger_problems][1:4] == [
        '3 pairs were published before the node that kept it started',
        '7 pairs never came to that node: lost on the way, or while it was down',
        'it holds no ledger: its pairs count as all readings received']


def test_other_settings_judge_the_pairs_and_leave_out_the_runs_judged_before(tmp_path):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(4000, gap_at=1500))
    assert len(judge(path).verdict.runs) == 2
    judged = judge(path, 'norms.sigma_max_deg=0.05').verdict
    run, = judged.runs
    assert (run.n, judged.settings.norms.sigma_max_deg) == (2500, 0.05)
    told = judged.inputs[0].ledger_problems
    assert told[1] == ('its pairs were judged by other settings than those of its node: '
                       'norms.sigma_max_deg')
    assert told[2] == ('left out: 1 judged run, whose pairs are not in it: these settings cannot '
                       'judge them again')


def test_the_names_of_a_trial_may_be_given_after_it(tmp_path):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(4000, gap_at=1500))
    judged = judge(path, 'trial.ship=MV Example', 'trial.ts_serial=12').verdict
    assert len(judged.runs) == 2 and judged.settings.trial.ship == 'MV Example'
    assert not any('other settings' in line for line in judged.inputs[0].ledger_problems)


def test_other_settings_respect_the_marks_that_were_set_before(tmp_path):
    """Pairs after a stop mark belong to no run, although the run that it ended is not judged."""
    path, stop = tmp_path / 'trial.journal', [(500, 'start'), (3000, 'stop')]
    write_journal(path, some_pairs(4000, gap_at=1500), stop)
    assert judge(path, 'norms.sigma_max_deg=0.05').verdict.runs == ()
    write_journal(path, some_pairs(4000, gap_at=1500), [*stop, (3600, 'start')])
    run, = judge(path, 'norms.sigma_max_deg=0.05').verdict.runs
    assert run.n == 400


def test_a_table_of_runs_cuts_the_pairs_of_a_journal(tmp_path):
    path, pairs = tmp_path / 'trial.journal', some_pairs(4000, gap_at=1500)
    write_journal(path, pairs, [(500, 'start')])
    table = [(int(pairs.stamp_ns[2000]), int(pairs.stamp_ns[3000]), '')]
    judged = judge(path, runs=table).verdict
    run, = judged.runs
    assert (run.start_ns, run.n) == (table[0][0], 1000)
    assert any('the table of runs cannot judge them again' in one
               for one in judged.inputs[0].ledger_problems)


def test_the_pairs_of_a_journal_can_be_taken(tmp_path):
    path, pairs, taken = tmp_path / 'trial.journal', some_pairs(900), []
    write_journal(path, pairs)
    judge(path, takers={'ts': [taken.append]})
    found = Pairs.concatenate(taken)
    assert (found.stamp_ns == pairs.stamp_ns).all() and (found.ts_deg == pairs.ts_deg).all()


def test_a_journal_torn_at_any_byte_of_its_last_record_loses_that_record_only(tmp_path):
    path = tmp_path / 'trial.journal'
    pairs, rule = some_pairs(20), Settings.from_mapping(NORMS)
    journal = RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=60.0, now_ns=T0)
    for at, now_s in ((0, 1.0), (15, 2.0)):
        journal.add(pairs[at:at + 15], {'1000': (1, at + 15, 0, 0)})
        journal.tick(now_s)
    journal.close(over=False)
    whole, begin = path.read_bytes(), last_record_at(path)
    for size in range(begin, len(whole)):
        path.write_bytes(whole[:size])
        verdict = judge(path).verdict
        assert verdict.runs[0].n == 15
        told = [one for one in verdict.inputs[0].ledger_problems if 'record that was cut' in one]
        assert told == ([] if size == begin else [
            f'its last {size - begin} bytes are of a record that was cut, or is being written: '
            'its pairs, mark or ledger are missing'])


def test_a_journal_torn_in_its_first_record_holds_nothing(tmp_path):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(20))
    whole = path.read_bytes()
    for size in (31, 35, 40, 200):
        path.write_bytes(whole[:size])
        with pytest.raises(BagError, match='its first record was cut, so it holds neither'):
            judge(path)


def test_a_journal_in_use_is_read_without_a_lock_and_not_changed(tmp_path):
    path, rule = tmp_path / 'trial.journal', Settings.from_mapping(NORMS)
    journal = RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=60.0, now_ns=T0)
    journal.add(some_pairs(300), {})
    journal.tick(1.0)
    was, names = path.read_bytes(), {*tmp_path.iterdir()}
    path.chmod(0o444)
    assert judge(path).verdict.runs[0].n == 300
    assert (path.read_bytes(), {*tmp_path.iterdir()}) == (was, names)
    journal.add(some_pairs(400)[300:], {})
    journal.tick(2.0)
    assert not journal.fault
    assert judge(path).verdict.runs[0].n == 400
    journal.close(over=False)


def test_a_journal_without_pairs_gives_no_run_and_says_why(tmp_path):
    path, rule = tmp_path / 'trial.journal', Settings.from_mapping(NORMS)
    RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=60.0, now_ns=T0).close(over=False)
    judged = judge(path).verdict
    assert (judged.outcome.value, judged.runs) == ('indeterminate', ())
    assert judged.inputs[0].no_run.startswith('no pair was made; 0 TS and 0 RS')


def test_ledgers_of_a_synchronizer_that_was_restarted_add_up(tmp_path):
    path, rule = tmp_path / 'trial.journal', Settings.from_mapping(NORMS)
    journal = RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=60.0, now_ns=T0)
    journal.add(some_pairs(300), {'1': (1, 100, 0, 0), '2': (1, 200, 0, 1)})
    for started_ns, n in ((1, 100), (2, 200)):
        ledger = ledger_with(n)
        journal.book(LedgerMessage(ledger, False, started_ns, {}))
    journal.close(over=False)
    journal = RunJournal(path, rule, {TWO: Compliance(rule)}, within_s=1e12, now_ns=T0)
    journal.book(LedgerMessage(ledger_with(200), False, 2, {}))
    journal.book(LedgerMessage(ledger_with(100), False, 1, {}))
    journal.tick(1.0)
    journal.close(over=False)
    judged = judge(path).verdict
    assert judged.runs[0].pairing.paired == 300
    assert any('the synchronizer was restarted' in one
               for one in judged.inputs[0].ledger_problems)


def ledger_with(n):
    """Return a ledger of n pairs."""
    return ledger_of(some_pairs(n), n, []).ledger


@pytest.mark.parametrize('records', [
    [(b'H', b'[]')], [(b'H', b'{}')], [(b'H', b'{"settings": 7, "software": "1"}')], [(b'P', b'')],
    [(b'H', b'\xff')], [(b'Z', b'')]])
def test_what_no_version_wrote_is_refused_in_one_line(tmp_path, records):
    path = tmp_path / 'trial.journal'
    write_records(path, *records)
    with pytest.raises(BagError, match='this version cannot read it') as caught:
        judge(path)
    assert str(caught.value).startswith(str(path)) and '\n' not in str(caught.value)


@pytest.mark.parametrize('record', [
    (b'P', b''), (b'P', b'\x05\0\0\0{}'), (b'S', b'{}'), (b'S', b'{"state": "{}", "marks": []}'),
    (b'M', b'7'), (b'M', b'["halt", 7]'), (b'L', b'{}'), (b'G', b'"x"'),
    (b'L', b'{"started_ns": 1, "at": 0, "segments": [[null, {"nothing": 1}]], "newest_ns": 1, '
           b'"set_backs": [], "numbers": {}, "final": false}')])
def test_a_later_record_that_no_version_wrote_is_refused_in_one_line(tmp_path, record):
    path = tmp_path / 'trial.journal'
    write_journal(path, some_pairs(20))
    data = path.read_bytes()
    write_records(path, record)
    path.write_bytes(data + path.read_bytes()[31:])
    with pytest.raises(ValueError, match='this version cannot read it') as caught:
        judge(path)
    assert str(caught.value).startswith(str(path)) and '\n' not in str(caught.value)


def test_several_journals_of_one_trial_bring_their_settings(tmp_path):
    paths = [str(tmp_path / f'{name}.journal') for name in 'ab']
    for seed, path in enumerate(paths):
        write_journal(Path(path), some_pairs(900, seed=seed))
    settings = settings_for(load_config_or_journal(None, paths))
    assert len(judge_bags(paths, settings).verdict.runs) == 2
    write_journal(Path(paths[1]), some_pairs(900), **{'norms.sigma_max_deg': 0.2})
    with pytest.raises(ValueError, match=r'b.journal: has other settings than .*a.journal: '
                       'norms.sigma_max_deg; give the settings for all with --config'):
        load_config_or_journal(None, paths)
    Path(paths[1]).write_bytes(b'nothing')
    assert settings_for(load_config_or_journal(None, paths)).norms.sigma_max_deg == 0.3


def test_chunks_are_joined_without_a_loss():
    """Chunks of 1 to 40 000 headings, some of one sensor only."""
    rng = np.random.default_rng(3)
    sizes = [(int(a), int(b)) for a, b in rng.integers(0, 20_000, (12, 2))] + [(0, 0), (5, 0)]
    stamps = iter(range(10 ** 18, 10 ** 18 + 10 ** 6))
    chunks = [{topic: Headings.of([next(stamps) for _ in range(n)], np.zeros(n))
               for topic, n in zip(('ts', 'rs'), each)} for each in sizes]
    joined = [*_join_chunks(iter(chunks))]
    assert 1 < len(joined) < len(chunks)
    for topic in ('ts', 'rs'):
        assert Headings.concatenate([chunk[topic] for chunk in joined]) == Headings.concatenate(
            [chunk[topic] for chunk in chunks])
    assert [*_join_chunks(iter([]))] == []


def test_a_journal_of_several_sensors_without_the_reference_says_what_to_analyze(tmp_path):
    """It was said to hold the pairs of two sensors, to be chosen."""
    rule = Settings.from_mapping({'sensors': 'a sigma_max_deg=0.3; b sigma_max_deg=0.3'})
    path, others = tmp_path / 'j.journal', SensorsComparison(rule).others
    for within_s in (3600.0, -1.0):
        journal = RunJournal(
            path, rule, {names: pair.compliance for names, pair in others.items()},
            within_s=within_s, now_ns=time.time_ns())
        assert 'to judge what it holds' not in journal.set_aside
        journal.add(Pairs.of([T0], [90.0], [90.0]), names=('a', 'b'))
        journal.tick(1.0)
        journal.close(over=False)
    assert 'is not this one: it was last written' in journal.set_aside
    for settings in (rule, Settings.from_mapping(NORMS)):
        with pytest.raises(BagError, match='of several sensors: analyze the recording'):
            judge_input(str(path), settings)
