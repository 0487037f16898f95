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

"""A figure is declared once: its unit is in its name, its parts have dotted keys."""

from __future__ import annotations

from dataclasses import dataclass, fields

import pytest

from heading_intercompare.core.declared_figures import (
    figure,
    find_figure,
    is_left_out,
    list_figures,
    list_keys,
    no_key,
)
from heading_intercompare.core.verdict.verdict_document import Verdict


@dataclass(frozen=True)
class Turn:
    """A block."""

    rate_deg_s: float = figure('rate', u='u_deg_s')
    u_deg_s: float = figure('its standard uncertainty')
    kind: str = figure('kind', 'by size', choices={'hard': 'a hard turn'}, default='hard')


@dataclass(frozen=True)
class Sample:
    """A record with a block."""

    stamp_ns: int = figure('time')
    n: int = figure('values')
    steps: tuple[int, ...] | None = figure('steps', unit='readings', absent='without any')
    turn: Turn | None = figure('turn', prefix='turn: ', default=None)
    closed: bool = figure('it is closed', default=False)
    sketch: object = no_key()


@pytest.mark.parametrize('key, unit', [
    ('stamp_ns', 'UTC'), ('n', '1'), ('steps', 'readings'), ('closed', ''), ('turn', ''),
    ('turn.rate_deg_s', 'deg/s'), ('turn.kind', '')])
def test_the_end_of_a_name_or_its_type_says_the_unit(key, unit):
    assert list_figures(Sample)[key].unit == unit


def test_a_part_has_the_prefix_of_its_block_and_names_its_uncertainty():
    rate = list_figures(Sample)['turn.rate_deg_s']
    assert (rate.words, rate.u_key) == ('turn: rate', 'turn.u_deg_s')


def test_the_explanation_has_words_unit_choices_note_and_when_it_is_absent():
    assert list_figures(Turn)['kind'].text == 'kind; `hard`: a hard turn; by size'
    assert list_figures(Sample)['steps'].text == 'steps [readings]; absent without any'
    assert list_figures(Sample)['stamp_ns'].text == 'time [ns, UTC]'


def test_a_figure_is_found_by_its_key_and_none_in_a_block_that_is_missing():
    assert find_figure(Sample(1, 2, turn=Turn(0.5, 0.1)), 'turn.rate_deg_s') == 0.5
    assert find_figure(Sample(1, 2), 'turn.rate_deg_s') is None


def test_what_may_be_absent_is_left_out_and_what_is_no_key_is_not_listed():
    assert [f.name for f in fields(Sample) if is_left_out(f, None)] == ['steps']
    assert 'sketch' not in [f.name for f in list_keys(Sample)]


def test_every_key_of_a_verdict_is_declared():
    assert {key for key in list_figures(Verdict) if '.' not in key} == {
        f.name for f in list_keys(Verdict)}
    assert all(figure.words for figure in list_figures(Verdict).values())
