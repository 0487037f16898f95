# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Which share of the readings a run could not use: lost, rejected, or without partner."""

from __future__ import annotations

from typing import Iterator, Sequence

from heading_intercompare.core.pairing.ledger import LedgerKey, LedgerSegment
from heading_intercompare.core.settings import Settings

from .validity import DOUBTFUL, Finding, HOLDS, NOT_TESTABLE, VOID
from .verdict_document import RunVerdict

__all__ = ['find_losses', 'judge_losses']


def find_losses(run: RunVerdict, share: LedgerSegment | None, inside: LedgerSegment | None,
                settings: Settings) -> Finding:
    """
    Judge what a run could not use.

    Parameters
    ----------
    run : RunVerdict
        Of which the number and the stamps of the differences are used.
    share, inside : LedgerSegment or None
        What became of the readings of the run, and of those between its first and its last pair;
        None while that is not known, as at a look: then the gaps between the pairs alone are
        judged.
    settings : Settings
        `detectors.lost_doubtful` and `detectors.lost_void`.

    """
    shares = list(_lost_shares(run))
    if share is not None and inside is not None:
        shares += _ledger_shares(run, share, inside, settings)
    return judge_losses(shares, settings)


def _lost_shares(run: RunVerdict) -> Iterator[tuple[str, float]]:
    """Yield the share of the pairs that gaps between them leave out, if it can be told."""
    lost = run.correlation.stamps.lost_share
    if lost is not None:
        yield 'lost', lost


def _ledger_shares(run: RunVerdict, share: LedgerSegment, inside: LedgerSegment,
                   settings: Settings) -> Iterator[tuple[str, float]]:
    """Yield what the ledger says is lost, in words, and its share of the readings."""
    counts = inside.counts
    received = {stream: inside.received(stream) for stream in ('ts', 'rs')}
    for stream, n in received.items():
        # After a stamp of the future no reading makes a pair any more: the run ends there, but
        # not for want of readings.
        late = LedgerKey.of_rejected(stream, 'stamp_not_increasing')
        behind = share.counts.get(late, 0) - counts.get(late, 0)
        if n + behind:
            rejected = sum(inside.rejected(stream).values())
            yield f'of the {stream.upper()} rejected', (rejected + behind) / (n + behind)
    unpaired = {stream: counts.get(key, 0) / received[stream]
                for stream, key in (('ts', LedgerKey.TS_UNPAIRED), ('rs', LedgerKey.RS_UNUSED))
                if received[stream]}
    if unpaired:
        # Of a sensor that is interpolated, most readings may lie between two stamps of the other.
        interpolated = run.pairing.interpolated(settings.pairing.method)
        kept = [part for stream, part in unpaired.items() if stream != interpolated]
        yield 'without partner', min(kept or unpaired.values())


def judge_losses(shares: Sequence[tuple[str, float]], settings: Settings) -> Finding:
    """
    Return the finding on shares of lost readings.

    Parameters
    ----------
    shares : sequence of (str, float)
        What is lost, in words, and its share of the readings inside the run.
    settings : Settings
        `detectors.lost_doubtful` and `detectors.lost_void`.

    """
    if not shares:
        return Finding('losses', NOT_TESTABLE, '', 'there are too few pairs to see what is lost')
    what, share = max(shares, key=lambda row: row[1])
    evidence = ', '.join(f'{name} {100.0 * part:.2g} %' for name, part in shares)
    words = f'{100.0 * share:.0f} % {what}'
    if share > settings.detectors.lost_void:
        return Finding('losses', VOID, words, evidence)
    if share > settings.detectors.lost_doubtful:
        return Finding('losses', DOUBTFUL, words, evidence)
    return Finding('losses', HOLDS, '', evidence)
