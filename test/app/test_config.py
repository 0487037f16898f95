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

"""A ROS parameter file means the same to every node and every command."""

from __future__ import annotations

import pytest
import yaml

from heading_intercompare.app.config import load_config
from heading_intercompare.core.declared_settings import SettingsError


@pytest.fixture
def load(tmp_path):
    """Return a function that reads a parameter file with these sections."""
    def read(**sections):
        path = tmp_path / 'my.yaml'
        path.write_text(yaml.dump({name: {'ros__parameters': values} for name, values in
                                   {'/**': {'ts_topic': 'gyro'}, **sections}.items()}))
        return load_config(str(path))
    return read


@pytest.mark.parametrize('name', [
    'compliance', '/compliance', 'ship1/compliance', '/**/compliance', '/*', 'synchronizer',
    'recorder', 'ts_driver', 'gyro_driver', 'dashboard'])
@pytest.mark.parametrize('given, key', [
    ({'norms': {'sigma_max_deg': 2.0}}, 'norms.sigma_max_deg'),
    ({'norms.sigma_max_deg': 2.0}, 'norms.sigma_max_deg'), ({'ts_topic': 'other'}, 'ts_topic'),
    ({'model': 'total'}, 'model')])
def test_a_node_does_not_judge_by_settings_that_the_others_do_not_know(load, name, given, key):
    """Live, `compliance` took the norm of its section; `analyze` took the one of all."""
    with pytest.raises(SettingsError) as refused:
        load(**{name: given})
    assert f"section {name.lstrip('/')!r}: {key} holds for every node" in str(refused.value)
    assert 'my.yaml: ' in str(refused.value) and "section '/**'" in str(refused.value)


def test_a_node_may_repeat_what_holds_for_all(load):
    assert load(recorder={'ts_topic': 'gyro', 'output': 'bag'}).sections['recorder'] == {
        'ts_topic': 'gyro', 'output': 'bag'}


def test_the_replayer_may_take_another_topic_of_its_bag(load):
    assert load(replayer={'ts_topic': 'other'}).sections['replayer'] == {'ts_topic': 'other'}


def test_a_node_of_another_package_may_call_its_parameters_as_it_likes(load):
    assert load(camera={'model': 'x20', 'sensors': 3}).sections['camera']['sensors'] == 3


@pytest.mark.parametrize('text, shared', [
    ('trial: {ship: MV Example}', {'trial.ship': 'MV Example'}),
    ('trial.ship: MV Example', {'trial.ship': 'MV Example'}),
    ('model: UN\n/**: {ros__parameters: {trial: {ship: A}}}', {'model': 'UN', 'trial.ship': 'A'}),
    ('norms: {sigma_max_deg: 1.0}\ncompliance: {ros__parameters: {report_dir: x}}',
     {'norms.sigma_max_deg': 1.0})])
def test_settings_without_a_section_are_those_of_all(tmp_path, text, shared):
    path = tmp_path / 'my.yaml'
    path.write_text(text)
    config = load_config(str(path))
    assert config.shared == shared and len(config.bare) == 1


@pytest.mark.parametrize('text, words', [
    ('tiral: {ship: A}', "section 'tiral': must hold ros__parameters"),
    ('trial: {ship: A}\n/**: {ros__parameters: {trial: {ship: B}}}',
     "trial.ship is given twice, in section '/**' and without a section"),
    ('trial: {ship: A}\ntrial.ship: B', 'trial.ship'),
    ('norms: {sigma_max_deg: 1.0}\ncompliance: {ros__parameters: {norms.sigma_max_deg: 2.0}}',
     'norms.sigma_max_deg holds for every node')])
def test_a_doubtful_place_of_a_setting_is_refused(tmp_path, text, words):
    path = tmp_path / 'my.yaml'
    path.write_text(text)
    with pytest.raises(SettingsError) as refused:
        load_config(str(path))
    assert str(refused.value).startswith(f'{path}: ') and words in str(refused.value)


@pytest.mark.parametrize('name', ['dashboard', '/dashboard', '/ship1/dashboard'])
def test_a_token_in_the_file_is_refused_and_not_repeated(load, name):
    """The recorder copies the file into every bag."""
    with pytest.raises(SettingsError) as refused:
        load(**{name: {'token': 'choose-your-own'}})
    words = str(refused.value)
    assert "dashboard': token: this setting was removed: each bag would hold it; put" in words
    assert '\n' not in words and 'choose-your-own' not in words


@pytest.mark.parametrize('name, value', [('dashboard', 'none'), ('camera', 'choose-your-own')])
def test_no_token_and_that_of_another_package_are_accepted(load, name, value):
    assert load(**{name: {'token': value}}).sections[name]['token'] == value
