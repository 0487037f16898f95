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

"""The logbook of a node: written once, kept up to date, and never in the way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
import sqlite3

import numpy as np
import pytest

from heading_intercompare import analyze, Headings, Settings
from heading_intercompare.logbook.logbook_file import Logbook
from heading_intercompare.messages.status_messages import OK, WARN
from heading_intercompare.nodes.judging import reporting
from heading_intercompare.nodes.judging.reporting import RunLog
from heading_intercompare.nodes.settings import ComplianceNode

S = 1_000_000_000


class Told:
    """A stand-in for the health of a node, which remembers what it was told."""

    def __init__(self):
        self.states = []

    def note(self, part, level, message, *, latch=False, alarm=''):
        self.states.append((part, level, message, latch))


@pytest.fixture
def verdict(rng):
    stamps = (1_700_000_000 + np.arange(1500)) * S
    rs = Headings.of(stamps, np.full(1500, 90.0))
    return analyze(Headings.of(stamps, 90.0 + 0.1 * rng.standard_normal(1500)), rs,
                   Settings.from_mapping({'norms.sigma_max_deg': 0.2, 'runs.every_h': 0.2,
                                          'norms.sigma_ref_max_deg': 0.1}))


@pytest.fixture
def now(monkeypatch):
    """Return the steady clock of the log, which a test sets."""
    clock = [100.0]
    monkeypatch.setattr(reporting.time, 'monotonic', lambda: clock[0])
    return clock


def open_log(path, **more):
    told = Told()
    return RunLog(ComplianceNode(logbook=str(path), **more), told), told


def test_without_the_setting_nothing_is_written(verdict, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told = Told()
    log = RunLog(ComplianceNode(), told)
    log.take(verdict, ())
    log.retry(last=True)
    assert told.states == [] and list(tmp_path.iterdir()) == []


def test_each_run_has_a_row_with_ship_and_bag(verdict, tmp_path):
    log, told = open_log(tmp_path / 'l', ship='MV Example', bag='trial_1')
    log.take(verdict, ())
    log.take(verdict, ())
    rows = Logbook(tmp_path / 'l').read()
    assert [row.start_ns for row in rows] == [run.start_ns for run in verdict.runs]
    assert {(row.ship, row.bag) for row in rows} == {('MV Example', 'trial_1')}
    assert [state[1] for state in told.states] == [OK]


def test_a_row_that_changes_is_written_again(verdict, tmp_path):
    log, told = open_log(tmp_path / 'l')
    run = replace(verdict.runs[0], pairing=replace(verdict.runs[0].pairing, paired=1))
    log.take(replace(verdict, runs=(run, *verdict.runs[1:])), ())
    log.take(verdict, ())
    assert Logbook(tmp_path / 'l').read()[0].paired == verdict.runs[0].pairing.paired
    assert len(told.states) == 2


def test_runs_too_old_for_the_verdict_are_written_too(verdict, tmp_path):
    log, _ = open_log(tmp_path / 'l')
    log.take(replace(verdict, runs=verdict.runs[1:]), verdict.runs[:1])
    assert len(Logbook(tmp_path / 'l').read()) == len(verdict.runs)


def test_a_logbook_that_cannot_be_written_is_a_latched_warning_and_tried_again(
        verdict, tmp_path, now):
    log, told = open_log(tmp_path / 'away' / 'l')
    log.take(verdict, ())
    part, level, message, latch = told.states[-1]
    assert (part, level, latch) == ('logbook', WARN, True)
    assert message.endswith(f'; {len(verdict.runs)} runs wait') and '\n' not in message
    (tmp_path / 'away').mkdir()
    log.retry()
    assert len(told.states) == 1, 'not before its time'
    now[0] += 10.0
    log.retry()
    assert told.states[-1][1] == OK
    assert len(Logbook(tmp_path / 'away' / 'l').read()) == len(verdict.runs)


def test_a_full_disk_is_a_latched_warning(verdict, tmp_path, monkeypatch):
    connect = Logbook._connect

    def small(self, write):
        connection = connect(self, write)
        connection.execute('PRAGMA max_page_count = 1')
        return connection

    monkeypatch.setattr(Logbook, '_connect', small)
    log, told = open_log(tmp_path / 'l')
    log.take(verdict, ())
    assert told.states[-1][1] == WARN and told.states[-1][3]
    assert 'full' in told.states[-1][2]


def test_a_locked_logbook_is_tried_again_without_an_alarm_that_stays(verdict, tmp_path, now):
    path = tmp_path / 'l'
    Logbook(path).write([])
    other = sqlite3.connect(path, isolation_level=None)
    other.execute('BEGIN EXCLUSIVE')
    log, told = open_log(path)
    log.take(verdict, ())
    assert told.states[-1][1] == WARN and not told.states[-1][3]
    other.execute('COMMIT')
    other.close()
    log.retry(last=True)
    assert told.states[-1][1] == OK and len(Logbook(path).read()) == len(verdict.runs)


def test_the_file_of_something_else_is_left_alone(verdict, tmp_path):
    Path(tmp_path / 'l').write_text('my shopping list\n' * 100)
    log, told = open_log(tmp_path / 'l')
    log.take(verdict, ())
    assert told.states[-1][3] and 'is not a logbook' in told.states[-1][2]
    assert Path(tmp_path / 'l').read_text() == 'my shopping list\n' * 100
