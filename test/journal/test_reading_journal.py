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

"""Pairing and judgement go on from a journal of readings as if nothing had happened."""

from __future__ import annotations

import json
import os
import pickle
import time
import zlib

from journals import NORMS, T0
import numpy as np
import pytest

from heading_intercompare.app.analysis import judge_bags
from heading_intercompare.app.config import settings_for
from heading_intercompare.app.inputs import load_config_or_journal
from heading_intercompare.bags.errors import BagError
from heading_intercompare.cli import main
from heading_intercompare.core.pairing.incarnations import StreamNumbers
from heading_intercompare.core.pairing.names import Span
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.pipeline import Compliance
from heading_intercompare.core.records import Headings, Losses, Pairs
from heading_intercompare.core.sensors.comparison import SensorsComparison
from heading_intercompare.core.sensors.pair_names import TWO
from heading_intercompare.core.settings import Settings
from heading_intercompare.journal import frozen_state, journal_file, run_journal
from heading_intercompare.journal.frozen_state import freeze, thaw
from heading_intercompare.journal.journal_file import join_parts
from heading_intercompare.journal.journal_reading import describe_gaps, MAKERS
from heading_intercompare.journal.reading_batches import (
    Batch,
    choose_pairs,
    decode_batch,
    encode_batch,
    LastHeard,
    pair_batch,
)
from heading_intercompare.journal.run_journal import find_bag, RunJournal

N = 6000
MS = 1_000_000
#: One run, several, and several of which the journal keeps two.
RUNS = {'one run': {}, 'runs': {'runs.every_h': 0.05},
        'two runs kept': {'runs.every_h': 0.05, 'runs.keep': 2}}
METHODS = ('auto', 'interpolate', 'interpolate_ts', 'nearest')


def settings(**more):
    return Settings.from_mapping({**NORMS, 'runs.min_duration_s': 10.0, **more})


class Stream:
    """Readings of a sensor at 10 Hz: silences, steps of its clock, holes, held values."""

    def __init__(self, rng, name, late_ns):
        self.name, stamps = name, T0 + np.arange(N) * 100 * MS + late_ns
        stamps[2000:2200] += 3600 * 1000 * MS
        stamps[4500:] += 700 * 1000 * MS
        values = 90.0 + np.round(rng.normal(0.0, 0.1, N), 1)
        values[3000:3100] = values[3000]
        self.headings, self.at, self.numbers = Headings.of(stamps, values), 0, 0
        self.spans = []

    def send(self, rng, to):
        """Return what comes up to a reading, its losses and names; some are lost on the way."""
        if not self.spans or rng.random() < 0.02:
            self.spans.append(Span(f'publisher{len(self.spans)}', 1, 0))
            self.numbers = 0
        rows, self.at = self.headings[self.at:to], to
        lost = int(rng.random() < 0.1) if len(rows) > 1 else 0
        losses = [(self.name, 'lost.on_the_way', Losses.of(
            [rows.stamp_ns[lost]], [rows.stamp_ns[0]], [lost]))] if lost else []
        self.numbers += len(rows)
        self.spans[-1] = self.spans[-1]._replace(last=self.numbers)
        return rows[lost:], losses, LastHeard(StreamNumbers(
            self.spans[0].publisher, 1, self.spans[-1].publisher, self.numbers,
            tuple(self.spans)), int(rows.stamp_ns[-1]) if len(rows) else 0)


def make_batches(seed, streams=None, until=None):
    """Return the batches of a trial; `until` says where sensors fall silent."""
    rng = np.random.default_rng(seed)
    streams = streams or [Stream(rng, 'ts', 0), Stream(rng, 'rs', 37 * MS)]
    ends = {stream.name: (until or {}).get(stream.name, N) for stream in streams}
    batches, now_s = [], 0.0
    while any(stream.at < ends[stream.name] for stream in streams):
        now_s += rng.uniform(0.0, 0.3)
        heard = {stream.name: stream.send(rng, min(ends[stream.name],
                                                   stream.at + int(rng.integers(0, 40))))
                 for stream in streams}
        batches.append(Batch(
            {name: rows for name, (rows, _, _) in heard.items()},
            tuple(loss for _, losses, _ in heard.values() for loss in losses), now_s,
            {name: last for name, (_, _, last) in heard.items()}))
    return batches


