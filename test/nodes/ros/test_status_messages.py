# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""Ledgers, marks and figures as messages."""

from __future__ import annotations

import math

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from hypothesis import given, settings as hypothesis_settings, strategies as st
import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

from heading_intercompare.core.pairing.ledger import Ledger, LedgerSegment, REASONS
from heading_intercompare.nodes.ros.status_messages import (
    figures_message,
    ledger_from,
    ledger_message,
    marker_message,
    marks_from,
    OK,
    status,
    status_array,
)

KEYS = ['paired', 'ts_paired', 'ts_used', 'ts_unpaired', 'ts_pending', 'rs_used', 'rs_unused',
        'rs_pending',
        *(f'{s}_rejected.{r}' for s in ('ts', 'rs') for r in REASONS)]
COUNTS = st.dictionaries(st.sampled_from(KEYS), st.integers(1, 2 ** 40), max_size=6)
quickly = hypothesis_settings(max_examples=60, deadline=None)


def sent(message):
    """Return a message as it arrives."""
    return deserialize_message(serialize_message(message), type(message))


def values(one):
    """Return the values of a status as a mapping."""
    return {pair.key: pair.value for pair in one.values}


@quickly
@given(COUNTS, st.lists(st.tuples(st.integers(1, 2 ** 62), COUNTS), max_size=3,
                        unique_by=lambda s: s[0]),
       st.integers(1, 2 ** 31 * 10 ** 9 - 1), st.booleans())
def test_a_ledger_arrives_as_it_was(first, others, newest_ns, final):
    segments = (LedgerSegment(None, dict(sorted(first.items()))),
                *(LedgerSegment(ns, dict(sorted(counts.items())))
                  for ns, counts in sorted(others, key=lambda s: s[0])))
    ledger = Ledger.from_segments(segments, newest_ns)
    back, said_final = ledger_from(sent(ledger_message(ledger, final)))
    assert back.segments == segments
    assert (back.newest_ns, said_final) == (newest_ns, final)
    assert back.paired == ledger.paired


def test_a_ledger_of_nothing_arrives_as_it_was():
    back, final = ledger_from(sent(ledger_message(Ledger())))
    assert (back.segments, back.newest_ns, final) == (Ledger().segments, None, False)


def test_a_ledger_shows_its_total_first(judged):
    ledger = judged.pairer.ledger
    message = ledger_message(ledger)
    assert values(message.status[0]) == {'final': 'false', 'paired': '401', 'rs_used': '401',
                                         'ts_paired': '401'}
    assert [s.name for s in message.status] == [
        'ledger', *(f'segment {k}' for k in range(len(ledger.segments)))]


@pytest.mark.parametrize('kind', ['start', 'stop'])
def test_a_mark_arrives_with_its_stamp(kind):
    assert marks_from(sent(marker_message(kind, 123_456_789_012))) == [(kind, 123_456_789_012)]


@quickly
@given(st.dictionaries(st.text(max_size=8).filter(lambda t: '\0' not in t), st.one_of(
    st.none(), st.booleans(), st.integers(-2 ** 63, 2 ** 63), st.floats(allow_nan=False),
    st.text(max_size=8).filter(lambda t: '\0' not in t)), max_size=6))
def test_figures_arrive_and_read_back_to_the_bit(figures):
    message = sent(figures_message('run', figures, 5))
    shown = values(message.status[0])
    assert shown.keys() == {k for k, v in figures.items() if v is not None}
    for key, text in shown.items():
        value = figures[key]
        if isinstance(value, bool):
            assert text == str(value).lower()
        elif isinstance(value, float):
            assert float(text) == value
        else:
            assert text == str(value)


def test_a_number_of_numpy_is_written_as_a_bare_number():
    one = status('x', OK, '', {'mean_deg': np.float64(0.25), 'n': np.int64(7)})
    assert values(one) == {'mean_deg': '0.25', 'n': '7'}


def test_a_status_array_holds_its_stamp_and_statuses():
    message = sent(status_array(7_000_000_001, [DiagnosticStatus(name='a')]))
    assert isinstance(message, DiagnosticArray)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (7, 1)
    assert [s.name for s in message.status] == ['a']
    assert not math.isnan(message.header.stamp.sec)
