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

"""Streams are cut into pieces of one time that lack and repeat nothing."""

from __future__ import annotations

import numpy as np
import pytest

from heading_intercompare import Headings
from heading_intercompare.core.pairing import stream_pieces
from heading_intercompare.core.pairing.stream_pieces import cut_streams

T0, S = 10 ** 18, 10 ** 9


def stream(seconds):
    """Return readings at these seconds, each with a heading of its own."""
    return Headings.of(T0 + np.asarray(seconds, np.int64) * S, np.arange(len(seconds)) % 360.0)


STREAMS = {
    'equal': {'ts': stream(range(1000)), 'rs': stream(range(1000))},
    'unequal rates': {'ts': stream(range(0, 1000, 10)), 'rs': stream(range(1000))},
    'three': {name: stream(range(begin, 1000))
              for name, begin in (('a', 0), ('b', 3), ('c', 500))},
    'one without a reading': {'ts': stream(range(1000)), 'rs': Headings.empty()},
    'one after the other': {'ts': stream(range(500)), 'rs': stream(range(500, 1000))},
    'set back': {'ts': stream([*range(500), *range(300, 800)]), 'rs': stream(range(800))},
    'one stamp far ahead': {'ts': stream([*range(500), 10 ** 6, *range(500, 800)]),
                            'rs': stream(range(800))},
    'one stamp for all': {'ts': stream([7] * 500), 'rs': stream([7] * 500)},
}


@pytest.mark.parametrize('streams', STREAMS.values(), ids=STREAMS)
def test_the_pieces_of_each_stream_joined_are_the_stream(streams, monkeypatch):
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 64)
    pieces = [*cut_streams(streams)]
    for name, headings in streams.items():
        assert Headings.concatenate([piece[name] for piece in pieces]) == headings


@pytest.mark.parametrize('case', ['equal', 'unequal rates', 'three', 'one after the other'])
def test_a_piece_is_small_and_of_one_time(case, monkeypatch):
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 64)
    last_ns = 0
    for piece in cut_streams(STREAMS[case]):
        assert sum(map(len, piece.values())) <= 64 + 2
        stamps = np.concatenate([headings.stamp_ns for headings in piece.values()])
        assert stamps.min() > last_ns
        last_ns = stamps.max()


@pytest.mark.parametrize('late_s', [-400, 90, 400])
def test_a_late_clock_is_cut_where_its_readings_have_their_partners(late_s, monkeypatch):
    monkeypatch.setattr(stream_pieces, '_AT_ONCE', 64)
    streams = {'ts': stream(np.arange(1000) + late_s), 'rs': stream(range(1000))}
    for piece in cut_streams(streams, {'ts': late_s * S}):
        np.testing.assert_array_equal(piece['ts'].stamp_ns - late_s * S, piece['rs'].stamp_ns)


def test_few_readings_are_one_piece():
    streams = STREAMS['equal']
    assert [*cut_streams(streams)] == [streams]
