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

"""The pictures of docs/ahrs.md can be drawn, are there, and are shown."""

from __future__ import annotations

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import re
import sys
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('matplotlib')

DOCS = Path(__file__).resolve().parents[2] / 'docs'
SVG = '{http://www.w3.org/2000/svg}'


@pytest.fixture(scope='module')
def pictures():
    """Return the script."""
    spec = spec_from_file_location('ahrs_pictures', DOCS / 'ahrs_pictures.py')
    module = sys.modules[spec.name] = module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


def labels(svg):
    """Return the words in a picture."""
    return [text.text for text in ElementTree.fromstring(svg).iter(f'{SVG}text')]


def test_every_picture_is_there_and_shown(pictures):
    page = (DOCS / 'ahrs.md').read_text(encoding='utf-8')
    assert set(pictures.PICTURES) == {'levelling', 'alignment', 'day'}
    for name in pictures.PICTURES:
        assert page.count(f'(ahrs_{name}.svg)') == 1
        assert len(labels((DOCS / f'ahrs_{name}.svg').read_text(encoding='utf-8'))) > 10


def test_levelling_is_drawn_with_the_labels_of_the_file(pictures):
    drawn = pictures.levelling()
    assert labels(drawn) == labels((DOCS / 'ahrs_levelling.svg').read_text(encoding='utf-8'))
    styles = ' '.join(path.get('style', '') for path in ElementTree.fromstring(drawn).iter(
        f'{SVG}path'))
    assert {pictures.INK, pictures.ACCENT, pictures.GREY} <= {
        f'#{color}' for color in re.findall('stroke: #([0-9a-f]{6})', styles)}


def test_points_are_means_of_so_many_samples(pictures):
    """Of seven samples, three at a time; the last is left out."""
    x, y = pictures.smooth(np.arange(7.0), np.arange(7.0) ** 2, 3)
    assert x.tolist() == [1.0, 4.0] and y.tolist() == [5.0 / 3.0, 50.0 / 3.0]
