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

"""The palettes: legible, and night is red on black."""

from __future__ import annotations

import pytest

from heading_intercompare.web.palettes import PALETTES, style


def light(colour):
    """Return the relative luminance of a colour, WCAG 2.1."""
    parts = [int(colour[at:at + 2], 16) / 255.0 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    low, high = sorted((light(one), light(other)))
    return (high + 0.05) / (low + 0.05)


def test_contrast_by_hand():
    """Black on white is 21 : 1."""
    assert contrast('#000000', '#ffffff') == pytest.approx(21.0)


@pytest.mark.parametrize('name', PALETTES)
def test_every_text_is_legible_on_its_ground(name):
    """WCAG 2.1 AA for small text: 4.5 : 1."""
    colours = PALETTES[name]
    for ink in ('ink', 'faint', 'good', 'doubt', 'bad'):
        assert contrast(colours[ink], colours['ground']) >= 4.5, ink


@pytest.mark.parametrize('name', ['dusk', 'night'])
def test_priorities_differ_in_light_as_in_shape(name):
    """Each priority is at least 1.45 times as light as the one above it."""
    colours = PALETTES[name]
    for graver, lesser in (('alarm', 'warning'), ('warning', 'caution')):
        assert light(colours[lesser]) > light(colours[graver])
        assert contrast(colours[graver], colours[lesser]) >= 1.45


@pytest.mark.parametrize('name', PALETTES)
def test_a_bad_state_and_a_doubtful_one_differ_from_a_good_one(name):
    colours = PALETTES[name]
    for tone in ('doubt', 'bad'):
        assert contrast(colours['good'], colours[tone]) > 1.1 or name == 'day', tone


def test_the_night_is_red_on_black_and_nothing_is_lighter_than_an_alert():
    night = PALETTES['night']
    alerts = [night[priority] for priority in ('alarm', 'warning', 'caution')]
    for name in ('ground', 'ink', 'faint', 'line', 'band', 'good'):
        red, green, blue = (int(night[name][at:at + 2], 16) for at in (1, 3, 5))
        assert green <= 0.4 * red and blue <= 0.4 * red, name
        assert light(night[name]) < min(map(light, alerts)), name
    assert night['ground'] == '#000000'


def test_the_style_has_a_block_per_palette_and_asks_for_nothing_outside():
    text = style()
    for name in ('day', 'dusk', 'night'):
        assert f'html[data-palette={name}]' in text
    assert 'url(' not in text and '@import' not in text
