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

"""Named norms: the standard deviation that follows from them."""

from __future__ import annotations

import math

import pytest

from heading_intercompare.core.decision.criteria import Limits
from heading_intercompare.core.decision.norm_presets import PRESETS, sigma_max_deg
from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.core.settings import Norms


def test_an_rms_norm_grows_with_the_secant():
    """0.25 / cos 60° = 0.5."""
    norms = Norms(preset='imo_a821', latitude_deg=60.0, sigma_ref_max_deg=0.1)
    assert Limits.of(norms).sigma_max_deg == pytest.approx(0.5)


def test_a_largest_error_is_divided_by_k():
    norms = Norms(preset='imo_msc116', probability=0.9973002039367398)
    assert sigma_max_deg(norms) == pytest.approx(1 / 3)
    assert sigma_max_deg(norms, 'UN') == pytest.approx(1 / (0.9973002039367398 * math.sqrt(3)))


def test_a_norm_keeps_its_own_probability():
    """ISO 22090-2 states its 1.0° at 95 %: 1 / 1.959964."""
    assert sigma_max_deg(Norms(preset='iso22090_2')) == pytest.approx(1 / 1.959963984540054)


def test_a_preset_replaces_the_norm_given():
    assert sigma_max_deg(Norms(sigma_max_deg=9.0, preset='iso22090_2')) < 1.0
    assert sigma_max_deg(Norms(sigma_max_deg=9.0)) == 9.0
    assert sigma_max_deg(Norms()) is None


def test_what_is_wrong_is_named():
    with pytest.raises(SettingsError, match=r'norms.latitude_deg is missing'):
        sigma_max_deg(Norms(preset='imo_a424'))
    with pytest.raises(SettingsError, match=r'must be one of imo_a424'):
        sigma_max_deg(Norms(preset='imo'))


def test_every_preset_has_one_norm():
    for preset in PRESETS.values():
        assert (preset.rms_deg is None) != (preset.limit_deg is None)
        assert preset.status in ('verified', 'unverified')


def test_a_limiting_error_is_a_norm_by_hand():
    """GK (2a): 0.3 / sqrt 3; (2) with K(0.997) = 2.96773793, or 3 as the paper prints."""
    norms = Norms(limiting_error_max_deg=0.3)
    assert sigma_max_deg(norms, 'UN') == pytest.approx(0.3 / math.sqrt(3.0))
    assert sigma_max_deg(norms, 'UU') == sigma_max_deg(norms, 'UN')
    assert sigma_max_deg(norms) == pytest.approx(0.3 / 2.96773793, rel=1e-8)
    assert sigma_max_deg(Norms(limiting_error_max_deg=0.3, k_rule='three')) == \
        pytest.approx(0.1)
    assert sigma_max_deg(Norms(limiting_error_max_deg=0.3, k_rule=2.0)) == 0.15


def test_two_norms_of_one_error_are_refused():
    with pytest.raises(SettingsError, match='must not be given with norms.sigma_max_deg'):
        Norms(limiting_error_max_deg=0.3, sigma_max_deg=0.1)
    with pytest.raises(SettingsError, match='limiting_error_max_deg = 0.0: must be greater'):
        Norms(limiting_error_max_deg=0.0)
