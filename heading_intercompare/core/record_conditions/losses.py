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

"""The share of readings that a run could not use: lost, rejected, or without partner."""

from __future__ import annotations

from typing import Iterator, Sequence

from heading_intercompare.core.pairing.ledger import LedgerKey, LedgerSegment
from heading_intercompare.core.validity.condition import (
    Condition,
    DOUBTFUL,
    Finding,
    HOLDS,
    NOT_TESTABLE,
    VOID,
)
from heading_intercompare.core.validity.examined import RunAccount

#: A larger share of rejected readings is a warning of the run.
_REJECTED_SHARE = 0.01
#: A run with a larger share of lost readings is doubtful, or void.
_DOUBTFUL_SHARE, _VOID_SHARE = 0.1, 0.5


def _settle(finding: Finding | None, account: RunAccount) -> Finding:
    """Judge the readings that a run could not use; at a look, the gaps between the pairs alone."""
    shares = []
    if account.lost_share is not None:
        shares = [('lost', _find_lost(account.lost_share, account.inside))]
    elif account.inside is not None:
        shares = [('lost', _find_gaps(account.inside, account.interpolated))]
    if account.share is not None and account.inside is not None:
        shares += _ledger_shares(account, account.share, account.inside)
    return judge_losses(shares)


def _find_lost(lost_share: float, inside: LedgerSegment | None) -> float:
    """Return the share of pairs missing without those whose readings came, or only repeat one."""
    n = 0 if inside is None else inside.unbridged
    held = 0 if inside is None else max(inside.counts.get(LedgerKey.of_held(stream), 0)
                                        for stream in ('ts', 'rs'))
    if inside is None or not (n or held) or lost_share >= 1.0:
        return lost_share
    paired = inside.counts.get(LedgerKey.PAIRED, 0)
    explained = n / max(1, n + paired) + held * (1.0 - lost_share) / max(1, paired)
    return max(0.0, lost_share - explained)


def _find_gaps(inside: LedgerSegment, interpolated: str | None) -> float:
    """Return the share of its usual steps in which the sensor that gives the stamps was silent."""
    stream = 'rs' if interpolated == 'ts' else 'ts'
    gaps = inside.counts.get(LedgerKey.of_gaps(stream), 0)
    return gaps / max(1, gaps + inside.reported(stream))


def warn_of_rejected(share: LedgerSegment) -> list[str]:
    """Return in words which sensors had more than 1 % of the readings of a run rejected."""
    words = []
    for stream in ('ts', 'rs'):
        rejected, received = share.refused(stream), share.received(stream)
        n = sum(rejected.values())
        if n > _REJECTED_SHARE * received:
            why = ', '.join(f'{count} {reason}' for reason, count in rejected.items())
            words.append(f'{100.0 * n / received:.2g} % of the {stream.upper()} readings were '
                         f'rejected: {why}')
    return words


def warn_of_held(share: LedgerSegment) -> list[str]:
    """Return in words which sensors were polled faster than they report."""
    words = []
    for stream in ('ts', 'rs'):
        times = share.times_held(stream)
        if times is not None:
            n = share.counts[LedgerKey.of_held(stream)]
            words.append(
                f'held: each value of the {stream.upper()} stands {times:.2g} times, as if a '
                f'logger polled it faster than it reports; {n} of {share.received(stream)} '
                'readings only repeat the one before, and the first one of each value is compared')
    return words


