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

"""The vote: every set of differing pairs of up to five sensors, and words for each result."""

from __future__ import annotations

from itertools import combinations, product

import pytest

from heading_intercompare.core.sensors.vote import find_wrong

PAIRS = {k: [*combinations('abcde'[:k], 2)] for k in (2, 3, 4, 5)}


def vote(k, differing, one_source=(), untested=()):
    return find_wrong('abcde'[:k], {
        pair: None if ''.join(pair) in untested else ''.join(pair) in differing
        for pair in PAIRS[k]}, [tuple(pair) for pair in one_source])


@pytest.mark.parametrize('k', [3, 4, 5])
def test_one_that_differs_from_all_others_is_wrong(k):
    for name in 'abcde'[:k]:
        differing = {''.join(pair) for pair in PAIRS[k] if name in pair}
        assert vote(k, differing).wrong == (name,)


def test_two_of_five_that_differ_from_all_and_from_each_other_are_wrong():
    differing = {''.join(pair) for pair in PAIRS[5] if {'b', 'd'} & {*pair}}
    found = vote(5, differing)
    assert found.wrong == ('b', 'd')
    assert found.words == 'b and d differ from a, c and e, which do not differ from each other'
    # Also if the two agree, as two that are fed by the same wrong correction.
    assert vote(5, differing - {'bd'}).wrong == ('b', 'd')


def test_half_of_the_sensors_cannot_be_outvoted():
    found = vote(4, {'ac', 'ad', 'bc', 'bd'})
    assert found.wrong == found.suspected == ()
    assert 'no majority of the sensors agrees' in found.words


def test_a_sensor_is_never_named_while_a_pair_without_it_differs():
    """All 1024 sets of differing pairs of five, and all 64 of four."""
    for k in (3, 4, 5):
        for chosen in product((False, True), repeat=len(PAIRS[k])):
            differing = {''.join(pair) for pair, one in zip(PAIRS[k], chosen) if one}
            found = vote(k, differing)
            if found.wrong:
                rest = [name for name in 'abcde'[:k] if name not in found.wrong]
                assert len(rest) > len(found.wrong)
                assert all(''.join(sorted((a, b))) in differing
                           for a in found.wrong for b in rest)
                assert not any(''.join(pair) in differing for pair in combinations(rest, 2))
            assert not (found.wrong and found.suspected)


def test_a_sensor_that_would_explain_all_is_suspected_if_a_pair_of_it_agrees():
    found = vote(4, {'ab', 'ac'})
    assert (found.wrong, found.suspected) == ((), ('a',))
    assert found.words == ('a is suspected: a and b differ; a and c differ; it is part of each '
                           'pair that differs, but not all its pairs differ')
    assert vote(4, {'ab', 'ac', 'ad'}, untested={'bc'}).suspected == ('a',)
    assert vote(3, {'ab', 'ac'}, untested={'bc'}).suspected == ('a',)


def test_a_pair_alone_cannot_tell():
    assert vote(2, {'ab'}).words == (
        'a and b differ; two sensors cannot tell which of them is wrong')
    found = vote(3, {'ab'})
    assert found.wrong == found.suspected == ()
    assert found.words == 'a and b differ; more than one sensor could explain that'


def test_the_share_of_all_variances_makes_suspected_where_several_would_explain():
    differs = {pair: ''.join(pair) == 'ab' for pair in PAIRS[3]}
    assert find_wrong('abc', differs, beyond='b').suspected == ('b',)
    assert find_wrong('abc', differs, beyond='ab').suspected == ()
    assert find_wrong('abc', differs, beyond='c').suspected == ()
    # Where nothing differs it says nothing.
    assert find_wrong('abc', dict.fromkeys(PAIRS[3], False), beyond='b').suspected == ()


def test_sensors_of_one_source_have_one_voice():
    """Two headings of one wrong gyro would outvote the sound sensor."""
    assert vote(3, {'ac', 'bc'}).wrong == ('c',)
    found = vote(3, {'ac', 'bc'}, one_source=['ab'])
    assert found.wrong == found.suspected == ()
    assert found.one_source == (('a', 'b'),)
    assert 'two sensors cannot tell' in found.words and 'a and b show one source' in found.words
    # With a fourth the group can be outvoted.
    found = vote(4, {'ac', 'ad', 'bc', 'bd'}, one_source=['ab'])
    assert found.wrong == ('a', 'b')


def test_no_pair_differs():
    assert vote(3, ()).words == 'no two sensors differ by more than their norms explain'
    assert vote(3, (), untested={'ab'}).words.endswith('2 of 3 pairs were testable')
    assert vote(3, (), untested={'ab', 'ac', 'bc'}).words == 'no pair was testable'
