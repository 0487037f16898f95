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

"""The command `info` on journals of live runs; on bags see test_bag_commands."""

from __future__ import annotations

from journals import some_pairs, write_journal

from heading_intercompare.cli import main


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
