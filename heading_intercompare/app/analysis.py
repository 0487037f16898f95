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

"""The analysis of readings, of a bag, or of a campaign of several, to one verdict."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
import os
from typing import Callable, Iterable, Sequence
import warnings

from heading_intercompare.bags.csv.pairs_account import PairsAccount
from heading_intercompare.core import offline
from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.pipeline import join
from heading_intercompare.core.records import Headings, Motion, Pairs
from heading_intercompare.core.settings import Settings
from heading_intercompare.core.verdict.verdict_document import RunVerdict, Verdict
from heading_intercompare.report import SeriesSketch
from heading_intercompare.report.figures.notebook import Plotter

from .campaign import judge_inputs
from .run_table import assign_runs, name_outside, read_run_table, RunTable

__all__ = ['analyze', 'analyze_bag', 'analyze_bags', 'judge_bags', 'Judgement']

Place = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Judgement:
    """
    The verdict on recorded runs, with notes.

    Attributes
    ----------
    verdict : Verdict
        On all runs of all inputs; not compliant if an input could not be judged.
    notes : tuple of str
        What the user should know about the inputs: unfinished bag, no run, not judged again.
    sketches : tuple of SeriesSketch
        Data for the graphs of a report, one per input that was read; empty unless requested.
    earlier : tuple of RunVerdict
        Runs that the verdict does not cover because they are too old (`runs.keep`).
    account : PairsAccount or None
        What belongs beside a csv of the pairs; None of several inputs.

    """

    verdict: Verdict
    notes: tuple[str, ...] = ()
    sketches: tuple[SeriesSketch, ...] = ()
    earlier: tuple[RunVerdict, ...] = ()
    account: PairsAccount | None = None


def judge_bags(paths: Sequence[Place], settings: Settings, *,
               runs: Place | RunTable | None = None, executor: Executor | None = None,
               jobs: int | None = None, takers: Iterable[Callable[[Pairs], None]] = (),
               sketched: bool = False,
               progress: Callable[[str], None] = lambda text: None) -> Judgement:
    """
    Judge recorded runs, as the command ``analyze`` does.

    Parameters
    ----------
    paths : sequence of path
        ``.mcap`` files, rosbag2 directories, ``.csv`` files of pairs or journals, at least one.
    settings : Settings
        Settings with the norms.
    runs : path or sequence of (start_ns, stop_ns, source), optional
        Table of runs, or the csv file that holds it; see `read_run_table`. Without one, marks in
        the bag and silences decide.
    executor : concurrent.futures.Executor, optional
        Judges the inputs; see `judge_inputs`.
    jobs : int, optional
        Processes on this machine, without an executor; by default one per core.
    takers : iterable of callable
        Each is called with the pairs, chunk by chunk; for one input, and not with an executor.
    sketched : bool
        Collect the data for the figures of the report and of `Verdict.plot`.
    progress : callable
        Called with the progress in words.

    Returns
    -------
    Judgement

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If no input can be read, or the table of runs is wrong.

    """
    if isinstance(paths, (str, os.PathLike)) or not paths:
        raise ValueError(f'paths = {paths!r}: must be a list of at least one path')
    # Check the norms now; otherwise every input would be reported as unreadable.
    Limits.of(settings.norms, settings.model)
    names = [os.fspath(path) for path in paths]
    table: RunTable | None = None
    elsewhere: list[str] = []
    if runs is not None:
        given = read_run_table(os.fspath(runs)) if isinstance(runs, (str, os.PathLike)) else runs
        table, elsewhere = assign_runs(given, names)
    judged = judge_inputs(names, settings, table, takers=takers, sketched=sketched, jobs=jobs,
                          executor=executor, progress=progress)
    verdict = join([result for each in judged for result in each.results], settings,
                   [each.description for each in judged],
                   incomplete=any(each.error or each.no_run for each in judged))
    called = os.fspath(runs) if isinstance(runs, (str, os.PathLike)) else 'runs'
    notes = [note for each in judged for note in each.notes]
    notes += [f'{called}: source {source} is not one of the INPUTs' for source in elsewhere]
    notes += name_outside(verdict)
    sketches = tuple(each.sketch for each in judged if each.sketch)
    if sketches:
        verdict = replace(verdict, plotter=Plotter(sketches))
    return Judgement(verdict, tuple(notes), sketches,
                     tuple(run for each in judged for run in each.earlier),
                     judged[0].account if len(judged) == 1 else None)


def analyze(ts: Headings | Sequence[Headings], rs: Headings | Sequence[Headings],
            settings: Settings, *,
            motion: Motion | Sequence[Motion | None] | None = None) -> Verdict:
    """
    Judge a TS against an RS.

    Parameters
    ----------
    ts, rs : Headings, or equally long lists of them
        Readings of the two sensors; each element of a list is a separate input.
    settings : Settings
        Must hold the norms.
    motion : Motion, or a list as long as those of the sensors, optional
        The motion of the ship, against which the headings are checked.

    Returns
    -------
    Verdict
        The verdict on all runs of all inputs; never compliant if an input has no run. Its `plot`
        draws the figures.

    Raises
    ------
    SettingsError
        If a norm is missing.
    ValueError
        If the lists differ in length.

    References
    ----------
    GK (1)-(7); the guarded decision of ``docs/verdict.md``.

    """
    sketches: dict[int, SeriesSketch] = {}

    def take(at: int, pairs: Pairs) -> None:
        if at not in sketches:
            sketches[at] = SeriesSketch()
            told = motion if motion is None or isinstance(motion, Motion) else motion[at]
            if told is not None:
                sketches[at].take_motion(told)
        sketches[at].update(pairs, settings)

    verdict = offline.analyze(ts, rs, settings, take, motion=motion)
    return replace(verdict, plotter=Plotter(tuple(sketches.values())))


def analyze_bag(path: Place, settings: Settings, *, runs: Place | RunTable | None = None,
                jobs: int | None = None,
                progress: Callable[[str], None] = lambda text: None) -> Verdict:
    """
    Judge the runs of one recording.

    Parameters
    ----------
    path : path
        ``.mcap`` file, rosbag2 directory, ``.csv`` file of pairs or journal of a live run.
    settings, runs, jobs, progress
        As for `judge_bags`.

    Returns
    -------
    Verdict
        The verdict of ``analyze``. Notes on the recording are issued as warnings.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If the recording cannot be read, or the table of runs is wrong.

    """
    return _warn(judge_bags([path], settings, runs=runs, jobs=jobs, sketched=True,
                            progress=progress))


def analyze_bags(paths: Sequence[Place], settings: Settings, *,
                 runs: Place | RunTable | None = None, executor: Executor | None = None,
                 jobs: int | None = None,
                 progress: Callable[[str], None] = lambda text: None) -> Verdict:
    """
    Judge the runs of several recordings together.

    Parameters
    ----------
    paths, settings, runs, executor, jobs, progress
        As for `judge_bags`, which also returns the notes and the graphs.

    Returns
    -------
    Verdict
        The verdict of ``analyze``. An unreadable recording does not stop the others, but then the
        verdict is not compliant. Notes on the recordings are issued as warnings.

    Raises
    ------
    SettingsError
        If a norm is missing.
    OSError, ValueError
        If no recording can be read, or the table of runs is wrong.

    """
    return _warn(judge_bags(paths, settings, runs=runs, executor=executor, jobs=jobs,
                            sketched=True, progress=progress))


def _warn(judgement: Judgement) -> Verdict:
    """Issue the notes as warnings at the caller of the caller; return the verdict."""
    for note in judgement.notes:
        warnings.warn(note, stacklevel=3)
    return judgement.verdict
