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

"""The settings classes, the parameter file and the tables of the docs agree."""

from __future__ import annotations

from dataclasses import fields
from inspect import signature
from pathlib import Path
import re
import runpy

import pytest
import yaml

from heading_intercompare.app.config import Config, load_config, settings_for
from heading_intercompare.core.declared_settings import (
    from_mapping,
    list_settings,
    SettingsError,
    to_mapping,
)
from heading_intercompare.core.settings import Norms, Risk, Settings

ROOT = Path(__file__).resolve().parent.parent
YAML = ROOT / 'config' / 'heading_intercompare.yaml'
GENERATED = runpy.run_path(str(ROOT / 'docs' / 'generate.py'))
SECTIONS = {s.node: s for s in GENERATED['SECTIONS']}


def parameters(text: str) -> dict[str, dict]:
    """Return the parameters of each section of a parameter file."""
    return {node: section['ros__parameters'] for node, section in yaml.safe_load(text).items()}


def flat(mapping: dict, prefix: str = '') -> dict:
    """Return a nested mapping with dotted names."""
    result = {}
    for name, value in mapping.items():
        if isinstance(value, dict):
            result.update(flat(value, f'{prefix}{name}.'))
        else:
            result[prefix + name] = value
    return result


def test_the_parameter_file_is_what_the_classes_declare():
    assert YAML.read_text('utf-8') == GENERATED['parameter_file'](), 'run: make docs'


def test_the_tables_of_the_docs_are_what_the_classes_declare():
    assert GENERATED['TABLES'].read_text('utf-8') == GENERATED['tables'](), 'run: make docs'
    scenarios = GENERATED['SCENARIOS'].read_text('utf-8')
    assert scenarios == GENERATED['scenario_tables'](), 'run: make docs'


@pytest.mark.slow
def test_the_list_of_modules_in_the_docs_is_what_the_sources_say():
    text = GENERATED['ARCHITECTURE'].read_text('utf-8')
    assert text == GENERATED['architecture'](text), 'run: make docs'


def read(node: str) -> dict:
    """Return the values of a section of the parameter file, with dotted names."""
    return flat(parameters(YAML.read_text('utf-8'))[node])


@pytest.mark.parametrize('node', SECTIONS)
def test_a_section_of_the_parameter_file_is_accepted_and_changes_no_other_default(node):
    given, section = read(node), SECTIONS[node]
    assert set(given) <= {rule.name for rule in GENERATED['rules'](section)}
    for settings in section.classes:
        names = {rule.name for rule in list_settings(settings)}
        expected = {**to_mapping(settings()),
                    **{n: value for n, value in section.given.items() if n in names}}
        made = from_mapping(settings, {n: value for n, value in given.items() if n in names})
        assert to_mapping(made) == expected


@pytest.mark.parametrize('node', [n for n, s in SECTIONS.items() if s.examples is not None])
def test_every_setting_stands_in_its_section_with_its_type(node):
    """With the optional rows uncommented, each declared name is present and accepted."""
    rules = {rule.name: rule for rule in GENERATED['rules'](SECTIONS[node])}
    names = {name.rpartition('.')[2] for name in rules}
    bare = [line.replace('# ', '', 1) if line.strip().startswith('# ')
            and line.strip()[2:].partition(':')[0] in names else line
            for line in YAML.read_text('utf-8').splitlines()]
    given = flat(parameters('\n'.join(bare))[node])
    assert set(given) == set(rules)
    assert {n for n, value in given.items() if type(value) not in rules[n].kinds} == set()


def test_no_two_settings_of_a_node_share_a_name():
    """A node takes the section of all nodes and its own."""
    everywhere = [rule.name for rule in GENERATED['rules'](SECTIONS['/**'])]
    for node, section in SECTIONS.items():
        if node != '/**':
            names = everywhere + [rule.name for rule in GENERATED['rules'](section)]
            assert len(names) == len(set(names)), node


def test_the_norms_have_no_default():
    assert {'norms.sigma_max_deg', 'norms.sigma_ref_max_deg'}.isdisjoint(read('/**'))


CLASSES = [chapter[-1] for name in ('CHAPTERS', 'SCENARIO_CHAPTERS')
           for chapter in GENERATED[name]]


@pytest.mark.parametrize('settings', CLASSES)
def test_every_default_keeps_to_its_own_rule(settings):
    assert from_mapping(settings, to_mapping(settings())) == settings()


@pytest.mark.parametrize('settings', CLASSES)
def test_every_setting_says_what_it_means_and_in_which_unit(settings):
    for rule in list_settings(settings):
        assert rule.help and not rule.help.endswith('.'), rule.name
        unit = rule.name.rpartition('_')[2]
        if unit in ('s', 'ns', 'deg', 'hz') and {float, int} & set(rule.kinds):
            assert re.search(rf'\[[^]]*\b{unit}\]', rule.help, re.IGNORECASE), rule.name


