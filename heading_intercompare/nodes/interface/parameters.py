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

"""Settings classes as ROS parameters: described, checked, unknown names rejected."""

from __future__ import annotations

from functools import partial
import math
from typing import Any, Callable, Mapping, Sequence

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.node import Node
from rclpy.parameter import Parameter

from heading_intercompare.bags.errors import utf8
from heading_intercompare.core.declared_settings import (
    drop_removed,
    explain_unknown,
    from_mapping,
    list_settings,
    Setting,
    SettingsError,
    to_mapping,
    Used,
)

#: Parameters hold integers of 64 bits.
_MOST = 2**63 - 1
_READ_ONCE = 'read when the node starts: start it again to change it'
_FOLLOWED = 'a change takes effect at once, and is said in the log, the bag and the verdict'

OF_ROS = ('use_sim_time', 'start_type_description_service')
"""Parameters that every rclpy node declares."""


def declare(node: Node, *classes: type | Used,
            followed: Sequence[str] = ()) -> tuple[Any, ...]:
    """
    Declare the settings of a node as parameters, and return them.

    Parameters
    ----------
    node
        A `GraphNode`.
    *classes
        Settings classes without a setting name in common.
    followed
        Settings that can be changed while the node runs; see `follow`. All others are read-only.

    Returns
    -------
    tuple
        An instance of each class.

    Raises
    ------
    SettingsError
        For a name that no class declares, or a value that is not allowed.

    """
    # The declared type of the parameters is that of their values.
    parameters: Mapping[str, Any] = node.get_parameters_by_prefix('')
    values = {name: parameter.value for name, parameter in parameters.items()
              if name not in OF_ROS}
    rules = {used: {rule.name: rule for rule in list_settings(used.settings_class)}
             for used in (settings_class if isinstance(settings_class, Used)
                          else Used(settings_class) for settings_class in classes)}
    current = values
    for used in rules:
        current = drop_removed(used.settings_class, current)
    for name in values.keys() - current.keys():
        node.undeclare_parameter(name)
    values, declared = current, [name for names in rules.values() for name in names]
    for name in values:
        if name not in declared:
            raise explain_unknown('parameter', name, declared)
    instances = []
    for used, names in rules.items():
        settings = from_mapping(used.settings_class,
                                {n: v for n, v in values.items() if n in names})
        for name, value in to_mapping(settings).items():
            if name in values:
                node.undeclare_parameter(name)
            if not used.has(name):
                continue
            rule = names[name]
            node.declare_parameter(
                name, 'none' if value is None else value,
                ParameterDescriptor(
                    description=str(rule.help), read_only=name not in followed,
                    additional_constraints=f'{rule.allowed}; '
                    f'{_FOLLOWED if name in followed else _READ_ONCE}',
                    dynamic_typing=True, **_find_range(rule)), ignore_override=True)
        instances.append(settings)
    owners = {name: used.settings_class for used, names in rules.items()
              for name in names if name in followed}
    if owners:
        node.add_on_set_parameters_callback(partial(_check, owners))
    return tuple(instances)


def _check(owners: Mapping[str, type], parameters: Sequence[Parameter]) -> SetParametersResult:
    """Tell whether new values are allowed, in the words of a wrong setting."""
    try:
        for parameter in parameters:
            if parameter.name in owners:
                from_mapping(owners[parameter.name], {parameter.name: parameter.value})
    except SettingsError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)


def follow(node: Node, name: str, change: Callable[[Any], object]) -> None:
    """Call a function with the new value when a followed parameter of a node is changed."""
    def pass_on(parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == name:
                change(parameter.value)
    node.add_post_set_parameters_callback(pass_on)


def _find_range(rule: Setting) -> dict[str, Any]:
    """Return the range of a setting that is a number and nothing else; nothing for others."""
    if rule.lo is None and rule.hi is None:
        return {}
    if rule.kinds == (float,):
        return {'floating_point_range': [FloatingPointRange(
            from_value=-math.inf if rule.lo is None else float(rule.lo),
            to_value=math.inf if rule.hi is None else float(rule.hi))]}
    if rule.kinds == (int,):
        return {'integer_range': [IntegerRange(
            from_value=-_MOST - 1 if rule.lo is None else int(rule.lo),
            to_value=_MOST if rule.hi is None else int(rule.hi))]}
    return {}


def resolve_topic(node: Node, topic: str) -> str:
    """Return the full name of a topic after remapping; SettingsError if it is not valid."""
    try:
        return node.resolve_topic_name(topic)
    except RuntimeError as error:
        reason = str(error).partition(': ')[2].partition(', at ')[0]
        raise SettingsError(f'topic {topic!r}: {reason}') from error


def make_overrides(values: Mapping[str, Any]) -> list[Parameter]:
    """Return values, by dotted name, as `parameter_overrides` of a node; None is skipped."""
    parameters = {name: value for name, value in values.items() if value is not None}
    for name, value in parameters.items():
        if isinstance(value, str):
            utf8(value, name)
    return [Parameter(name, value=value) for name, value in parameters.items()]
