# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Whole streams judged; with the time skew between the sensors taken out if asked for."""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

from .intercomparison import Intercomparison, join
from .judge import RunResult
from .records import Headings
from .settings import Settings
from .skew_scan import Scan, scan
from .verdict import Verdict

__all__ = ['aligned', 'analyze']


def aligned(ts: Headings, rs: Headings, results: Sequence[RunResult], settings: Settings, *,
            source: str = '') -> list[RunResult]:
    """
    Pair each run again at the minimum of its skew scan, and judge it again.

    Parameters
    ----------
    ts, rs : Headings
        All readings of an input.
    results : sequence of RunResult
        Its runs as first judged.
    settings : Settings
        `alignment.skew_range_s` is scanned, about `alignment.skew_s`.
    source : str
        Name of the input.

    Returns
    -------
    list of RunResult
        In the same order. A run whose scan has no sure minimum stays as it was, and says so.

    Notes
    -----
    The runs keep their TS readings: their bounds move with the TS stamps.

    References
    ----------
    ``docs/verdict.md``, time skew.

    """
    return [_again(ts, rs, at, results, settings, source) for at in range(len(results))]


def _again(ts: Headings, rs: Headings, at: int, results: Sequence[RunResult],
           settings: Settings, source: str) -> RunResult:
    result = results[at]
    found = _scanned(ts, rs, result, settings)
    if found is None or not found.well_determined:
        why = 'no minimum within the range' if found is None or found.at_edge else 'not sure'
        return _said(result, found, f'not_aligned: the skew scan has {why}; the run is judged '
                     'as its stamps say')
    # The scan knows nothing of the known skew, so it finds all of it.
    shift_ns = round(found.skew_s * 1e9) - round(settings.alignment.skew_s * 1e9)
    table = [(r.verdict.start_ns - shift_ns, r.verdict.end_ns - shift_ns + 1) for r in results]
    moved = replace(settings, alignment=replace(settings.alignment, skew_s=found.skew_s))
    comparison = Intercomparison(moved, source=source, table=table)
    comparison.update(ts, rs)
    comparison.finish()
    starts = [r.verdict.start_ns for r in comparison.results()]
    now = [r for r, start_ns in zip(comparison.results(), starts)
           if table[at][0] <= start_ns < table[at][1]]
    if len(now) != 1:
        return _said(result, found, 'not_aligned: at the skew found the run falls apart; it is '
                     'judged as its stamps say')
    return _said(now[0], found, f'aligned: {found.skew_s:.3f} s are taken from the stamps of '
                 f'the TS; unaligned the outcome was {result.verdict.outcome}')


def _scanned(ts: Headings, rs: Headings, result: RunResult, settings: Settings) -> Scan | None:
    range_ns = round(settings.alignment.skew_range_s * 1e9)
    known_ns = round(settings.alignment.skew_s * 1e9)
    run = result.verdict
    inside = ((ts.stamp_ns - known_ns >= run.start_ns) & (ts.stamp_ns - known_ns <= run.end_ns))
    margin_ns = range_ns + round(settings.pairing.max_gap_s * 1e9) + abs(known_ns)
    near = ((rs.stamp_ns >= run.start_ns - margin_ns) & (rs.stamp_ns <= run.end_ns + margin_ns))
    return scan(ts[inside], rs[near], settings.alignment.skew_range_s)


def _said(result: RunResult, found: Scan | None, words: str) -> RunResult:
    verdict = result.verdict
    return replace(result, verdict=replace(
        verdict, skew=replace(verdict.skew, scan=found), warnings=(*verdict.warnings, words)))


def analyze(ts: Headings | Sequence[Headings], rs: Headings | Sequence[Headings],
            settings: Settings) -> Verdict:
    """
    Judge a TS by an RS.

    Parameters
    ----------
    ts, rs : Headings, or equally long lists of them
        Readings of the two sensors; in lists, each element is an input of its own.
    settings : Settings
        With the norms.

    Returns
    -------
    Verdict
        On all runs of all inputs.

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
    ts = [ts] if isinstance(ts, Headings) else list(ts)
    rs = [rs] if isinstance(rs, Headings) else list(rs)
    if len(ts) != len(rs):
        raise ValueError(f'{len(ts)} TS inputs but {len(rs)} RS inputs: give one RS for each TS')
    results = []
    for ts_part, rs_part in zip(ts, rs):
        comparison = Intercomparison(settings)
        comparison.update(ts_part, rs_part)
        comparison.finish()
        found = comparison.results()
        if settings.alignment.skew == 'apply':
            found = aligned(ts_part, rs_part, found, settings)
        results += found
    return join(results, settings)
