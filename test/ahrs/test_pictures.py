# SPDX-FileCopyrightText: 2026 The heading_intercompare authors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of docs/ahrs.md can be drawn, are there, and are shown."""

from __future__ import annotations

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
import sys
from xml.etree import ElementTree

import pytest

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
    drawn = pictures.levelling().svg()
    assert labels(drawn) == labels((DOCS / 'ahrs_levelling.svg').read_text(encoding='utf-8'))
    lines = [line.get('points').split() for line in ElementTree.fromstring(drawn).iter(
        f'{SVG}polyline')]
    assert sorted(map(len, lines)) == [2, 2, 300, 750]
