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

"""Settings as parameters of a node."""

from __future__ import annotations

import pytest
from rclpy.parameter import Parameter

from heading_intercompare.bags.settings import BagSettings
from heading_intercompare.core.declared_settings import list_settings, SettingsError, to_mapping
from heading_intercompare.core.settings import Settings
from heading_intercompare.nodes.interface.parameters import declare, follow, make_overrides
from heading_intercompare.nodes.presence.graph_node import GraphNode
from heading_intercompare.nodes.settings import PAIRED, PUBLISHED, REPLAYED, SHOWN


def node_with(ros, values):
    """Return a node that was given values."""
    return ros.add(GraphNode, 'settings_node', parameter_overrides=make_overrides(values))


def test_without_values_all_take_their_defaults(ros):
    assert declare(node_with(ros, {}), Settings, BagSettings) == (Settings(), BagSettings())


def test_every_setting_becomes_a_described_read_only_parameter(ros):
    node = node_with(ros, {'norms.sigma_max_deg': 0.2})
    settings, = declare(node, Settings)
    for rule in list_settings(Settings):
        descriptor = node.describe_parameter(rule.name)
        assert descriptor.read_only and descriptor.description == rule.help
        value = to_mapping(settings)[rule.name]
        assert node.get_parameter(rule.name).value == ('none' if value is None else value)


@pytest.mark.parametrize('name, kind, lo, hi', [
    ('window_s', 'floating_point_range', 1.0, None), ('runs.keep', 'integer_range', 1, None),
    ('ts_topic', None, None, None), ('sequential.plan_s', None, None, None)])
def test_a_number_has_its_range_and_every_parameter_says_when_it_is_read(ros, name, kind, lo, hi):
    node = node_with(ros, {})
    declare(node, Settings)
    rule, = (one for one in list_settings(Settings) if one.name == name)
    descriptor = node.describe_parameter(name)
    assert 'read when the node starts' in descriptor.additional_constraints
    for field in ('floating_point_range', 'integer_range'):
        ranges = getattr(descriptor, field)
        assert len(ranges) == (field == kind)
        if field == kind:
            assert ranges[0].from_value == rule.lo
            assert ranges[0].to_value >= (rule.hi or rule.lo)


def test_only_what_a_node_uses_becomes_a_parameter_and_all_of_it_is_checked(ros):
    """A driver had 62 parameters, most of them of the judgement."""
    given = {'norms.sigma_max_deg': 0.2, 'motion.compare': False}
    node = node_with(ros, given)
    settings, = declare(node, PUBLISHED)
    assert settings == Settings.from_mapping(given)
    names = {*node.get_parameters_by_prefix('')} - {'use_sim_time',
                                                    'start_type_description_service'}
    assert names == {'ts_topic', 'rs_topic', 'sensors', *(
        rule.name for rule in list_settings(Settings) if rule.name.startswith('motion.'))}
    assert not node.get_parameter('motion.compare').value
    for wrong in ({'norms.sigma_max': 0.2}, {'norms.sigma_max_deg': -1.0}):
        with pytest.raises(SettingsError):
            declare(node_with(ros, wrong), PUBLISHED)


def test_a_removed_setting_is_no_parameter_and_may_only_have_its_value(ros):
    node = node_with(ros, {'detectors.lost_void': 0.5, 'window_s': 60.0})
    settings, = declare(node, Settings)
    assert settings == Settings(window_s=60.0) and not node.has_parameter('detectors.lost_void')
    with pytest.raises(SettingsError, match='detectors.lost_void = 0.7: this setting was removed'):
        declare(node_with(ros, {'detectors.lost_void': 0.7}), Settings)


@pytest.mark.parametrize('used', [PUBLISHED, REPLAYED, PAIRED, SHOWN])
def test_what_is_used_is_there(used):
    known = {rule.name for rule in list_settings(Settings)}
    assert all(name in known or any(one.startswith(f'{name}.') for one in known)
               for name in used.names)


def test_an_integer_is_taken_for_a_real(ros):
    node = node_with(ros, {'norms.sigma_max_deg': 1})
    settings, = declare(node, Settings)
    assert type(settings.norms.sigma_max_deg) is float
    assert node.get_parameter('norms.sigma_max_deg').type_ is Parameter.Type.DOUBLE


@pytest.mark.parametrize('value', ['auto', 30.0, 30])
def test_a_setting_may_be_of_two_types(ros, value):
    settings, = declare(node_with(ros, {'runs.stabilization_s': value}), Settings)
    assert settings.runs.stabilization_s == value


def test_none_may_be_given_as_a_word(ros):
    settings, = declare(node_with(ros, {'sequential.plan_s': 'none'}), Settings)
    assert settings.sequential.plan_s is None


@pytest.mark.parametrize('values, message', [
    ({'norms.sigma_max': 0.2}, "unknown parameter 'norms.sigma_max'; did you mean "
                               "'norms.sigma_max_deg'?"),
    ({'chunk_byte': 4096}, "unknown parameter 'chunk_byte'; did you mean 'chunk_bytes'?"),
    ({'variant': 'D'}, "variant = 'D': must be 'A' or 'B' or 'C'"),
    ({'window_s': 'long'}, "window_s = 'long': must be a number"),
    ({'window_s': [1.0, 2.0]}, 'window_s = '),
    ({'norms.probability': float('nan')}, 'norms.probability = nan'),
])
def test_a_mistake_is_refused_in_one_line(ros, values, message):
    with pytest.raises(SettingsError) as error:
        declare(node_with(ros, values), Settings, BagSettings)
    assert message in str(error.value) and '\n' not in str(error.value)


def test_a_parameter_cannot_be_changed_while_the_node_runs(ros):
    node = node_with(ros, {})
    declare(node, Settings)
    result, = node.set_parameters([Parameter('window_s', value=60.0)])
    assert not result.successful
    assert node.get_parameter('window_s').value == 600.0


def test_a_parameter_that_is_followed_changes_while_the_node_runs(ros):
    node, found = node_with(ros, {}), []
    declare(node, Settings, followed=('window_s',))
    follow(node, 'window_s', found.append)
    descriptor = node.describe_parameter('window_s')
    assert not descriptor.read_only and 'takes effect at once' in descriptor.additional_constraints
    result, = node.set_parameters([Parameter('window_s', value=60.0)])
    assert result.successful and found == [60.0]
    for wrong in (0.5, 'long'):
        result, = node.set_parameters([Parameter('window_s', value=wrong)])
        assert not result.successful and 'window_s' in result.reason
    assert found == [60.0] and node.get_parameter('window_s').value == 60.0
    result, = node.set_parameters([Parameter('variant', value='A')])
    assert not result.successful


def test_parameters_of_ros_itself_are_not_unknown(ros):
    settings, = declare(node_with(ros, {'use_sim_time': True}), Settings)
    assert settings == Settings()


def test_none_is_left_out_of_overrides():
    assert [p.name for p in make_overrides({'a': None, 'b': 1})] == ['b']
