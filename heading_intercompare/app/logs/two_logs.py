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

"""The verdict on the logs of a TS and an RS, imported in memory."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
import os
from typing import Callable, Iterable, Mapping, Sequence

from heading_intercompare.app.analysis import Judgement
from heading_intercompare.app.inputs import explain_no_run
from heading_intercompare.app.run_table import assign_runs, name_outside, read_run_table
from heading_intercompare.app.sources.found import Found, make_account
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.offline import judge_aligned, name_apart
from heading_intercompare.core.pipeline import Intercomparison, join
from heading_intercompare.core.records import Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import Input
from heading_intercompare.drivers.refused_lines import describe_start
from heading_intercompare.drivers.settings import DriverSettings
from heading_intercompare.readers.registry import has_one_sensor, has_streams
from heading_intercompare.report import SeriesSketch

from .antenna_logs import import_antennas
from .log_import import import_log, ImportedLog
from .log_motion import find_motion, FoundMotion

__all__ = ['find_logs', 'judge_logs', 'ROLES']

ROLES = ('ts', 'rs')
"""The sensors, in the order of their logs."""

_USE = 'give two logs, first that of the TS, then that of the RS, and nothing else'
_OTHERS = ('.mcap', '.csv', '.json', '.journal')
_APART = ('tell its sensors apart with --ts-sentence and --rs-sentence, --ts-talker and '
          '--rs-talker, or --ts-instrument and --rs-instrument')


def find_logs(inputs: Sequence[str], drivers: Mapping[str, DriverSettings] | None = None, *,
              recordings: bool = False) -> tuple[str, str] | None:
    """
    Return the log of the TS and that of the RS, or None if no input is a log.

    Parameters
    ----------
    inputs : sequence of str
        The inputs as given. One log may hold both sensors.
    drivers : mapping of {'ts', 'rs'} to DriverSettings, optional
        How to read each log; in a log of both sensors they must differ.
    recordings : bool
        A file with several streams is a recording of both sensors, also if there are two.

    Raises
    ------
    OSError
        If one is a log and another cannot be read.
    ValueError
        If one is a log and they are neither two different logs nor one log of both sensors.

    """
    for given in inputs:
        name, equals, path = given.partition('=')
        if equals and os.path.exists(path) and not os.path.exists(given):
            raise ValueError(f'{given}: NAME=LOG is for several sensors, and the setting sensors '
                             f'has no {name}: give it a row for each of them')
    streams = len(inputs) == 2 and not recordings
    logs = [path for path in inputs
            if has_one_sensor(path) or streams and has_streams(path)]
    if not logs:
        _check_texts(inputs)
        return None
    for path in inputs:
        if path not in logs:
            os.stat(path)
            start = describe_start(path)
            raise ValueError(f'{path}: is not a log of NMEA sentences or headings, but {logs[0]} '
                             f'is: {start or _USE}')
    apart = drivers is not None and drivers['ts'] != drivers['rs']
    if len(inputs) == 1 and apart:
        return inputs[0], inputs[0]
    if len(inputs) != 2:
        given = 'the log of one sensor' if len(inputs) == 1 else f'one of {len(inputs)} logs'
        more = (f'; if it is of both, {_APART}' if len(inputs) == 1 else
                '; give the files of one sensor as their folder, or as a pattern in quotes')
        raise ValueError(f'{inputs[0]}: is {given}: {_USE}{more}')
    ts, rs = inputs
    if not apart and (ts == rs or (os.path.exists(ts) and os.path.exists(rs)
                                   and os.path.samefile(ts, rs))):
        raise ValueError(f'{rs}: is given as TS and as RS: {_USE}; if it is of both, {_APART}')
    return ts, rs


def _check_texts(inputs: Sequence[str]) -> None:
    """Raise ValueError for two texts that are neither logs nor anything else that is judged."""
    if len(inputs) == 2 and not any(path.endswith(_OTHERS) or has_streams(path)
                                    for path in inputs):
        for path in inputs:
            start = describe_start(path)
            if start.startswith('first'):
                raise ValueError(f'{path}: is neither a bag nor a log of NMEA sentences: {start}')


def judge_logs(ts: str, rs: str, settings: Settings, drivers: Mapping[str, DriverSettings], *,
               runs: str | None = None, motion: str | None = None,
               aft: str | None = None,
               takers: Iterable[Callable[[Pairs], None]] = (), sketched: bool = False,
               progress: Callable[[str], None] = lambda text: None) -> Judgement:
    """
    Judge the logs of two sensors, as `judge_bags` judges a bag of them.

    Parameters
    ----------
    ts, rs : str
        Logs of the TS and of the RS.
    settings : Settings
        Settings with the norms.
    drivers : mapping of {'ts', 'rs', 'motion'} to DriverSettings
        How to read each log.
    runs : str, optional
        Table of runs, a csv file; its source is the log of the TS.
    motion : str, optional
        A log with the motion of the ship; by default that of the RS or of the TS, if it has any.
    aft : str, optional
        Log of the aft antenna, if the RS is two antennas; `rs` is that of the fore one.
    takers : iterable of callable
        Each is called with the pairs, chunk by chunk.
    sketched : bool
        Collect the data for the graphs of a report.
    progress : callable
        Called with the progress in words.

    Returns
    -------
    Judgement
        The inputs of the verdict are the two logs; notes say what was taken from each.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If a log cannot be read or has no heading, or the table of runs is wrong.

    """
    Limits.of(settings.norms, settings.model)
    table: list[tuple[int, int]] | None = None
    elsewhere: list[str] = []
    if runs is not None:
        found, elsewhere = assign_runs(read_run_table(runs), [ts])
        table = [(start, stop) for start, stop, _ in found]
    log = {'ts': import_log(ts, drivers['ts'], progress, role='ts', unit=settings.ts_unit),
           'rs': import_log(rs, drivers['rs'], progress, role='rs',
                            unit=settings.rs_unit) if aft is None
           else import_antennas((rs, aft), drivers['rs'], settings.antennas)}
    if ts == rs and log['ts'].headings == log['rs'].headings:
        raise ValueError(f'{ts}: gives the same headings as TS and as RS: {_APART}')
    moved = (find_motion({'ts': ts, 'rs': rs}, drivers, motion) if settings.motion.compare
             else FoundMotion())
    sketch = SeriesSketch(ts) if sketched else None
    takers = list(takers)
    if sketch is not None:
        sketch.take_motion(moved.rows)
        takers.append(partial(sketch.update, settings=settings))
    readings = log['ts'].headings, log['rs'].headings
    comparison = Intercomparison(settings, source=ts, table=table, progress=progress)
    comparison.take_motion(moved.rows)
    for pairs in (comparison.update(*readings), comparison.finish()):
        for take in takers:
            take(pairs)
    results = comparison.results()
    if settings.alignment.skew == 'apply':
        results = judge_aligned(*readings, results, settings, source=ts, motion=moved.rows)
    inputs = [_describe(log[role], role) for role in ROLES]
    notes = [f'{words}: {log[role].path}, {len(log[role].headings)} headings of '
             f'{"; ".join((log[role].sentence or "a csv", *log[role].remarks))}; not taken: '
             f'{log[role].words_not_taken}'
             for role, words in zip(ROLES, ('tested sensor (TS)', 'reference sensor (RS)'))]
    notes += moved.notes
    if not results:
        why = explain_no_run(comparison.ledger, settings, table)
        inputs[0] = replace(inputs[0], no_run=why)
        notes.append(f'{ts}, {rs}: no run: {why}')
    if words := name_apart(*readings, results, settings):
        notes.append(f'{ts}, {rs}: {words}')
    notes += [f'{runs}: source {source} is not the log of the TS' for source in elsewhere]
    verdict = join(results, settings, inputs, incomplete=not results)
    notes += name_outside(verdict)
    earlier = comparison.compliance.take_earlier()
    judged = Found(results, earlier, comparison.ledger, inputs[0],
                   table=None if table is None else tuple(table), motion=moved.rows)
    return Judgement(verdict, tuple(notes), () if sketch is None else (sketch,),
                     tuple(each.verdict for each in earlier),
                     make_account(judged, settings, inputs[1]))


def _describe(log: ImportedLog, role: str) -> Input:
    """Return the entry of a log in the verdict; its topic is the sentence."""
    sentence = log.sentence or 'csv'
    return Input(log.path, log.sha256, sentence if role == 'ts' else None,
                 sentence if role == 'rs' else None, not_taken=dict(log.not_taken))