class Process:
    """What pairs and judges, with its journal; it may be killed at any time."""

    def __init__(self, path, rule):
        self.compliance = Compliance(rule, source='live')
        maker = PairMaker(Pairer(rule))
        self.journal = RunJournal(path, rule, {TWO: self.compliance}, within_s=3600.0,
                                  now_ns=time.time_ns(), bag='trial', makers=[maker])
        self.pairer = maker.pairer
        self.now_s, self.pairs = 0.0, Pairs.empty()

    def keep(self, batch):
        self.now_s += 0.3
        self.journal.add_batch(batch)
        self.journal.flush(self.now_s)

    def judge(self, batch):
        pairs = pair_batch(self.pairer, batch)
        self.pairs += pairs
        self.journal.add(pairs)
        self.compliance.update(pairs)
        self.journal.tick(self.now_s)

    def take(self, batch):
        self.keep(batch)
        self.judge(batch)

    def mark(self, kind, stamp_ns):
        self.journal.mark(kind, stamp_ns)
        self.pairer.ledger.cut_run(stamp_ns + 1)
        self.compliance.mark(kind, stamp_ns)
        self.journal.tick(self.now_s)

    def kill(self):
        """Let go of the file without a word, as the system does for a process that is killed."""
        self.journal._journal._syncing.close()
        if self.journal._journal._file >= 0:
            os.close(self.journal._journal._file)

    def finish(self):
        """Return the verdict, and the ledger that it stands on."""
        pairs = self.pairer.flush()
        self.pairs += pairs
        self.compliance.update(pairs)
        self.compliance.finish()
        return plain(self.compliance.verdict(self.pairer.ledger)), self.pairer.ledger.segments


class SensorsProcess:
    """As `Process`, for all pairs of several sensors."""

    def __init__(self, path, rule):
        self.all_pairs = SensorsComparison(rule, source='live').pairs
        self.journal = RunJournal(
            path, rule, {names: pair.compliance for names, pair in self.all_pairs.items()},
            within_s=3600.0, now_ns=time.time_ns(),
            makers=[pair.maker for pair in self.all_pairs.values()])
        self.now_s = 0.0

    keep, kill = Process.keep, Process.kill

    def judge(self, batch):
        for names, pair in self.all_pairs.items():
            pairs = choose_pairs(pair.maker, batch, names)
            self.journal.add(pairs, names=names)
            pair.compliance.update(pairs)
        self.journal.tick(self.now_s)

    def mark(self, kind, stamp_ns):
        self.journal.mark(kind, stamp_ns)
        for pair in self.all_pairs.values():
            pair.mark(kind, stamp_ns)
        self.journal.tick(self.now_s)

    def finish(self):
        for pair in self.all_pairs.values():
            pair.finish()
        return {names: (plain(pair.verdict()), pair.ledger.segments)
                for names, pair in self.all_pairs.items()}


@pytest.mark.parametrize('runs, most_batches', [
    ('one run', 20), ('runs', 2000), ('two runs kept', 20), ('two runs kept', 2000)])
