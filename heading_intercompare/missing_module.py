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

"""What to install where a module is missing, in one line."""

from __future__ import annotations

_OF_ROS = {'rclpy', 'sensor_msgs', 'geometry_msgs', 'nav_msgs', 'std_msgs', 'std_srvs',
           'diagnostic_msgs', 'rosgraph_msgs', 'rcl_interfaces', 'builtin_interfaces'}
# What is needed without any extra: name of the module, and of its package.
_ALWAYS = {'numpy': 'numpy', 'scipy': 'scipy', 'yaml': 'pyyaml'}
_OF_BAGS = ('mcap', 'lz4', 'zstandard')


def explain_missing(error: ModuleNotFoundError) -> str | None:
    """
    Say what to install.

    Parameters
    ----------
    error
        As raised by the import.

    Returns
    -------
    str or None
        What is missing and how to get it; None for a module that this package does not name.

    Examples
    --------
    >>> explain_missing(ModuleNotFoundError(name='mcap.opcode'))
    'bags need the module mcap: python3 -m pip install mcap lz4 zstandard'

    """
    module = (error.name or '').partition('.')[0]
    if module in _OF_ROS:
        return (f'this needs ROS 2 (no module {module}): install '
                'heading_intercompare[ros], or source a ROS 2 Jazzy environment')
    if module in _OF_BAGS:
        return f'bags need the module {module}: python3 -m pip install {" ".join(_OF_BAGS)}'
    if module in _ALWAYS:
        return f'the module {module} is missing: python3 -m pip install {_ALWAYS[module]}'
    return None
