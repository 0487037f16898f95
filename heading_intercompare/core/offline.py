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

"""Judges whole streams, with the time skew between the sensors removed on request."""

from __future__ import annotations

from dataclasses import replace
from typing import Mapping, NamedTuple, Sequence

import numpy as np

from heading_intercompare.core.pairing.ledger import LedgerKey
from heading_intercompare.core.pairing.stream_pieces import cut_streams
from heading_intercompare.core.timing.clock_search import find_apart
from heading_intercompare.core.timing.heading_track import Track
from heading_intercompare.core.timing.skew_scan import Scan, scan_skew
from heading_intercompare.core.timing.skew_search import REACH_S
from heading_intercompare.core.verdict.judge import RunResult

from .pipeline import Intercomparison
from .records import Headings, Integers, Losses, Motion, Quality
from .settings import LARGEST_SKEW_S, Pairing, Settings

_LEAST_READINGS = 64
_SHOWS_NONE = ('no_fit', 'too_few')

_NO_RUN = ('not_aligned: with latency or clock offset removed the run no longer pairs as one run; '
           'it is judged with its stamps unchanged')


class _Beside(NamedTuple):
    """What is judged with the readings: as for `judge_aligned`."""

    source: str
    lost: Sequence[tuple[LedgerKey, Losses]]
    motion: Sequence[Motion]
    quality: Mapping[str, Quality]


def judge_aligned(ts: Headings, rs: Headings, results: Sequence[RunResult], settings: Settings, *,
                  source: str = '', lost: Sequence[tuple[LedgerKey, Losses]] = (),
                  motion: Sequence[Motion] = (),
                  quality: Mapping[str, Quality] | None = None) -> list[RunResult]:
    """
    Remove the time skew of each run, then pair and judge it again.

    Parameters
    ----------
    ts, rs
        All readings of an input.
    results
        Its runs as first judged.
    settings
        The search covers `alignment.skew_range_s` on both sides of `alignment.skew_s`, and
        `alignment.clock_range_s` for clocks that lie apart.
    source
        Name of the input.
    lost
        What is missing from it, and how it was lost.
    motion
        The motion of the ship, in chunks.
    quality
        What ``'ts'`` and ``'rs'`` say of their readings.

    Returns
    -------
    list of RunResult
        In the same order. A run whose skew is not well determined stays unchanged, with a
        warning that says why.

    Notes
    -----
    The skew is that of the regression. The scan is shown for comparison only: interpolation
    averages the noise of the RS, which shifts the minimum of the scan. A run keeps its TS
    readings, so its bounds move with the TS stamps. Each run is paired from its own readings
    alone. Clocks that lie apart are moved first, and the skew is that of the moved pairs; then
    there is no scan.

    References
    ----------
    ``docs/verdict.md``, time skew.

    """
    beside = _Beside(source, lost, motion, quality or {})
    return [_judge_again(ts, rs, result, settings, beside) for result in results]


def _judge_again(ts: Headings, rs: Headings, result: RunResult, settings: Settings,
                 beside: _Beside) -> RunResult:
    apart_s = _find_apart(ts, rs, result, settings)
    begun: RunResult | None = result
    if apart_s:
        begun = _pair_again(ts, rs, result, settings, beside, apart_s)
    ts_then, rs_then = _readings_of(ts, rs, result, settings, 0.0)
    scan = None if apart_s else scan_skew(ts_then, rs_then, settings.alignment.skew_range_s)
    if begun is None:
        return _note_alignment(result, scan, _NO_RUN)
    estimate = begun.verdict.skew.estimate
    if not estimate.well_determined or estimate.skew_s is None:
        why = estimate.why_not(settings.alignment.skew_range_s)
        return _note_alignment(result, scan,
                               f'not_aligned: {why}; the run is judged with its stamps unchanged')
    shift_s = apart_s + round(estimate.skew_s * 1e9) / 1e9
    again = _pair_again(ts, rs, result, settings, beside, shift_s)
    if again is None:
        return _note_alignment(result, scan, _NO_RUN)
    return _note_alignment(
        again, scan, f'aligned: {settings.alignment.skew_s + shift_s:.3f} s are subtracted from '
        f'the TS stamps; without this the outcome was {result.verdict.outcome}')


def _find_apart(ts: Headings, rs: Headings, result: RunResult, settings: Settings) -> float:
    """
    Return a skew beyond the range of the estimate, seconds; 0 if there is none.

    The pairs show such a skew only if both sensors share enough pairs. So the readings are
    searched if the pairs show no skew at all.
    """
    rule, estimate = settings.alignment, result.verdict.skew.estimate
    apart_s = estimate.beyond_s
    if apart_s is None and not estimate.well_determined and rule.clock_range_s > REACH_S:
        apart_s = _search(*_readings_of(ts, rs, result, settings, rule.clock_range_s), settings)
    if apart_s is None or abs(apart_s) > max(REACH_S, rule.clock_range_s) or (
            abs(apart_s + rule.skew_s) > LARGEST_SKEW_S - rule.skew_range_s):
        return 0.0
    return round(apart_s, 9)


