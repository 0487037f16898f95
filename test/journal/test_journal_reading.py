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

"""What is read of a journal; that its judgement goes on is tested with `run_journal`."""

from __future__ import annotations

from journals import ledger_of, some_pairs, T0, write_journal

from heading_intercompare.journal.journal_file import is_journal, read_journal
from heading_intercompare.journal.journal_reading import (
    compare_settings,
    describe_gaps,
    JournalReader,
    Kept,
    read_origin,
    Unjudged,
)

S = 1_000_000_000


def test_a_journal_is_known_by_its_name_or_by_its_first_bytes(tmp_path):
    write_journal(tmp_path / 'j', some_pairs(5))
    for name in ('bag.mcap', 'x.csv', 'journal'):
        (tmp_path / name).write_bytes(b'\x89MCAP0\r\n')
    (tmp_path / 'folder.journal').mkdir()
    for name in ('j', 'a.journal', 'a.journal.12'):
        assert is_journal(tmp_path / name)
    for name in ('bag.mcap', 'x.csv', 'journal', 'folder.journal', 'missing', 'a.journal.x'):
        assert not is_journal(tmp_path / name)


def test_what_a_journal_holds_is_read_without_judging(tmp_path):
    path = tmp_path / 'j'
    write_journal(path, some_pairs(3000, gap_at=1500), [(500, 'start')])
    contents = read_journal(path)
    origin, reader = read_origin(contents, path), JournalReader(path)
    n_judged = reader.read(contents, [Unjudged()])
    assert (origin.began_ns, origin.bag, origin.settings['norms.sigma_max_deg']) == (
        T0, 'trial_1', 0.3)
    assert n_judged == 1 and reader.kept.marks == {('start', T0 + 499 * S)}
    assert (reader.kept.n_pairs, reader.kept.start_ns, reader.kept.newest_ns) == (
        1500, T0 + 2100 * S, T0 + 3599 * S)


def test_only_the_first_bytes_are_read_if_asked(tmp_path):
    path = tmp_path / 'j'
    write_journal(path, some_pairs(3000))
    head = read_journal(path, 20_000)
    assert head.size + head.torn == 20_000
    assert read_origin(head, path) == read_origin(read_journal(path), path)


def test_settings_that_differ_are_named():
    assert compare_settings({'a': 1, 'b': None}, {'a': 1, 'b': None}) == ''
    assert compare_settings(None, {'a': 1}) == 'a'
    assert compare_settings({'e': 0}, dict.fromkeys('abcd', 1)) == 'a, b, c and 2 more'


def test_what_is_missing_is_said_in_sentences():
    pairs = some_pairs(50)
    kept = Kept(numbers={'1000': (1, 50, 0, 0)}, newest_ns=T0)
    said = [*describe_gaps(kept, 0)]
    assert said[0].startswith('it holds no ledger') and len(said) == 2
    kept.ledgers = {1000: ledger_of(pairs, 40, [])}
    assert [*describe_gaps(kept, 0)][0] == (
        'its last ledger counts 40 of the 50 pairs published so far')
    kept.numbers = {'1000': (1, 30, 0, 0)}
    kept.dropped = 3
    assert [*describe_gaps(kept, 12)][:3] == [
        'its last 12 bytes are of a record that was cut, or is being written: its pairs, mark '
        'or ledger are missing', '3 records could not be written into it',
        '10 pairs that its last ledger counts are not in it']
    assert [*describe_gaps(Kept(), 0)] == [
        'it holds no ledger: its pairs count as all readings received']
