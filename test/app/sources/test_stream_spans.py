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

"""Streams whose stamps do not meet: both spans, the shift, and what to set."""

from __future__ import annotations

from datetime import datetime, timedelta

from command_line import analyze_json, NORMS, refusal
import numpy as np
import pytest

from heading_intercompare.app.analysis import analyze
from heading_intercompare.app.sources.stream_spans import explain_apart, StreamSpan
from heading_intercompare.core.records import Headings
from heading_intercompare.core.settings import Settings

SECOND = 10 ** 9
T_NS = 1716926400 * SECOND
HOUR, DAY = 3600, 86400


def span(start_s, length_s=660):
    stream = StreamSpan()
    stream.update(T_NS + np.array([start_s + length_s, start_s]) * SECOND)
    stream.update(np.zeros(3, np.int64))
    return stream


@pytest.mark.parametrize('shift_s, guess', [
    (2 * HOUR, 'a time zone?'), (-9.5 * HOUR, 'a time zone?'), (DAY, 'a wrong date?'),
    (-30 * DAY, 'a wrong date?'), (1024 * 7 * DAY, 'a rollover of the weeks of GPS?')])
@pytest.mark.parametrize('late_s', [0, -40, 40])
def test_a_usual_shift_is_named_with_the_setting_that_takes_it_back(shift_s, guess, late_s):
    shift_s = int(shift_s)
    words = explain_apart(span(0), span(shift_s + late_s))
    assert guess in words
    stated_s = float(words.rpartition('alignment.skew_s=')[2])
    assert stated_s == -shift_s
    assert explain_apart(span(0), span(shift_s + late_s), stated_s) == ''


@pytest.mark.parametrize('ts, rs, words', [
    (span(0), span(7200), 'TS from 2024-05-28 20:00:00 to 20:11:00 UTC, RS from 2024-05-28 '
     '22:00:00 to 22:11:00 UTC; RS begins 2 h after TS'),
    (span(1000), span(0), 'RS begins 16.6667 min before TS; give recordings of the same time'),
    (StreamSpan(5 * SECOND, 600 * SECOND), span(0), 'is that of TS time since a start'),
    (span(0), StreamSpan(5 * SECOND, 600 * SECOND), 'is that of RS time since a start')])
def test_both_spans_and_how_far_apart_they_lie_are_named(ts, rs, words):
    assert words in explain_apart(ts, rs)


@pytest.mark.parametrize('ts, rs', [
    (span(0), span(660)), (span(0), span(100, 10)), (StreamSpan(), span(0)),
    (span(0), StreamSpan())])
def test_spans_that_meet_or_are_empty_are_not_apart(ts, rs):
    assert explain_apart(ts, rs) == ''


def write(path, *, ts_h=0.0, rs_h=0.0, kind='csv'):
    """Write a recording of two sensors, each with a shift of its clock."""
    def stamps(shift_h):
        start = datetime(2024, 5, 28, 20) + timedelta(hours=shift_h)
        return [start + timedelta(seconds=k) for k in range(660)]
    headings = [120.0 + 10.0 * np.sin(k / 30.0) for k in range(660)]
    if kind == 'csv':
        rows = [f'{moment},{heading:.3f},' for moment, heading in zip(stamps(ts_h), headings)]
        rows += [f'{moment},,{heading:.3f}' for moment, heading in zip(stamps(rs_h), headings)]
        path.write_text('\n'.join(['time,ts_hdg,rs_hdg', *rows]) + '\n')
        return [path, '--ts', 'ts_hdg', '--rs', 'rs_hdg']
    paths = []
    for talker, shift_h in (('HE', ts_h), ('IN', rs_h)):
        paths.append(path.with_name(f'{talker}.log'))
        paths[-1].write_text(''.join(
            f'{moment} ${talker}HDT,{heading:.3f},T\n'
            for moment, heading in zip(stamps(shift_h), headings)))
    return [*paths, '--checksum', 'if_present']


@pytest.mark.parametrize('kind', ['csv', 'logs'])
def test_recordings_without_a_pair_are_refused(tmp_path, capsys, kind):
    arguments = write(tmp_path / 'a.csv', rs_h=2.0, kind=kind)
    words = refusal(capsys, 'analyze', *arguments, '--quiet', *NORMS)
    assert 'RS begins 2 h after TS: a time zone? if so, state the zone' in words
    verdict, _ = analyze_json(capsys, *arguments, '--set', 'alignment.skew_s=-7200')
    assert verdict['runs'][0]['n'] == 660


def test_one_of_several_inputs_without_a_pair_is_a_note(tmp_path, capsys):
    apart = write(tmp_path / 'a.csv', rs_h=-1.5)
    meeting = write(tmp_path / 'b.csv')
    verdict, notes = analyze_json(capsys, meeting[0], *apart)
    assert len(verdict['runs']) == 1
    note, = (note for note in notes if 'no run' in note)
    assert f'{apart[0]}: no run: no pair was made, because the stamps of TS and RS' in note
    also_apart = write(tmp_path / 'c.csv', ts_h=26.0)
    assert 'no pair was made' in refusal(capsys, 'analyze', also_apart[0], *apart, *NORMS,
                                         '--quiet')


def test_readings_in_memory_give_no_run_and_no_error():
    ts, rs = (Headings.of(T_NS + SECOND * np.arange(660) + shift_s * SECOND, np.full(660, 10.0))
              for shift_s in (0, 7200))
    verdict = analyze(ts, rs, Settings.of(sigma_max_deg=0.2, sigma_ref_max_deg=0.1))
    assert not verdict.runs