@pytest.mark.parametrize('given, message', [
    ({'norms': {'sigma_max_deg': 0.2}, 'norms.sigma_max_deg': 0.3},
     'norms.sigma_max_deg is given twice'),
    ({'norms': {'sigma_max': 0.2}}, "unknown setting 'norms.sigma_max'; did you mean"),
    ({'pairing.max_gap_s': -1}, 'pairing.max_gap_s = -1.0: must be a number from 0 to 3600'),
    ({'variant': 'D'}, "variant = 'D': must be 'A' or 'B' or 'C'"),
    ({'window_s': 'long'}, "window_s = 'long': must be a number of at least 1"),
    ({'sequential.looks': 2.5}, 'sequential.looks = 2.5: must be an integer from 2 to 20'),
    ({'window_s': True}, 'window_s = True'),
    *(({'trial.issue_date': day}, f'trial.issue_date = {day!r}: must be a date from 1970 to 2261, '
       'YYYY-MM-DD') for day in ('5 March', '', '2026-02-30', '2026-3-05', '2026-W10-4',
                                 '05.03.2026', '20260305', 20260305, '1969-12-31', '2262-01-01',
                                 '2026-03-05 ', '\u0662026-03-05')),
    ({'trial.sea_state': 10}, 'trial.sea_state = 10: must be an integer from 0 to 9 or text'),
    ({'trial.ts_calibration_months': 0}, 'trial.ts_calibration_months = 0: must be an integer'),
])
def test_a_wrong_setting_is_refused_by_name_value_and_what_is_allowed(given, message):
    with pytest.raises(SettingsError) as error:
        Settings.from_mapping(given)
    assert message in str(error.value)


@pytest.mark.parametrize('name, given, read', [
    ('trial.issue_date', '2028-02-29', '2028-02-29'), ('trial.issue_date', 'none', None),
    ('trial.sea_state', 0, 0), ('trial.sea_state', '3 to 4', '3 to 4'),
    ('trial.temperature_c', 20, 20.0), ('trial.temperature_c', '18 to 22', '18 to 22'),
    ('trial.ts_calibration_months', 12.0, 12), ('trial.deviations', 'none', 'none')])
def test_a_name_of_a_trial_may_be_a_date_a_figure_or_words(name, given, read):
    assert Settings.from_mapping({name: given}).to_mapping()[name] == read


def test_nested_and_dotted_names_mean_the_same_and_an_integer_is_a_number():
    nested = Settings.from_mapping({'norms': {'sigma_max_deg': 1}, 'window_s': 60})
    dotted = Settings.from_mapping({'norms.sigma_max_deg': 1.0, 'window_s': 60.0})
    assert nested == dotted
    assert type(nested.window_s) is float


def test_settings_are_made_by_keyword_and_checked():
    made = Settings(norms=Norms(sigma_max_deg=0.3, sigma_ref_max_deg=1), risk=Risk(
        sensor_class='ins'), variant='C')
    assert made == Settings.from_mapping({
        'norms': {'sigma_max_deg': 0.3, 'sigma_ref_max_deg': 1.0},
        'risk.sensor_class': 'ins', 'variant': 'C'})
    # An error that names a group also names its settings: the user sees what exists.
    for group in (Settings, Norms, Risk):
        assert [*signature(group).parameters] == [f.name for f in fields(group)]


@pytest.mark.parametrize('make, words', [
    (lambda: Norms(sigma_max_deg=-0.1), r'sigma_max_deg = -0.1: must be a number of at least 0'),
    (lambda: Risk(sensor_class='gyro'), "sensor_class = 'gyro': must be 'gyrocompass' or "),
    (lambda: Settings(norms={'sigma_max_deg': 0.3}),
     r"norms = {'sigma_max_deg': 0.3}: must be Norms\(...\); from_mapping takes mappings"),
    (lambda: Settings(norms=None), r'norms = None: must be Norms\(...\)'),
    (lambda: Settings(risk=Norms()), r'risk = Norms\(.*\): must be Risk\(...\)')])
def test_what_is_given_by_keyword_is_refused_by_name_and_value(make, words):
    with pytest.raises(SettingsError, match=words):
        make()


