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

"""YAML 1.2 as plain values; a mistake is reported in one line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from heading_intercompare.core.declared_settings import SettingsError
from heading_intercompare.yaml_file import load_settings, load_yaml, parse_yaml, YamlError

yaml = pytest.importorskip('yaml')
ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize('text, value', [
    ('1e9', 1e9), ('1E-3', 1e-3), ('.5', 0.5), ('5.', 5.0), ('+1.5e+3', 1500.0), ('1e', '1e'),
    ('7', 7), ('-7', -7), ('010', 10), ('0o10', 8), ('0x1F', 31), ('1_000', '1_000'),
    ('1:30', '1:30'), ('true', True), ('FALSE', False), ('yes', 'yes'), ('on', 'on'), ('n', 'n'),
    ('null', None), ('~', None), ('', None), ('none', 'none'), ('.inf', math.inf),
    ('-.INF', -math.inf), ('2026-01-01', '2026-01-01'), ('2026-01-01T00:00:00Z',) * 2,
    ('"7"', '7'), ("'true'", 'true'), ('<<', '<<'), ('=', '='), ('[]', []), ('{}', {}),
    ('[a, {b: 1}]', ['a', {'b': 1}]), ('a: |\n  x\n  y\n', {'a': 'x\ny\n'}), ('1: a', {1: 'a'}),
    ('---\n- 1\n...\n', [1]), ('# only a remark', None)])
def test_values_are_those_of_yaml_1_2(text, value):
    found = load_yaml(text)
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize('text, value', [
    ('a: &x 1\nb: *x', {'a': 1, 'b': 1}), ('&x a: b\nc: *x', {'a': 'b', 'c': 'a'}),
    ('a: &x {b: [1]}\nc: [*x, *x]', {'a': {'b': [1]}, 'c': [{'b': [1]}] * 2}),
    ('a: &x\nb: *x', {'a': None, 'b': None}), ('a: &x b\n*x : 1', {'a': 'b', 'b': 1}),
    ('a: &x 1\nb: &x 2\nc: *x', {'a': 1, 'b': 2, 'c': 2}),
    ('a: &x {b: 1}\nc:\n  <<: *x', {'a': {'b': 1}, 'c': {'<<': {'b': 1}}})])
def test_an_alias_is_the_value_of_its_anchor_as_ros2_bag_takes_it(text, value):
    assert load_yaml(text) == value
    with pytest.raises(YamlError, match='anchors and aliases are not accepted'):
        load_settings(text)


@pytest.mark.parametrize('text, line, problem', [
    ('a: 1\nb: *x', 2, r'the alias \*x stands'), ('a: &x [1, *x]', 1, r'the alias \*x stands'),
    ('a: &x 1\nb: &x [*x]', 2, r'the alias \*x stands'),
    ('a: &x [1]\n*x : 1', 2, 'a name must be a word')])
def test_an_alias_without_a_value_is_refused_with_its_line(text, line, problem):
    with pytest.raises(YamlError, match=problem) as refused:
        load_yaml(text)
    assert refused.value.line == line


def test_aliases_of_aliases_fill_no_memory():
    lines = ['a0: &a0 [x]'] + [f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * 9)}]'
                               for k in range(1, 40)]
    value = load_yaml('\n'.join(lines))
    assert value['a39'][8][8][8] is value['a36']


def test_what_is_no_number_is_none():
    assert math.isnan(load_yaml('.nan'))


@pytest.mark.parametrize('text, line, problem', [
    ('a: 1\nb: 2\na: 3', 3, "'a' is given twice"), ('{1: a, 1: b}', 1, '1 is given twice'),
    ('a: {b: 1,\n b: 2}', 2, "'b' is given twice"),
    ('- 1\n- !!python/object:os.system x', 2, 'tags are not accepted'), ('!!str 7', 1, 'tags'),
    ('a: 1\n---\nb: 2', 2, 'there is a second document'),
    ('[' * 60 + ']' * 60, 1, 'nested deeper than 50 levels'),
    ('? [a]\n: 1', 1, 'a name must be a word'), ('- x\n...\n---\n- y', 3, 'second document'),
    ('a: ' + '9' * 5000, 1, 'a number with too many digits'), ('a: [', 1, 'not YAML'),
    ('a: "', 1, 'not YAML'), ('\t- a', 1, 'not YAML'), ('a: b: c', 1, 'not YAML'),
    ('x\x00', 1, 'not YAML'),
    ('x: ä\n# ö\ny: \x07', 3, 'not YAML'), ('\ud800', None, 'not YAML'),
    ('#' * 2**20 + 'x', None, 'longer than 1048576 bytes')])
def test_a_part_of_yaml_that_is_not_accepted_is_refused_with_its_line(text, line, problem):
    with pytest.raises(YamlError, match=problem) as refused:
        load_yaml(text)
    assert line is None or refused.value.line == line
    with pytest.raises(SettingsError) as refused:
        parse_yaml(text.encode(errors='surrogatepass'), 'my.yaml')
    assert str(refused.value).startswith('my.yaml') and '\n' not in str(refused.value)


@pytest.mark.parametrize('text', ['010', '-07', 'a: [1, 00]', '{a: +012}'])
def test_settings_hold_no_number_that_ros_reads_as_octal(text):
    load_yaml(text)
    with pytest.raises(YamlError, match='may be octal'):
        load_settings(text)


@pytest.mark.parametrize('text', ['0', '-0', '0.5', '0e3', '0x10', '0o17', '"010"', '01a'])
def test_settings_hold_other_numbers_that_begin_with_zero(text):
    assert load_settings(text) == load_yaml(text)


def test_bytes_that_are_no_text_are_refused():
    with pytest.raises(SettingsError, match='my.yaml: not YAML: not text'):
        parse_yaml(b'a: \xff', 'my.yaml')


@pytest.mark.parametrize('opening', ['[', '- ', '[{a: ', '{a: '])
def test_nesting_costs_no_more_than_its_length(opening):
    """As deep as the size limit allows; Python would end with a RecursionError."""
    with pytest.raises(YamlError, match='^nested deeper than 50 levels$') as refused:
        load_yaml(opening * ((2**20 - 1) // len(opening)))
    assert refused.value.line == 1


@pytest.mark.parametrize('path', sorted((ROOT / 'config').rglob('*.yaml')), ids=lambda p: p.name)
def test_files_of_the_package_mean_to_others_what_they_mean_here(path):
    assert load_yaml(path.read_text('utf-8')) == yaml.safe_load(path.read_text('utf-8'))


def test_the_parser_in_python_gives_the_same(monkeypatch):
    text = 'a: [1e9, on, {b: "x"}]\nc: 0o17'
    expected = load_yaml(text)
    monkeypatch.setattr('heading_intercompare.yaml_file._Loader', yaml.SafeLoader)
    assert load_yaml(text) == expected == {'a': [1e9, 'on', {'b': 'x'}], 'c': 15}