def test_after_any_kills_several_sensors_are_judged_as_in_a_trial_without(
        tmp_path, monkeypatch, runs, most_batches):
    """The runs of each two end at other times; one sensor is silent for the second half."""
    monkeypatch.setattr(run_journal, '_MOST_BATCHES', most_batches)
    rng = np.random.default_rng(most_batches + len(RUNS[runs]))
    rule = settings(**{'pairing.method': 'interpolate', **RUNS[runs],
                       'sensors': 'a sigma_max_deg=0.3; b sigma_max_deg=0.3 rs; '
                                  'c sigma_max_deg=0.3'})
    whole, process = (SensorsProcess(tmp_path / name, rule) for name in ('whole', 'j'))
    names = [Stream(rng, name, 17 * MS * at) for at, name in enumerate('abc')]
    kills = 0
    for number, batch in enumerate(make_batches(11, names, until={'c': N // 2})):
        for judging in (whole, process):
            judging.keep(batch)
        whole.judge(batch)
        killed = rng.random() < 0.05
        if not killed or rng.random() < 0.5:
            process.judge(batch)
        if killed:
            process.kill()
            process = SensorsProcess(tmp_path / 'j', rule)
            kills += 1
            assert not process.journal.set_aside and process.journal.kept.heard == batch.heard
            for pair, of_whole in zip(process.all_pairs.values(), whole.all_pairs.values()):
                assert pair.compliance.n_in_run == of_whole.compliance.n_in_run, number
        if number in (150, 151):
            kind, stamp_ns = ('start', 'stop')[number - 150], int(T0 + number * 2000 * MS)
            whole.mark(kind, stamp_ns)
            process.mark(kind, stamp_ns)
    assert kills > 5
    assert process.finish() == whole.finish()
    if most_batches == 2000:
        # All runs of the trial have 3 MB.
        assert (tmp_path / 'j').stat().st_size < 1_000_000
    process.kill()
    whole.kill()


def plain(verdict):
    return json.loads(json.dumps(verdict.to_dict()))


@pytest.mark.parametrize('method, runs, most_batches', [
    (method, runs, (20, 2000)[(at + place) % 2])
    for at, runs in enumerate(RUNS) for place, method in enumerate(METHODS)])
def test_after_any_kills_pairs_verdict_and_account_are_those_of_a_trial_without(
        tmp_path, monkeypatch, method, runs, most_batches):
    """
    Also between the writing of a batch and its judgement; a run ends at steps and silences.

    Any two of method, runs and size of the journal come together.
    """
    monkeypatch.setattr(run_journal, '_MOST_BATCHES', most_batches)
    rule, rng = settings(**{'pairing.method': method, 'pairing.auto_s': 20.0, **RUNS[runs]}), (
        np.random.default_rng(len(method) + len(RUNS[runs])))
    whole, process = Process(tmp_path / 'whole', rule), Process(tmp_path / 'j', rule)
    began_ns, kills, made = process.journal.began_ns, 0, Pairs.empty()
    for number, batch in enumerate(make_batches(11)):
        whole.take(batch)
        process.keep(batch)
        killed = rng.random() < 0.05
        if killed and rng.random() < 0.5:
            # The next process pairs it.
            made += process.pairs
            process.kill()
            process = Process(tmp_path / 'j', rule)
            process.pairs = whole.pairs[len(made):]
        else:
            process.judge(batch)
        if number in (150, 151):
            kind, stamp_ns = ('start', 'stop')[number - 150], int(whole.pairs.stamp_ns[-1])
            whole.mark(kind, stamp_ns)
            process.mark(kind, stamp_ns)
        elif killed:
            made += process.pairs
            process.kill()
            process = Process(tmp_path / 'j', rule)
        if killed:
            assert process.compliance.n_in_run == whole.compliance.n_in_run, number
        kills += killed
        assert not process.journal.set_aside and process.journal.began_ns == began_ns
        if killed:
            assert process.journal.kept.heard == batch.heard
            assert process.journal.kept.now_s == batch.now_s
    assert kills > 5
    assert process.finish() == whole.finish()
    made += process.pairs
    assert made == whole.pairs and made.segment.tolist() == whole.pairs.segment.tolist()
    process.journal.close(over=True)
    whole.journal.close(over=True)
    assert not [*tmp_path.iterdir()]


def test_a_journal_cut_at_any_byte_of_its_last_record_goes_on_before_that_record(tmp_path):
    rule, batches = settings(**{'pairing.method': 'interpolate'}), make_batches(3)[:10]
    path = tmp_path / 'j'
    process = Process(path, rule)
    for batch in batches[:-1]:
        process.take(batch)
    size = path.stat().st_size
    process.take(batches[-1])
    process.kill()
    data = path.read_bytes()
    whole = Process(tmp_path / 'whole', rule)
    for batch in batches:
        whole.take(batch)
    expected = whole.finish()
    for at in {size, *range(size + 1, len(data), 23), len(data) - 1}:
        path.write_bytes(data[:at])
        resumed = Process(path, rule)
        assert resumed.journal.kept.heard == batches[-2].heard
        # What the record held comes again: its publishers still have it.
        resumed.take(batches[-1])
        found = resumed.finish()
        resumed.kill()
        assert found == expected, at


def test_a_restart_together_with_a_publisher_is_named(tmp_path):
    """What that one had not published has no number."""
    rule, batches, path = settings(), make_batches(4), tmp_path / 'j'
    process, before, named = Process(path, rule), {'ts': 0, 'rs': 0}, []
    for number, batch in enumerate(batches):
        if number % 10 == 5:
            process.kill()
            process = Process(path, rule)
            waiting = {'ts', 'rs'}
            before = {stream: last.numbers for stream, last in batches[number - 1].heard.items()}
        process.take(batch)
        for stream in sorted(waiting if number >= 5 else ()):
            numbers = batch.heard[stream].numbers
            if numbers != before[stream]:
                waiting.discard(stream)
                named += [stream] * (len(numbers.spans) > len(before[stream].spans))
    process.kill()
    again = Process(path, rule)
    assert sorted(stream for _, stream in again.journal.kept.restarts) == sorted(named) and named
    words = ' '.join(describe_gaps(again.journal.kept, 0))
    assert 'and so was the publisher of ' in words
    again.kill()


def test_after_a_disk_that_was_full_for_long_it_goes_on_behind_what_was_given_up(
        tmp_path, monkeypatch):
    """The numbers of a batch follow those of the batch before, which may be gone."""
    monkeypatch.setattr(journal_file, '_MOST_WAITING', 150_000)
    rule, batches, path = settings(), make_batches(9), tmp_path / 'j'
    process = Process(path, rule)
    for batch in batches[:40]:
        process.take(batch)

    def fail(*_):
        raise OSError(28, 'No space left on device')
    with monkeypatch.context() as patch:
        patch.setattr(journal_file, '_write_all', fail)
        for batch in batches[40:300]:
            process.take(batch)
    assert process.journal._journal.dropped
    for batch in batches[300:]:
        process.now_s += 1.0
        process.take(batch)
    process.kill()
    again = Process(path, rule)
    assert again.journal.kept.dropped and again.journal.kept.heard == batches[-1].heard
    assert again.pairer.ledger.segments == process.pairer.ledger.segments
    again.kill()


@pytest.mark.parametrize('rule', [{}, {'runs.every_h': 0.05}])
def test_analyze_and_info_read_it_while_the_trial_goes_on(tmp_path, rule, capsys):
    rule, path = settings(**{'pairing.method': 'interpolate', **rule}), tmp_path / 'a.journal'
    process = Process(path, rule)
    for batch in make_batches(5)[:200]:
        process.take(batch)
    given = settings_for(load_config_or_journal(None, [str(path)]))
    judged = plain(judge_bags([path], given).verdict)
    assert main(['info', str(path)]) == 0
    said = capsys.readouterr().out
    assert 'readings after these pairs: ' in said and 'ledger' not in said
    expected, _ = process.finish()
    for mapping in (judged, expected):
        for key in ('inputs', 'ledger_problems', 'ledger_complete'):
            del mapping[key]
        for run in mapping['runs']:
            del run['source']
    assert judged == expected and expected['runs']
    process.kill()
    assert find_bag(path, rule, within_s=3600.0, now_ns=time.time_ns()) == 'trial'


def test_other_code_neither_goes_on_with_it_nor_reads_it(tmp_path, monkeypatch):
    """A field that the code lacks would end the node in the middle of a trial."""
    rule, path = settings(), tmp_path / 'j.journal'
    process = Process(path, rule)
    process.take(make_batches(1)[0])
    process.kill()
    frozen_state.hash_code.cache_clear()
    for module in ('frozen_state', 'journal_reading', 'run_journal'):
        monkeypatch.setattr(f'heading_intercompare.journal.{module}.hash_code',
                            lambda: 'other')
    with pytest.raises(BagError, match='was written by other code of version .*: analyze it'):
        load_config_or_journal(None, [str(path)])
    process = Process(path, rule)
    assert 'other code wrote it' in process.journal.set_aside
    assert (tmp_path / 'j.journal.1').exists()
    process.kill()


@pytest.mark.parametrize('frozen', [b'x', freeze(Headings.empty())])
def test_a_state_that_cannot_be_read_is_set_aside_before_anything_is_judged(tmp_path, frozen):
    process = Process(tmp_path / 'j', settings())
    for batch in make_batches(1)[:5]:
        process.take(batch)
    process.journal._journal.append(MAKERS, join_parts({'now_s': 0.0, 'heard': {}}, frozen))
    process.journal.flush(1e9)
    process.kill()
    again = Process(tmp_path / 'j', settings())
    assert 'this version cannot read it: the state of the pairing' in again.journal.set_aside
    assert again.compliance.newest_ns is None and again.pairer.ledger.newest_ns is None
    again.kill()


def test_a_journal_of_pairs_is_no_journal_of_readings(tmp_path):
    compliance = Compliance(settings(), source='live')
    journal = RunJournal(tmp_path / 'j', settings(), {TWO: compliance}, within_s=3600.0,
                         now_ns=time.time_ns())
    journal.add(Pairs.of([T0], [90.0], [90.0]), {'1': (1, 1, 0, 0)})
    journal.tick(1.0)
    journal.close(over=False)
    process = Process(tmp_path / 'j', settings())
    assert 'a node that did not pair the readings' in process.journal.set_aside
    process.kill()


def test_a_batch_is_the_same_after_its_bytes():
    before = {}
    sizes = []
    for batch in make_batches(7):
        data = encode_batch(batch, before, TWO)
        again = decode_batch(data, before, TWO)
        assert again.heard == batch.heard and again.now_s == batch.now_s
        assert again.headings == batch.headings and again.losses == batch.losses
        sizes.append(len(data))
        before = batch.heard
    idle = Batch(dict.fromkeys(('ts', 'rs'), Headings.empty()), (), 5.0, before)
    assert len(encode_batch(idle, before, TWO)) == 8 and decode_batch(
        encode_batch(idle, before, TWO), before, TWO) == idle
    # Sixteen bytes a reading, and the names only where they do not follow.
    assert np.median(sizes) < 16 * 2 * 20 + 80


class Stranger:
    """What a file of somebody else might ask for."""

    def __reduce__(self):
        return os.system, ('true',)


@pytest.mark.parametrize('data', [
    pickle.dumps(Stranger()), pickle.dumps(json.loads), pickle.dumps(Batch),
    b'cheading_intercompare.core.pairing.pairer\nnp\n.', b'cbuiltins\ngetattr\n.', b'', b'\x80'])
@pytest.mark.parametrize('pack', [zlib.compress, bytes])
def test_nothing_but_objects_of_core_is_thawed(data, pack):
    with pytest.raises(BagError, match='the state of the pairing cannot be read'):
        thaw(pack(data))


def test_what_is_thawed_goes_on_to_the_bit():
    rule = settings()
    pairer = Pairer(rule)
    for batch in make_batches(2)[:100]:
        pair_batch(pairer, batch)
    again = thaw(freeze(pairer))
    for batch in make_batches(2)[100:]:
        assert pair_batch(again, batch) == pair_batch(pairer, batch)
    assert again.flush() == pairer.flush()
    assert again.ledger.segments == pairer.ledger.segments


def test_the_file_says_its_version():
    assert journal_file._MAGIC == b'heading_intercompare journal 3\n'