def warn_of_alone(share: LedgerSegment, inside: LedgerSegment) -> list[str]:
    """
    Return in words that each sensor sent much while the other had nothing to pair with it.

    One sensor may have started earlier or gone on later than the other, which is no news. That
    both did is: a clock that stepped forward looks like this, and no stamp contradicts it.

    Parameters
    ----------
    share, inside
        Ledger of the readings of a run, and of those between its first and last pair.

    """
    paired = inside.counts.get(LedgerKey.PAIRED, 0)
    if not paired or paired != share.counts.get(LedgerKey.PAIRED, 0):
        # A ledger that does not end where the run does cannot tell.
        return []
    alone = {}
    for stream in ('ts', 'rs'):
        late = sum(share.rejected(stream).values()) - sum(inside.rejected(stream).values())
        outside = share.received(stream) - inside.received(stream) - late
        alone[stream] = outside / max(1, share.received(stream))
    if min(alone.values()) <= _DOUBTFUL_SHARE:
        return []
    return [f'{100.0 * alone["ts"]:.0f} % of the TS readings and {100.0 * alone["rs"]:.0f} % of '
            'the RS readings came before the first pair or after the last one, and have no '
            'partner: perhaps a clock stepped']


def _ledger_shares(account: RunAccount, share: LedgerSegment,
                   inside: LedgerSegment) -> Iterator[tuple[str, float]]:
    """Yield each kind of loss in the ledger, in words, and its share of the readings sent."""
    counts = inside.counts
    unpaired = _unpaired(inside, account.interpolated)
    for stream in ('ts', 'rs'):
        # After a clock was set back no later reading is paired until it has caught up. The run
        # ends there, although readings keep coming.
        late = [LedgerKey.of_rejected(stream, why) for why in ('stamp_not_increasing', 'jump')]
        after = sum(share.counts.get(key, 0) - counts.get(key, 0) for key in late)
        lost = inside.lost(stream)
        missing = {'lost on the way': lost.get('on_the_way', 0),
                   'lost at the source': inside.lost_at_source(stream),
                   'rejected': sum(inside.refused(stream).values()) + after,
                   'without partner': unpaired.get(stream, 0)}
        # What came before the first reading lies in no run.
        sent = (inside.reported(stream) + missing['lost on the way']
                + missing['lost at the source'] + after)
        if sent:
            kinds = [kind for kind, n in missing.items() if n] or ['rejected']
            yield (f'of the {stream.upper()} {" or ".join(kinds)}',
                   sum(missing.values()) / sent)


def _unpaired(inside: LedgerSegment, interpolated: str | None) -> dict[str, int]:
    """Return the readings without partner of the sensor that should have one for each."""
    unpaired = {stream: inside.counts.get(key, 0)
                for stream, key in (('ts', LedgerKey.TS_UNPAIRED), ('rs', LedgerKey.RS_UNUSED))
                if inside.received(stream)}
    # Most readings of an interpolated sensor may lie between two stamps of the other.
    counted = {stream: n for stream, n in unpaired.items() if stream != interpolated} or unpaired
    if not counted:
        return {}
    least = min(counted, key=lambda stream: counted[stream] / inside.reported(stream))
    return {least: counted[least]}


def judge_losses(shares: Sequence[tuple[str, float]]) -> Finding:
    """
    Return the finding on shares of lost readings.

    Parameters
    ----------
    shares
        Each kind of loss in words, and its share of the readings inside the run.

    """
    if not shares:
        return LOSSES.find(NOT_TESTABLE, '', 'there are too few pairs to show losses')
    what, share = max(shares, key=lambda row: row[1])
    evidence = ', '.join(f'{name} {100.0 * part:.2g} %' for name, part in shares)
    words = f'{100.0 * share:.0f} % {what}'
    if share > _VOID_SHARE:
        return LOSSES.find(VOID, words, evidence)
    if share > _DOUBTFUL_SHARE:
        return LOSSES.find(DOUBTFUL, words, evidence)
    return LOSSES.find(HOLDS, '', evidence)


LOSSES = Condition(
    name='losses',
    holds='few readings are lost, rejected or without partner',
    void='void: too many readings of the run are lost, rejected or without partner',
    void_when='of one sensor, more than half of the readings within the run are lost, rejected or '
              'without partner',
    void_why='the missing readings may be the bad ones',
    doubtful_when='more than a tenth of the readings are missing',
    settle=_settle)