def test_ros_reads_the_parameter_file_as_the_command_line_does():
    rclpy = pytest.importorskip('rclpy')
    from rclpy.node import Node
    context = rclpy.Context()
    rclpy.init(context=context, args=[])
    try:
        for name in ('recorder', 'ts_driver'):
            node = Node(name, context=context, start_parameter_services=False,
                        automatically_declare_parameters_from_overrides=True,
                        cli_args=['--ros-args', '--params-file', str(YAML)])
            found = {n: p.value for n, p in node.get_parameters_by_prefix('').items()}
            node.destroy_node()
            expected = {**read('/**'), **read(name)}
            assert {n: found.get(n) for n in expected} == expected
            assert {n for n in expected if type(found[n]) is not type(expected[n])} == set()
    finally:
        context.try_shutdown()


def test_keywords_name_settings_by_their_last_part_or_in_whole():
    settings = Settings.of(sigma_max_deg=0.2, norms_sigma_ref_max_deg=0.1, ts_topic='gyro',
                           risk_min_duration_s=1200.0, runs={'gap_s': 5.0},
                           detectors=Settings().detectors)
    assert settings == Settings.from_mapping({
        'norms.sigma_max_deg': 0.2, 'norms.sigma_ref_max_deg': 0.1, 'ts_topic': 'gyro',
        'risk.min_duration_s': 1200.0, 'runs.gap_s': 5.0})
    assert Settings.of() == Settings()


def test_every_setting_has_a_keyword_of_its_own():
    for name, value in Settings().to_mapping().items():
        assert Settings.of(**{name.replace('.', '_'): value}) == Settings()


@pytest.mark.parametrize('given, words', [
    ({'sigma_max': 0.2}, "unknown setting 'sigma_max'; did you mean 'sigma_max_deg'?"),
    ({'norm': {}}, "unknown setting 'norm'; did you mean 'norms'?"),
    ({'norms': {'m_lo': 1.0}}, "unknown setting 'norms.m_lo'; did you mean 'norms.m_low'?"),
    ({'min_duration_s': 9.0}, "setting 'min_duration_s' is in several groups: "
     'give runs_min_duration_s or risk_min_duration_s'),
    ({'m_low': 0.1, 'norms_m_low': 0.2}, 'norms.m_low is given twice'),
    ({'norms': 0.2}, 'norms = 0.2: must be Norms(...) or a mapping'),
    ({'norms': Risk()}, 'norms = Risk('),
    ({'sigma_max_deg': -1.0}, 'norms.sigma_max_deg = -1.0: must be ')])
def test_a_wrong_keyword_is_refused_in_one_line(given, words):
    with pytest.raises(SettingsError) as refused:
        Settings.of(**given)
    assert str(refused.value).startswith(words) and '\n' not in str(refused.value)


@pytest.mark.parametrize('text, value', [
    ('3', 3), ('3 to 4', '3 to 4'), ('', ''), ('swell: 2 m, #3', 'swell: 2 m, #3'),
    ('3: 4', '3: 4'), ('off', 'off'), ('1_0', '1_0'), ('[3]', '[3]')])
def test_a_figure_or_words_are_read_from_the_command_line_as_they_stand(text, value):
    assert settings_for(Config(), [f'trial.sea_state={text}']).trial.sea_state == value


@pytest.mark.parametrize('name, value', Settings.REMOVED.items())
def test_a_removed_setting_may_be_stated_with_its_value_and_no_other(name, value, tmp_path):
    path = tmp_path / 'old.yaml'
    path.write_text(f'/**:\n  ros__parameters:\n    {name}: {value!r}\n')
    assert settings_for(load_config(str(path))) == Settings()
    assert settings_for(load_config(None), [f'{name}={value}']) == Settings()
    for wrong in (0.7, 'none', True):
        with pytest.raises(SettingsError, match=f'^{name} = .*was removed.* always {value!r}; '):
            Settings.from_mapping({name: wrong})
        with pytest.raises(SettingsError, match='was removed'):
            settings_for(load_config(None), [f'{name}={wrong}'])


def test_a_mapping_keeps_the_removed_names_so_that_hashes_stay():
    mapping = Settings().to_mapping()
    assert Settings.REMOVED.items() <= mapping.items()
    assert {rule.name for rule in list_settings(Settings)} == {*mapping} - {*Settings.REMOVED}
    assert Settings.from_mapping(mapping) == Settings()


def test_the_settings_that_a_user_needs_are_ten_and_stand_first():
    text = (ROOT / 'docs' / 'settings.md').read_text('utf-8')
    rows = [line.split('`')[1] for line in text.splitlines() if line.startswith('| `')]
    assert tuple(rows[:10]) == tuple(Settings.NEEDED)
    head, _, _ = (ROOT / 'config' / 'heading_intercompare.yaml').read_text('utf-8').partition(
        '/**')
    assert all(f'#   {name}\n' in head for name in Settings.NEEDED)
