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


"""The scope of a certificate, in figures and in words."""

import numpy as np
import pytest

from heading_intercompare.core.decision.coverage import Scope
from heading_intercompare.core.settings import Settings

NORMS = {'sigma_max_deg': 0.2, 'sigma_ref_max_deg': 0.1}
STAMPS = np.arange(5) * 500_000_000


def scope(headings=(40.0, 45.0, 51.0, 41.0, 40.0), norms=None, **settings):
    return Scope.of(STAMPS, np.array(headings), Settings.from_mapping(
        {'norms': {**NORMS, **(norms or {})}, **settings}))


@pytest.mark.parametrize('headings, words', [
    ((40.0, 45.0, 51.0), 'headings 040-060 deg'), ((358.0, 2.0, 12.0), 'headings 350-020 deg'),
    ((-2.0, 361.0), 'headings 350-010 deg'), ((5.0, 185.0), 'headings 000-010, 180-190 deg'),
    ((355.0,), 'headings 350-360 deg'),
    (np.arange(0.0, 360.0, 20.0), 'headings in 180 deg of 360'),
    (np.arange(0.0, 360.0, 7.0), 'all headings')])
def test_the_headings_are_told_as_arcs(headings, words):
    assert scope(headings).words.partition(';')[0] == words


def test_what_is_not_stated_and_not_judged_is_said():
    found = scope()
    assert found.shortest_s == 1.0
    assert found.words == ('headings 040-060 deg; latitude not stated; the mean is not judged, '
                           'for no norm is set for it')


def test_latitude_mean_and_risk_are_said_as_stated():
    found = scope(norms={'total_error_max_deg': 0.6},
                  risk={'alpha_consumer': 0.01},
                  trial={'latitude_min_deg': 54.0, 'latitude_max_deg': 55.5})
    assert found.words == "headings 040-060 deg; latitude 54 to 55.5 deg; consumer's risk 0.01"
    assert scope(norms={'latitude_deg': 60.0}).latitude_deg == (60.0, 60.0)
    assert scope(trial={'latitude_max_deg': 7.0}).latitude_deg == (7.0, 7.0)


def test_runs_together_cover_the_headings_of_all():
    joined = Scope.join([scope(), scope((200.0, 201.0))])
    assert joined.headings_deg == (40, 50, 200) and joined.shortest_s == 1.0
    assert Scope.join([]) is None


def test_a_run_without_differences_has_no_step_and_no_headings():
    empty = Scope.of(np.empty(0, np.int64), np.empty(0), Settings.from_mapping({'norms': NORMS}))
    assert (empty.shortest_s, empty.headings_deg) == (None, ())
