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

"""Joins the stages: pairs to runs, runs to a verdict; live, in replay and offline."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Callable, Iterator, Sequence

from heading_intercompare.core.decision.criteria import Limits, require_norms
from heading_intercompare.core.decision.sequential import (
    find_standing,
    Look,
    LookVerdict,
    risk_at_the_end,
)
from heading_intercompare.core.decision.taken_out import Stretch
from heading_intercompare.core.motion.motion_record import RunMotion
from heading_intercompare.core.pairing.difference import subtract
from heading_intercompare.core.pairing.incarnations import Incarnations
from heading_intercompare.core.pairing.ledger import Ledger, LedgerKey, LedgerSegment
from heading_intercompare.core.pairing.pair_maker import PairMaker
from heading_intercompare.core.pairing.pair_sampling import PairSampler
from heading_intercompare.core.pairing.pairer import Pairer
from heading_intercompare.core.runs.growing_columns import Keep
from heading_intercompare.core.runs.live_figures import (
    compute_figures,
    compute_run_figures,
    name_moments,
)
from heading_intercompare.core.runs.rolling_window import Rolling
from heading_intercompare.core.runs.run_cutter import RunCutter
from heading_intercompare.core.runs.run_quality import RunQuality
from heading_intercompare.core.runs.run_series import RunSeries
from heading_intercompare.core.verdict.all_runs import join
from heading_intercompare.core.verdict.judge import judge_run, look_at, RunResult
from heading_intercompare.core.verdict.verdict_document import (
    Input,
    mark_intermediate,
    Verdict,
)

from .kept_state import KeptState
from .records import Differences, Headings, Losses, Motion, Pairs, Quality
from .segment_runs import SegmentRuns
from .settings import Settings


class Compliance:
    """
    Cut pairs into runs and judge each run at its end.

    Parameters
    ----------
    settings
        Must hold the norms.
    source
        Name of the input, stated with each run.
    table : sequence of (start_ns, stop_ns), optional
        Start and stop of each run. Without a table, marks decide; without marks the first pair
        opens a run.
    keeper
        Returns the store for the pages of a run (see `Column`), so that memory does not grow
        during the run. Without it all pages stay in memory.
    progress
        Called with the progress in words while a run is judged.
    thins
        The pairs are chosen out of more: gaps between them are not lost.

    Attributes
    ----------
    motion : RunMotion
        The motion of the ship during the run in progress.
    quality : RunQuality
        What the sensors say of their readings during it.
    rolling : Rolling
        The rolling window.

    Raises
    ------
    SettingsError
        If a norm is missing, or a risk is too small to share among the looks.

    Notes
    -----
    Time comes from the stamps alone; nothing here reads a clock. So a replay at any rate, or an
    analysis of the recording, gives the live verdict.

    """

    def __init__(self, settings: Settings, *, source: str = '',
                 table: Sequence[tuple[int, int]] | None = None,
                 keeper: Callable[[], Keep | None] = lambda: None,
                 progress: Callable[[str], None] = lambda text: None,
                 thins: bool = False) -> None:
        self.settings = settings
        self._keeper, self._progress, self._thins = keeper, progress, thins
        self.newest_ns: int | None = None
        require_norms(settings.norms, settings.model)
        # A risk that is too small for the looks is refused before the first pair.
        risk_at_the_end(settings)
        # The limits of the newest run also serve the rolling window, which ends in it.
        self._limits: Limits | None = None
        self._source = source
        self._cutter = RunCutter(settings.runs, table)
        # The clock segments that have ended, and the present one.
        self._closed: list[SegmentRuns] = []
        self._runs = SegmentRuns(settings, 0)
        self._outside = 'not in the table of runs' if table is not None else ''
        # Pairs of the segment before the run in progress.
        self._first_pair = 0
        self._run: RunSeries | None = None
        self._run_key: int | None = None
        self._looks: list[LookVerdict] = []
        # How many runs were too old for the verdict.
        self._n_earlier = 0
        self.rolling = Rolling(settings.window_s)
        self.motion = RunMotion(keeper)
        self.quality = RunQuality(keeper)

    def take_quality(self, stream: str, quality: Quality) -> None:
        """Take what ``'ts'`` or ``'rs'`` says of its readings, before their run ends."""
        self.quality.take(stream, quality)

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship, before the run that it belongs to ends; in any order."""
        self.motion.take(motion)

    def forget(self) -> None:
        """Forget motion and quality that are older than any run to come."""
        self.motion.forget(self.run_start_ns)
        self.quality.forget(self.run_start_ns)

    def update(self, pairs: Pairs) -> None:
        """
        Take pairs in the order of their segments and stamps; judge the runs that end with them.

        A new segment ends the run: a clock was set back.
        """
        for part in pairs.in_segments():
            if int(part.segment[0]) != self.segment:
                self._begin_segment(int(part.segment[0]))
            self._update(part)

    @property
    def segment(self) -> int:
        """Return the number of the clock segment of the newest pair."""
        return self._runs.number

    def _begin_segment(self, number: int) -> None:
        self._end_run()
        self._closed.append(self._runs)
        self._runs, self._first_pair = SegmentRuns(self.settings, number), 0
        self._cutter.begin_segment()
        self.rolling.clear()
        self.motion.begin_segment()

    def _update(self, pairs: Pairs) -> None:
        differences = self._subtract(pairs)
        for piece in self._cutter.update(pairs.stamp_ns):
            if self._run is None or piece.key != self._run_key:
                self._end_run()
                self._run = self._begin_run(piece.key, piece.cut_ns, piece.since_ns)
                self._first_pair = self._runs.record.n + piece.lo
            self._run.update(pairs[piece.lo:piece.hi], differences[piece.lo:piece.hi])
        self._runs.record.update(pairs, differences)
        self.rolling.update(differences)
        self.newest_ns = int(pairs.stamp_ns[-1])
        self._end_run_if_cut()

    def _subtract(self, pairs: Pairs) -> Differences:
        return subtract(pairs, self.settings.installation_offset_deg,
                        self.settings.wrap_center_deg)

    def _begin_run(self, key: int, cut_ns: int, since_ns: int) -> RunSeries:
        self._run_key = key
        return RunSeries(cut_ns, self.settings, self._look, self._keeper(), since_ns)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Start or stop a run after the pair with this stamp; see `RunCutter.mark`."""
        self._outside = self._outside or 'outside the marks'
        if self._cutter.mark(kind, stamp_ns):
            for runs in (*self._closed, self._runs):
                runs.withdraw()
            self._n_earlier = 0
            self._run = self._run_key = None
            self._looks = []
        self._end_run_if_cut()

    def finish(self) -> None:
        """End the run in progress and judge it."""
        self._end_run()

    def keep(self) -> KeptState:
        """Return what is needed to go on later, apart from the pairs of the run in progress."""
        return KeptState(
            cutter=self._cutter.state, newest_ns=self.newest_ns, in_run=self._run is not None,
            segments=tuple(runs.state for runs in (*self._closed, self._runs)),
            n_earlier=self._n_earlier, outside=self._outside, first_pair=self._first_pair)

    def go_on(self, state: KeptState, pairs: Pairs) -> None:
        """
        Go on from the state of another `Compliance` with the same settings.

        Parameters
        ----------
        state
            Of `keep`.
        pairs
            All pairs that the run in progress had then; none if there was no run.

        """
        self._cutter.go_on(state.cutter)
        self.newest_ns, self._n_earlier = state.newest_ns, state.n_earlier
        self._outside, self._first_pair = self._outside or state.outside, state.first_pair
        *self._closed, self._runs = (SegmentRuns.from_state(segment, self.settings)
                                     for segment in state.segments)
        for runs in (*self._closed, self._runs):
            for result, _ in runs.finished:
                self.motion.end_run(result.verdict.end_ns)
        if self._closed:
            self.motion.begin_segment()
        cut_ns = state.cutter.cut_ns
        if state.in_run and cut_ns is not None:
            differences = self._subtract(pairs)
            self._run = self._begin_run(state.cutter.key, cut_ns, state.cutter.since_ns)
            self._run.update(pairs, differences)
            self.rolling.update(differences)

    @property
    def run_start_ns(self) -> int | None:
        """Stamp of the first pair of the run in progress; None outside runs."""
        return None if self._run is None else self._run.start_ns

    @property
    def n_in_run(self) -> int:
        """Return the number of pairs in the run in progress; 0 outside runs."""
        return 0 if self._run is None else self._run.n_input

    def preview(self, ledger: Ledger | None = None) -> Verdict:
        """Return the verdict that a stop now would give."""
        runs = self._runs.copy()
        if self._run is not None:
            self._judge(self._run, runs)
        return mark_intermediate(join(self._divide(ledger, runs, None)[1], self.settings))

    def _look(self, run: RunSeries, look: Look, looks: int) -> None:
        """Judge the run in progress; the last of all looks is the end of the run."""
        if look.index < looks - 1:
            self._looks.append(look_at(run, look, looks, self.settings,
                                       self.motion.by_thing(), self.quality.by_stream()))

    @property
    def early(self) -> LookVerdict | None:
        """Return the result after the looks at the current run; None until one decides."""
        return find_standing(self._looks)

    def _end_run_if_cut(self) -> None:
        if self._run is not None and self._cutter.current != self._run_key:
            self._end_run()

    def _end_run(self) -> None:
        run = self._run
        if run is not None and self._judge(run, self._runs):
            newest, _ = self._runs.finished[-1]
            self._limits = newest.limits
            self.motion.end_run(newest.verdict.end_ns)
        self._run = self._run_key = None
        self._looks = []

    def _judge(self, run: RunSeries, runs: SegmentRuns) -> bool:
        """Judge a run as it is; add it to those that are finished, or to those too short."""
        if run.start_ns is None or run.end_ns is None:
            return False
        if run.end_ns - run.start_ns < round(self.settings.runs.min_duration_s * 1e9):
            runs.short.append(Stretch(run.start_ns, run.end_ns,
                                      'shorter than runs.min_duration_s', run.n_input))
            return False
        number = 1 + sum(len(segment.finished) for segment in (*self._closed, runs))
        result = judge_run(
            run, self.settings, number, self._source, looks=self._looks,
            motion=self.motion.by_thing(), quality=self.quality.by_stream(),
            progress=lambda share: self._progress(f'{share:.0%} of run {number} judged'))
        result = replace(result, first_pair=self._first_pair, verdict=replace(
            result.verdict, clock_segment=runs.number or None))
        if self._thins:
            result = result.without_lost_share()
        runs.finished.append((result, run.cut_ns))
        return True

    @property
    def finished_runs(self) -> int:
        """Return the number of runs judged so far."""
        return self._n_earlier + sum(len(runs.finished) for runs in (*self._closed, self._runs))

    @property
    def cuts(self) -> dict[int, list[int]]:
        """Stamps of the cuts that opened the runs judged so far, by clock segment."""
        return {runs.number: [cut_ns for _, cut_ns in runs.finished]
                for runs in (*self._closed, self._runs)}

    def run_figures(self) -> dict[str, Any]:
        """
        Return the figures of the run in progress; ``n`` is 0 outside runs.

        Unless a mark was set (``marked``), the first start takes all before it out of the record.
        """
        run = self._run
        result: dict[str, Any] = {'run': self.finished_runs + 1 if run else 0,
                                  'marked': self._cutter.state.marked}
        if run is None:
            return {**result, 'n': 0}
        result |= {'start_ns': run.start_ns, 'newest_ns': run.end_ns,
                   'ends_ns': self._cutter.next_cut_ns, 'n_input': run.n_input,
                   'n_invalid': run.n_invalid, 'n_stabilization': run.n_stabilization,
                   'next_look_ns': run.next_look_ns}
        if not len(run):
            return {**result, 'n': 0}
        limits = run.limits(self.settings.norms, self.settings.model)
        return result | compute_run_figures(run, limits, self.settings)

    def rolling_figures(self) -> dict[str, Any]:
        """Return the figures of the rolling window; ``n`` is 0 before the first pair."""
        if self.rolling.start_ns is None:
            return {'n': 0}
        if self._run is not None and len(self._run):
            self._limits = self._run.limits(self.settings.norms, self.settings.model)
        elif self._limits is None:
            self._limits = Limits.of(self.settings.norms, self.settings.model)
        return {'start_ns': self.rolling.start_ns, 'newest_ns': self.newest_ns,
                **compute_figures(self.rolling, self._limits, self.settings)}

    def rolling_moments(self) -> dict[str, Any]:
        """Return those of the rolling figures that cost little; ``n`` is 0 before a pair."""
        if self.rolling.start_ns is None:
            return {'n': 0}
        return {'start_ns': self.rolling.start_ns, 'newest_ns': self.newest_ns,
                **name_moments(self.rolling.moments())}

    def results(self, ledger: Ledger | None = None) -> list[RunResult]:
        """
        Return the runs judged so far, each with its share of a ledger.

        Parameters
        ----------
        ledger
            Ledger of the pairer that made the pairs. Without it, the pairs count as all readings
            received.

        Returns
        -------
        list of RunResult
            The runs of the verdict. If the clock cuts runs, these are the runs since
            `runs.keep` cuts; `take_earlier` returns the others, and forgets them. So the memory
            of a node that runs for a year does not grow.

        """
        return self._divide(ledger, self._runs, self._run)[1]

    def take_earlier(self, ledger: Ledger | None = None) -> list[RunResult]:
        """Return the runs that are too old for the verdict, as `results`, and forget them."""
        horizon_ns = self.settings.runs.horizon_ns(self.newest_ns)
        segments = (*self._closed, self._runs)
        if not any(runs.count_old(horizon_ns) for runs in segments):
            return []
        earlier, _ = self._divide(ledger, self._runs, self._run)
        self._n_earlier += len(earlier)
        for runs in segments:
            runs.forget(runs.count_old(horizon_ns))
        self._closed = [runs for runs in self._closed
                        if runs.finished or (runs.record.newest_ns or 0) >= (horizon_ns or 0)]
        return earlier

    def _divide(self, ledger: Ledger | None, current: SegmentRuns, run: RunSeries | None,
                ) -> tuple[list[RunResult], list[RunResult]]:
        """Return the runs too old for the verdict and its runs, with shares of the ledger."""
        segments = (*self._closed, current)
        horizon_ns = self.settings.runs.horizon_ns(self.newest_ns)
        n_old = [runs.count_old(horizon_ns) for runs in segments]
        shared = _share_ledger(ledger, segments, run)
        earlier = [result for of_segment, n in zip(shared, n_old) for result in of_segment[:n]]
        results = [result for of_segment, n in zip(shared, n_old) for result in of_segment[n:]]
        # What the runs of the verdict leave out does not depend on when others were left. The
        # record is told also if nothing is left out here: another input may leave out more.
        pieces = tuple(piece for runs in segments for piece in runs.pieces)
        earlier, results = ([replace(result, pieces=pieces) for result in among]
                            for among in (earlier, results))
        if results:
            results[0] = replace(results[0], outside=tuple(
                stretch for runs, n in zip(segments, n_old) for stretch in runs.list_outside(
                    n, self._first_pair if runs is current and run is not None
                    else runs.record.n, self._outside or 'in no run')))
        notes = [*self._list_notes(segments, len(earlier))]
        return ([_settle(result) for result in earlier],
                [_settle(result, () if at else notes) for at, result in enumerate(results)])

    def _list_notes(self, segments: Sequence[SegmentRuns], n_old: int) -> Iterator[str]:
        """Yield what the user should know of the runs that are not in the verdict."""
        if n_short := sum(runs.n_short for runs in segments):
            yield f'{n_short} pieces shorter than runs.min_duration_s were left out'
        if n_earlier := self._n_earlier + n_old:
            yield (f'earlier_runs: {n_earlier} runs before the newest runs.keep = '
                   f'{self.settings.runs.keep} cuts are not part of this verdict')

    def verdict(self, ledger: Ledger | None = None,
                inputs: Sequence[Input] = ()) -> Verdict:
        """Return the verdict on the runs judged so far."""
        return join(self.results(ledger), self.settings, inputs)


def _share_ledger(ledger: Ledger | None, segments: Sequence[SegmentRuns],
                  run: RunSeries | None) -> list[list[RunResult]]:
    """Return the runs of each clock segment with their shares; `run` is the one in progress."""
    ledgers = [] if ledger is None else ledger.clock_segments
    shared = [runs.share(ledgers[runs.number] if runs.number < len(ledgers) else None,
                         run if runs is segments[-1] else None) for runs in segments]
    with_runs = {runs.number for runs, results in zip(segments, shared) if results}
    if run is not None:
        with_runs.add(segments[-1].number)
    for number in range(segments[0].number, len(ledgers)):
        if number not in with_runs:
            # Its readings belong to the run before, as those between two runs do.
            _add_to_run_before(shared, [runs.number <= number for runs in segments],
                               ledgers[number].clock_segment_total)
    return shared


def _add_to_run_before(shared: Sequence[list[RunResult]], is_before: Sequence[bool],
                       counts: LedgerSegment) -> None:
    """Add counts to the share of the last run of the segments before, or of the first run."""
    before = [results for results, earlier in zip(shared, is_before) if results and earlier]
    after = [results for results in shared if results]
    results, at = (before[-1], -1) if before else (after[0] if after else [], 0)
    if results and (share := results[at].share) is not None:
        results[at] = replace(results[at], share=share.with_counts_of(counts))


def _settle(result: RunResult, notes: Sequence[str] = ()) -> RunResult:
    """Return a run that has its share with what that says, and with notes as warnings."""
    assert result.share is not None and result.inside is not None
    return result.with_pairing(result.share, result.inside, notes).with_evidence()


class Intercomparison:
    """
    Pair two streams and judge the pairs, in one process.

    Parameters
    ----------
    settings
        Must hold the norms.
    source, table, keeper, progress
        As for `Compliance`.
    sampler
        Chooses the pairs to judge; by default all are judged. Every reading is paired and
        accounted for in either case.

    Attributes
    ----------
    compliance : Compliance
        Judges the pairs.
    maker : PairMaker
        Makes them.

    Examples
    --------
    >>> import numpy as np
    >>> stamps = 10 ** 18 + np.arange(1000) * 10 ** 9
    >>> rs = Headings.of(stamps, np.full(1000, 90.0))
    >>> ts = Headings.of(stamps, 90.0 + 0.1 * np.random.default_rng(1).standard_normal(1000))
    >>> comparison = Intercomparison(Settings.from_mapping(
    ...     {'norms': {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}}))
    >>> _ = comparison.update(ts=ts, rs=rs)
    >>> _ = comparison.finish()
    >>> comparison.verdict().outcome.value
    'compliant'

    """

    def __init__(self, settings: Settings, *, source: str = '',
                 table: Sequence[tuple[int, int]] | None = None,
                 keeper: Callable[[], Keep | None] = lambda: None,
                 progress: Callable[[str], None] = lambda text: None,
                 sampler: PairSampler | None = None) -> None:
        self.compliance = Compliance(settings, source=source, table=table, keeper=keeper,
                                     progress=progress, thins=sampler is not None)
        self._table, self._before = table or (), Incarnations()
        self.maker = PairMaker(self._make_pairer(), sampler)

    def _make_pairer(self) -> Pairer:
        pairer = Pairer(self.compliance.settings)
        for cut_ns in (edge_ns for span in self._table for edge_ns in span):
            pairer.ledger.cut_run(cut_ns)
        return pairer

    @property
    def pairer(self) -> Pairer:
        """Return what pairs the readings."""
        return self.maker.pairer

    def begin_again(self) -> Pairs:
        """Go on with the runs as after a restart of both nodes; return the last pairs before."""
        pairs = self.pairer.flush()
        self.compliance.update(self.maker.choose(pairs))
        self._before.take(self.pairer.ledger, False, len(self._before))
        self.maker.pairer = self._make_pairer()
        return pairs

    @property
    def ledger(self) -> Ledger:
        """Return the account of every reading so far."""
        if not len(self._before):
            return self.pairer.ledger
        whole = self._before.copy()
        whole.take(self.pairer.ledger, True, len(self._before))
        return whole.total or self.pairer.ledger

    def take_motion(self, motion: Motion) -> None:
        """Take motion of the ship; see `Compliance.take_motion`."""
        self.compliance.take_motion(motion)

    def take_quality(self, stream: str, quality: Quality) -> None:
        """Take what a sensor says of its readings; see `Compliance.take_quality`."""
        self.compliance.take_quality(stream, quality)

    def update(self, ts: Headings | None = None, rs: Headings | None = None,
               now_s: float | None = None) -> Pairs:
        """Take readings; return the pairs that they complete. `now_s` as for `Pairer.update`."""
        pairs = self.pairer.update(ts, rs, now_s)
        self.compliance.update(self.maker.choose(pairs))
        return pairs

    def lose(self, key: LedgerKey, losses: Losses) -> None:
        """Count readings that never came; see `Pairer.lose`."""
        self.pairer.lose(key, losses)

    def mark(self, kind: str, stamp_ns: int) -> None:
        """Start or stop a run after the pair with this stamp."""
        self.pairer.ledger.cut_run(stamp_ns + 1)
        self.compliance.mark(kind, stamp_ns)

    def finish(self) -> Pairs:
        """End both streams and the run in progress; return the last pairs."""
        pairs = self.pairer.flush()
        self.compliance.update(self.maker.choose(pairs, end=True))
        self.compliance.finish()
        return pairs

    def results(self) -> list[RunResult]:
        """Return the runs judged so far, to `join` with those of other inputs."""
        return self.compliance.results(self.ledger)

    def verdict(self, inputs: Sequence[Input] = ()) -> Verdict:
        """Return the verdict on the runs judged so far."""
        return join(self.results(), self.compliance.settings, inputs)