def _search(ts: Headings, rs: Headings, settings: Settings) -> float | None:
    """Return the skew beyond a minute at which the motion in all readings agrees, seconds."""
    origin_ns = int(ts.stamp_ns[0]) if len(ts) else 0
    ts_track = Track(ts, origin_ns + round(settings.alignment.skew_s * 1e9))
    rs_track = Track(rs, origin_ns)
    if min(len(ts_track), len(rs_track)) < _LEAST_READINGS:
        return None
    _, offset = find_apart(ts_track, rs_track, settings.alignment.clock_range_s,
                           settings.pairing.longest_gap_s)
    return None if offset is None else offset.skew_s


def name_apart(ts: Headings, rs: Headings, results: Sequence[RunResult],
               settings: Settings) -> str:
    """
    Say how far the clocks of an input lie apart if its pairs cannot show it.

    Parameters
    ----------
    ts, rs
        All readings of an input, with a partner or without.
    results
        Its runs as judged; may be empty.
    settings
        The search covers `alignment.clock_range_s`.

    Returns
    -------
    str
        Empty if each run shows its skew, or if the readings show none, either.

    """
    rule = settings.alignment
    shown = results and all(result.verdict.skew.estimate.kind not in _SHOWS_NONE
                            for result in results)
    if shown or rule.skew == 'off' or rule.clock_range_s <= REACH_S:
        return ''
    apart_s = _search(ts, rs, settings)
    if apart_s is None:
        return ''
    return (f'the clock of the {"RS" if apart_s > 0.0 else "TS"} lags by about '
            f'{abs(apart_s):.1f} s by the motion in all readings: alignment.skew_s = '
            f'{rule.skew_s + apart_s:.1f} pairs them')


def _pair_again(ts: Headings, rs: Headings, result: RunResult, settings: Settings,
                beside: _Beside, shift_s: float) -> RunResult | None:
    """Return a run as judged with a skew removed; None if it does not pair as one run."""
    ts, rs = _readings_of(ts, rs, result, settings, abs(shift_s))
    shift_ns = round(shift_s * 1e9)
    table = [(result.verdict.start_ns - shift_ns, result.verdict.end_ns - shift_ns + 1)]
    moved = replace(settings,
                    alignment=replace(settings.alignment,
                                      skew_s=settings.alignment.skew_s + shift_ns / 1e9),
                    pairing=_fix_method(result, settings.pairing),
                    runs=replace(settings.runs, stabilization_s=result.stabilization_s))
    comparison = Intercomparison(moved, source=beside.source, table=table)
    for rows in beside.motion:
        comparison.take_motion(rows)
    for stream, said in beside.quality.items():
        comparison.take_quality(stream, said)
    late_ns = {'ts': round(moved.alignment.skew_s * 1e9)}
    for piece in cut_streams({'ts': ts, 'rs': rs}, late_ns):
        comparison.update(piece['ts'], piece['rs'])
    for key, losses in beside.lost:
        within = (losses.stamp_ns >= result.verdict.start_ns) & (
            losses.stamp_ns <= result.verdict.end_ns)
        comparison.lose(key, losses[within])
    comparison.finish()
    now = comparison.results()
    if len(now) != 1:
        return None
    # The table that selects the run leaves out its margins; the record as it is has them apart.
    again = replace(now[0], pieces=(), outside=result.outside, verdict=replace(
        now[0].verdict, clock_segment=result.verdict.clock_segment))
    if again.share is None or again.share.set_backs or result.share is None:
        return again
    return replace(again, share=replace(again.share, set_backs=result.share.set_backs)).conclude()


def _fix_method(result: RunResult, rule: Pairing) -> Pairing:
    """Replace the method 'auto' by the one that it chose in a run."""
    sensor = result.verdict.pairing.find_interpolated(rule.method)
    if sensor is None:
        return rule
    return replace(rule, method='interpolate' if sensor == 'rs' else 'interpolate_ts')


def _readings_of(ts: Headings, rs: Headings, result: RunResult, settings: Settings,
                 apart_s: float) -> tuple[Headings, Headings]:
    """Return the TS readings of a run, and the RS readings up to range and `apart_s` away."""
    known_ns = round(settings.alignment.skew_s * 1e9)
    run = result.verdict
    margin_ns = (round((settings.alignment.skew_range_s + apart_s) * 1e9) + abs(known_ns)
                 + round(settings.pairing.longest_gap_s * 1e9))
    return (_between(ts, run.start_ns + known_ns, run.end_ns + known_ns),
            _between(rs, run.start_ns - margin_ns, run.end_ns + margin_ns))


def _between(headings: Headings, first_ns: int, last_ns: int) -> Headings:
    """Return the readings with stamps in a closed interval."""
    stamp_ns = headings.stamp_ns
    if _rises(stamp_ns):
        lo, hi = np.searchsorted(stamp_ns, first_ns), np.searchsorted(stamp_ns, last_ns, 'right')
        return headings[lo:hi]
    return headings[(stamp_ns >= first_ns) & (stamp_ns <= last_ns)]


def _rises(stamp_ns: Integers) -> bool:
    return bool((stamp_ns[1:] >= stamp_ns[:-1]).all())


def _note_alignment(result: RunResult, scan: Scan | None, words: str) -> RunResult:
    verdict = result.verdict
    return replace(result, verdict=replace(
        verdict, skew=replace(verdict.skew, scan=scan), warnings=(*verdict.warnings, words)))
